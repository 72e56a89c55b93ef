"""The subcommands in process: output, warnings on standard error, and the status that each mistake ends with."""

import json
import shutil

import numpy as np
import pytest

from tests.command_line import call
from tests.examples import DATA

from .samples import LNP, ltv, sbd, sbm


def array(result):
    found = json.loads(result.out)
    return np.array(found["data"], dtype=float).reshape(found["shape"])


def test_getfrsbf_json_is_the_array(tmp_path):
    path = sbd(tmp_path / "a.sbd")
    np.testing.assert_array_equal(array(call("getfrsbf", path, "lnp", "--json")), LNP)
    dx = np.arange(6.0).reshape(3, 2)
    np.testing.assert_array_equal(array(call("getfrsbf", path, "DX", "2", "--json")), dx + 10)
    every = array(call("getfrsbf", tmp_path / "a", "dx", "--json"))
    np.testing.assert_array_equal(every[2].reshape(3, 2, order="F"), dx + 20)
    found = json.loads(call("getfrsbf", path, "fxtot", "--json").out)
    assert (found["id"], found["shape"]) == ("FXT", [3, 3])
    assert json.loads(call("getfrsbf", path, "etype", "--json").out)["data"] == ["PLBEAM", "PLTRUSS"]
    np.testing.assert_array_equal(array(call("getfrsbf", sbm(tmp_path / "a.sbm"), "lmult", "--json")), [[np.inf], [-2]])


def test_getfrsbf_prints_rows_with_all_digits(tmp_path):
    path = sbd(tmp_path / "a.sbd")
    assert call("getfrsbf", path, "t").out.split() == ["0.0", "0.1", "0.2"]
    assert call("getfrsbf", path, "x", "2:end").out.splitlines() == ["1.0 2.0 3.0", "2.0 3.0 4.0"]
    assert call("getfrsbf", path, "tdef").out == "3\n"


@pytest.mark.parametrize("words", [("x", "9"), ("x", "a"), ("nothing",), ("lnp", "1")])
def test_getfrsbf_mistakes_are_usage_errors(tmp_path, words):
    path = sbd(tmp_path / "a.sbd")
    assert call.refused("getfrsbf", path, *words)


def test_checksbf_and_its_exit_statuses(tmp_path):
    path = sbd(tmp_path / "a.sbd")
    assert "all checksums are right" in call.done("checksbf", path).out
    assert json.loads(call("checksbf", path, "--json").out)["steps"] == 3
    raw = bytearray(path.read_bytes())
    raw[-30] ^= 1
    path.write_bytes(raw)
    bad = call("checksbf", path)
    assert bad.status == 1
    assert "step 3" in bad.out
    path.write_bytes(raw[:100])
    assert call("checksbf", path).status == 1
    assert call.refused("checksbf", tmp_path / "none")


def test_every_tool_says_that_a_file_is_incomplete(tmp_path):
    raw = bytearray(sbd(tmp_path / "a.sbd").read_bytes())
    raw[13] = 2
    (tmp_path / "a.sbd").write_bytes(raw)
    text = "incomplete: stopped after step 3 at t = 0.2"
    runs = [("getfrsbf", "x"), ("repinsbf", "mode", "2"), ("loadsbd",), ("checksbf",)]
    for name, *words in runs:
        result = call.done(name, tmp_path / "a.sbd", *words)
        assert text in result.out + result.err
    assert text in call("combsbd", tmp_path / "a", tmp_path / "a", tmp_path / "b").err


def test_repinsbf_takes_json_and_negative_numbers(tmp_path):
    path = sbd(tmp_path / "a.sbd")
    call.done("repinsbf", path, "t", "-2.5", "--at", "2")
    call.done("repinsbf", path, "x", "[7, 8, -9]", "--at", "1")
    assert call("getfrsbf", path, "t").out.split() == ["0.0", "-2.5", "0.2"]
    assert call("getfrsbf", path, "x", "1").out.split() == ["7.0", "8.0", "-9.0"]
    for words in (("x", "[1"), ("x", "[1,2]"), ("x", "{}", "--at", "1"), ("x", "null", "--at", "1"), ("y", "1")):
        assert call.refused("repinsbf", path, *words)


def test_load_commands_write_the_formats_asked_for(tmp_path):
    sbd(tmp_path / "a.sbd")
    sbm(tmp_path / "a.sbm")
    call.done("loadsbd", tmp_path / "a", "--to", "mat", "--to", "csv")
    call.done("loadsbm", tmp_path / "a", "m0", "-o", tmp_path / "m.npz")
    names = {"a.sbd", "a.sbm", "a.sbd.mat", "a.sbd.csv", "a.sbd.header.csv", "m.npz"}
    assert {p.name for p in tmp_path.iterdir()} == names
    with np.load(tmp_path / "m.npz") as got:
        assert list(got) == ["m0"]


def test_combsbd_and_getss(tmp_path):
    sbd(tmp_path / "a.sbd")
    ltv(tmp_path / "a.ltv")
    assert "6 steps" in call("combsbd", tmp_path / "a", tmp_path / "a", tmp_path / "b").out
    assert call.refused("combsbd", tmp_path / "a", tmp_path / "a", tmp_path / "b")
    call.done("combsbd", "--overwrite", tmp_path / "a", tmp_path / "a", tmp_path / "b")
    assert "A (2 x 2):\n0.0 1.0\n-4.0 -0.1" in call("getss", tmp_path / "a").out
    assert json.loads(call("getss", tmp_path / "a", 2, "--json").out)["t"] == 0.5
    call.done("getss", tmp_path / "a", "-o", tmp_path / "ss.mat")
    assert (tmp_path / "ss.mat").exists()


def test_eigenvalues_of_a_tricycle_can_be_read(tmp_path):
    """M0 2 x 2 beside K0 2 x 7, as wheels do not hold positions: a right file, nine eigenvalues."""
    shutil.copy(DATA / "trike2.dat", tmp_path)
    call.done("7", tmp_path / "trike2")
    assert len(call.done("getfrsbf", tmp_path / "trike2.sbm", "eigval").out.strip().splitlines()) >= 9
