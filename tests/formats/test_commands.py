"""The subcommands in process: output, warnings on standard error, and which error each mistake raises."""

import json
from io import StringIO
from types import SimpleNamespace

import click
import numpy as np
import pytest
from click.testing import CliRunner
from spacar_cli.environment import Environment
from spacar_cli.main import program

from spacar.errors import AnalysisError, UsageError

from .samples import LNP, ltv, sbd, sbm


def call(name, *words):
    command = program.get_command(click.Context(program), name)
    env = Environment(StringIO(), StringIO(), StringIO(), {})
    done = CliRunner().invoke(command, [str(w) for w in words], obj=env)
    return SimpleNamespace(
        exit_code=done.exit_code, exception=done.exception, stdout=env.stdout.getvalue(), stderr=env.stderr.getvalue()
    )


def array(result):
    found = json.loads(result.stdout)
    return np.array(found["data"], dtype=float).reshape(found["shape"])


def test_getfrsbf_json_is_the_array(tmp_path):
    path = sbd(tmp_path / "a.sbd")
    np.testing.assert_array_equal(array(call("getfrsbf", path, "lnp", "--json")), LNP)
    dx = np.arange(6.0).reshape(3, 2)
    np.testing.assert_array_equal(array(call("getfrsbf", path, "DX", "2", "--json")), dx + 10)
    every = array(call("getfrsbf", tmp_path / "a", "dx", "--json"))
    np.testing.assert_array_equal(every[2].reshape(3, 2, order="F"), dx + 20)
    found = json.loads(call("getfrsbf", path, "fxtot", "--json").stdout)
    assert (found["id"], found["shape"]) == ("FXT", [3, 3])
    assert json.loads(call("getfrsbf", path, "etype", "--json").stdout)["data"] == ["PLBEAM", "PLTRUSS"]
    np.testing.assert_array_equal(array(call("getfrsbf", sbm(tmp_path / "a.sbm"), "lmult", "--json")), [[np.inf], [-2]])


def test_getfrsbf_prints_rows_with_all_digits(tmp_path):
    path = sbd(tmp_path / "a.sbd")
    assert call("getfrsbf", path, "t").stdout.split() == ["0.0", "0.1", "0.2"]
    assert call("getfrsbf", path, "x", "2:end").stdout.splitlines() == ["1.0 2.0 3.0", "2.0 3.0 4.0"]
    assert call("getfrsbf", path, "tdef").stdout == "3\n"


@pytest.mark.parametrize("words", [("x", "9"), ("x", "a"), ("nothing",), ("lnp", "1")])
def test_getfrsbf_mistakes_are_usage_errors(tmp_path, words):
    path = sbd(tmp_path / "a.sbd")
    assert isinstance(call("getfrsbf", path, *words).exception, UsageError)


def test_checksbf_and_its_exit_statuses(tmp_path):
    path = sbd(tmp_path / "a.sbd")
    good = call("checksbf", path)
    assert good.exit_code == 0
    assert "all checksums are right" in good.stdout
    assert json.loads(call("checksbf", path, "--json").stdout)["steps"] == 3
    raw = bytearray(path.read_bytes())
    raw[-30] ^= 1
    path.write_bytes(raw)
    bad = call("checksbf", path)
    assert isinstance(bad.exception, AnalysisError)
    assert "step 3" in bad.stdout
    path.write_bytes(raw[:100])
    assert call("checksbf", path).exception.exit_status == 1
    assert call("checksbf", tmp_path / "none").exception.exit_status == 2


def test_every_tool_says_that_a_file_is_incomplete(tmp_path):
    raw = bytearray(sbd(tmp_path / "a.sbd").read_bytes())
    raw[13] = 2
    (tmp_path / "a.sbd").write_bytes(raw)
    text = "incomplete: stopped after step 3 at t = 0.2"
    runs = [("getfrsbf", "x"), ("repinsbf", "mode", "2"), ("loadsbd",), ("checksbf",)]
    for name, *words in runs:
        result = call(name, tmp_path / "a.sbd", *words)
        assert result.exit_code == 0
        assert text in result.stdout + result.stderr
    assert text in call("combsbd", tmp_path / "a", tmp_path / "a", tmp_path / "b").stderr


def test_repinsbf_takes_json_and_negative_numbers(tmp_path):
    path = sbd(tmp_path / "a.sbd")
    assert call("repinsbf", path, "t", "-2.5", "--at", "2").exit_code == 0
    assert call("repinsbf", path, "x", "[7, 8, -9]", "--at", "1").exit_code == 0
    assert call("getfrsbf", path, "t").stdout.split() == ["0.0", "-2.5", "0.2"]
    assert call("getfrsbf", path, "x", "1").stdout.split() == ["7.0", "8.0", "-9.0"]
    for words in (("x", "[1"), ("x", "[1,2]"), ("x", "{}", "--at", "1"), ("x", "null", "--at", "1"), ("y", "1")):
        assert isinstance(call("repinsbf", path, *words).exception, UsageError)


def test_load_commands_write_the_formats_asked_for(tmp_path):
    sbd(tmp_path / "a.sbd")
    sbm(tmp_path / "a.sbm")
    assert call("loadsbd", tmp_path / "a", "--to", "mat", "--to", "csv").exit_code == 0
    assert call("loadsbm", tmp_path / "a", "m0", "-o", tmp_path / "m.npz").exit_code == 0
    names = {"a.sbd", "a.sbm", "a.sbd.mat", "a.sbd.csv", "a.sbd.header.csv", "m.npz"}
    assert {p.name for p in tmp_path.iterdir()} == names
    with np.load(tmp_path / "m.npz") as got:
        assert list(got) == ["m0"]


def test_combsbd_and_getss(tmp_path):
    sbd(tmp_path / "a.sbd")
    ltv(tmp_path / "a.ltv")
    assert "6 steps" in call("combsbd", tmp_path / "a", tmp_path / "a", tmp_path / "b").stdout
    assert isinstance(call("combsbd", tmp_path / "a", tmp_path / "a", tmp_path / "b").exception, UsageError)
    assert call("combsbd", "--overwrite", tmp_path / "a", tmp_path / "a", tmp_path / "b").exit_code == 0
    assert "A (2 x 2):\n0.0 1.0\n-4.0 -0.1" in call("getss", tmp_path / "a").stdout
    assert json.loads(call("getss", tmp_path / "a", 2, "--json").stdout)["t"] == 0.5
    assert call("getss", tmp_path / "a", "-o", tmp_path / "ss.mat").exit_code == 0
    assert (tmp_path / "ss.mat").exists()
