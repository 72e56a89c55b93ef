"""The utilities of reference/files.md 7: values, shapes, refusals; no file is changed in place."""

import json
import subprocess
import sys

import numpy as np
import pytest
from scipy.io import loadmat
from spacar_formats import exports, safety
from spacar_formats.checksbf import checksbf, listing
from spacar_formats.combsbd import combsbd
from spacar_formats.exports import export_file
from spacar_formats.getfrsbf import getfrsbf, step_numbers
from spacar_formats.getss import export_getss, getss
from spacar_formats.loadsbd import loadsbd, loadsbm
from spacar_formats.locate import digest, notes, result_path
from spacar_formats.repinsbf import repinsbf
from spacar_formats.safety import Claim
from spacar_formats.sbf import SbfError, SbfFile, SbfWriter

from spacar.errors import AnalysisError, UsageError

from .samples import LNP, M, ltv, sbd, sbm


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("3", 3), ("end", 9), ("2:4", [2, 3, 4]), ("1:4:end", [1, 5, 9]), ("1,4, 9", [1, 4, 9]), ("8:end,1", [8, 9, 1]),
        ("-1", 9), ("-2:end", [8, 9]),
    ],
)  # fmt: skip
def test_step_numbers_as_in_matlab(text, numbers):
    assert step_numbers(text, 9) == numbers


@pytest.mark.parametrize("text", ["", "x", "1:", "0:3", "3:2", "1:0:5", "2:10", "1;2", "-10", "1:10000000000000"])
def test_wrong_step_numbers_are_usage_errors(text):
    with pytest.raises(UsageError):
        step_numbers(text, 9)


def test_names_with_and_without_extension(tmp_path):
    sbd(tmp_path / "a.sbd")
    sbm(tmp_path / "a.sbm")
    sbd(tmp_path / "a.2.sbd")
    assert result_path(tmp_path / "a") == tmp_path / "a.sbd"
    assert result_path(tmp_path / "a", "sbm") == tmp_path / "a.sbm"
    assert result_path(tmp_path / "a.2", "sbd") == tmp_path / "a.2.sbd"
    assert getfrsbf(tmp_path / "a.sbm", "m0").shape == (2, 2)
    assert getfrsbf(tmp_path / "a", "dx", "end").shape == (3, 2)
    with pytest.raises(UsageError, match=r"b\.sbd not found; any mode writes it: spacar MODE .*b"):
        getfrsbf(tmp_path / "b", "x")
    with pytest.raises(UsageError, match=r"is an \.sbm file"):
        loadsbd(tmp_path / "a.sbm")
    (tmp_path / "c.sbd.part").write_bytes(b"")
    with pytest.raises(UsageError, match=r"did not finish.*c\.sbd\.part"):
        getfrsbf(tmp_path / "c", "x")


def test_loadsbd_gives_matlab_names_and_loadsbm_the_matrices(tmp_path):
    sbd(tmp_path / "a.sbd")
    sbm(tmp_path / "a.sbm")
    got = loadsbd(tmp_path / "a")
    assert list(got) == ["mode", "nx", "lnp", "estiff", "etype", "time", "x", "fxtot", "dx"]
    assert got["x"].shape == (3, 3)
    assert got["etype"].tolist() == ["PLBEAM", "PLTRUSS"]
    np.testing.assert_array_equal(loadsbm(tmp_path / "a")["m0"], M)
    assert list(loadsbd(tmp_path / "a", ["time", "STIF"])) == ["time", "estiff"]


def test_mat_file_has_what_a_matlab_user_expects(tmp_path):
    sbd(tmp_path / "many.sbd", steps=3)
    sbd(tmp_path / "one.sbd", steps=1)
    export_file(tmp_path / "many", "sbd", formats=["mat"])
    export_file(tmp_path / "one", "sbd", output=tmp_path / "one.mat")
    many, one = loadmat(tmp_path / "many.sbd.mat"), loadmat(tmp_path / "one.mat")
    assert {many[n].dtype for n in ("lnp", "mode", "x", "time")} == {np.dtype("float64")}
    np.testing.assert_array_equal(many["lnp"], LNP)
    assert many["mode"].shape == (1, 1)
    assert many["time"].shape == (3, 1)
    assert many["estiff"].shape == (1, 2)
    dx = np.arange(6.0).reshape(3, 2)
    np.testing.assert_array_equal(many["dx"][1], (dx + 10).ravel(order="F"))
    assert one["x"].shape == (3, 1)
    np.testing.assert_array_equal(one["dx"], dx)
    assert [str(line).rstrip() for line in many["etype"]] == ["PLBEAM", "PLTRUSS"]


def test_npz_and_csv_keep_every_digit(tmp_path):
    sbd(tmp_path / "a.sbd")
    written, _ = export_file(tmp_path / "a", "sbd", formats=["npz", "csv"])
    assert [p.name for p in written] == ["a.sbd.npz", "a.sbd.csv", "a.sbd.header.csv"]
    with np.load(written[0]) as got:
        assert got["lnp"].dtype == np.int64
        np.testing.assert_array_equal(got["time"], getfrsbf(tmp_path / "a", "t"))
    table = np.genfromtxt(written[1], delimiter=",", names=True)
    assert table.dtype.names == (
        "step", "time", "x_1", "x_2", "x_3", "fxtot_1", "fxtot_2", "fxtot_3",
        "dx_1_1", "dx_2_1", "dx_3_1", "dx_1_2", "dx_2_2", "dx_3_2",
    )  # fmt: skip
    np.testing.assert_array_equal(table["time"], getfrsbf(tmp_path / "a", "t")[:, 0])
    np.testing.assert_array_equal(table["dx_1_2"], getfrsbf(tmp_path / "a", "dx")[:, 3])
    header = written[2].read_text().splitlines()
    assert header[0] == "name,row,column,value"
    assert "lnp,2,1,3" in header
    assert "etype,2,1,PLTRUSS" in header


@pytest.mark.parametrize("at_once", [1, 20, 40, 10**6])
def test_csv_is_written_a_few_steps_at_a_time(tmp_path, monkeypatch, at_once):
    """The same file whatever is read at once: one of the three steps, two, all."""
    sbd(tmp_path / "a.sbd")
    whole = export_file(tmp_path / "a", "sbd", formats=["csv"])[0][0].read_bytes()
    monkeypatch.setattr(exports, "NUMBERS_AT_ONCE", at_once)
    assert export_file(tmp_path / "a", "sbd", formats=["csv"])[0][0].read_bytes() == whole
    assert len(whole.splitlines()) == 4


def test_csv_of_one_step_and_export_of_chosen_variables(tmp_path):
    sbm(tmp_path / "a.sbm")
    written, _ = export_file(tmp_path / "a", "sbm", ["m0", "time"], output=tmp_path / "a.csv")
    assert written[0].read_text().splitlines() == ["step,time,m0_1_1,m0_2_1,m0_1_2,m0_2_2", "1,0.0,1.0,3.0,2.0,4.0"]
    for wrong in (
        {"output": tmp_path / "a.xls"},
        {"output": tmp_path / "a.mat", "formats": ["mat"]},
        {"idents": ["y"]},
    ):
        with pytest.raises(UsageError):
            export_file(tmp_path / "a", "sbm", **wrong)


def test_repinsbf_replaces_exactly_one_value(tmp_path):
    path = sbd(tmp_path / "a.sbd", TITLE="some text")
    before = loadsbd(path)
    repinsbf(path, "x", [7.0, 8.0, 9.0], step=2)
    repinsbf(tmp_path / "a", "dx", -np.ones((3, 2)), step=3)
    repinsbf(path, "estiff", np.array([[2.5, 1.0]]))
    repinsbf(path, "mode", 4)
    repinsbf(path, "title", "short")
    after = loadsbd(path)
    assert checksbf(path).sound
    before["x"][1] = [7, 8, 9]
    before["dx"][2] = -1
    before["estiff"] = np.array([[2.5, 1.0]])
    before["mode"][:] = 4
    before["title"] = np.array(["short"])
    assert list(before) == list(after)
    for name, value in before.items():
        np.testing.assert_array_equal(after[name], value)


@pytest.mark.parametrize(
    ("ident", "value", "step"),
    [
        ("x", [1.0, 2.0], 1), ("x", [[1.0, 2.0, 3.0]], 1), ("x", [1.0, 2.0, 3.0], None), ("x", [1.0, 2.0, 3.0], 4),
        ("x", [1.0, 2.0, "a"], 1), ("x", [[1.0], [2.0, 3.0]], 1), ("lnp", LNP, 1), ("lnp", LNP.T, None),
        ("mode", 1.5, None), ("etype", ["PLBEAM"], None), ("etype", ["PLBEAM", "MUCHTOOLONG"], None),
        ("nothing", 1, None),
    ],
)  # fmt: skip
def test_repinsbf_refuses_and_leaves_the_file(tmp_path, ident, value, step):
    path = sbd(tmp_path / "a.sbd")
    before = path.read_bytes()
    with pytest.raises(UsageError):
        repinsbf(path, ident, value, step)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.sbd"]


def test_an_open_reader_keeps_the_old_bytes_while_a_value_is_replaced(tmp_path):
    path = sbd(tmp_path / "a.sbd")
    with SbfFile(path) as file:
        repinsbf(path, "x", [7.0, 8.0, 9.0], step=2)
        np.testing.assert_array_equal(file.get("x", 2)[:, 0], [1, 2, 3])


def test_combsbd_puts_steps_behind_each_other(tmp_path):
    sbd(tmp_path / "a.sbd", steps=3, NOTE="unknown variable")
    sbd(tmp_path / "b.sbd", steps=2, NOTE="unknown variable")
    target, steps = combsbd([tmp_path / "a", tmp_path / "b.sbd", tmp_path / "a"], tmp_path / "all")
    assert (target, steps) == (tmp_path / "all.sbd", 8)
    assert checksbf(target).sound
    with SbfFile(target) as file:
        assert file.complete
        np.testing.assert_array_equal(file.get("x")[:, 0], [0, 1, 2, 0, 1, 0, 1, 2])
        assert file.get("note") == ["unknown variable"]
    with pytest.raises(UsageError, match=r"all\.sbd exists.*the original overwrites.*--overwrite"):
        combsbd([tmp_path / "a", tmp_path / "b"], tmp_path / "all")
    assert combsbd([tmp_path / "a", tmp_path / "b"], tmp_path / "a", force=True)[1] == 5
    assert getfrsbf(tmp_path / "a", "tdef") == [[5]]


def test_combsbd_refuses_other_definitions_mechanisms_and_damage(tmp_path):
    a = sbd(tmp_path / "a.sbd")
    with SbfWriter(tmp_path / "b.sbd", "sbd", {}, {"T": (1, 1), "X": (4, 1)}):
        pass
    c = sbd(tmp_path / "c.sbd", LNP=LNP.T.reshape(2, 4))
    d = sbd(tmp_path / "d.sbd")
    raw = bytearray(d.read_bytes())
    raw[-40] ^= 1
    d.write_bytes(raw)
    for others, text in (["b.sbd"], "X is 3 x 1|FXT"), (["c.sbd"], "LNP"), ([], "two or more"):
        with pytest.raises(UsageError, match=text):
            combsbd([a, *(tmp_path / o for o in others)], tmp_path / "out")
    assert c.exists()
    for nothing in ("", ".", "/"):
        with pytest.raises(UsageError, match="it is a folder"):
            combsbd([a, a], nothing)
    with pytest.raises(SbfError, match=r"d\.sbd.*step 3"):
        combsbd([a, d], tmp_path / "out")
    assert not (tmp_path / "out.sbd").exists()
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


def test_combining_an_incomplete_file_gives_an_incomplete_file(tmp_path):
    a = sbd(tmp_path / "a.sbd")
    raw = bytearray(a.read_bytes())
    raw[13] = 0
    (tmp_path / "b.sbd").write_bytes(raw)
    target, _ = combsbd([a, tmp_path / "b"], tmp_path / "out")
    with SbfFile(target) as file:
        assert file.state == 2
        assert "incomplete: stopped after step 6 at t = 0.2" in notes(file)[0]


def test_checksbf_lists_everything(tmp_path):
    check = checksbf(sbd(tmp_path / "a.sbd"))
    text = "\n".join(listing(check))
    assert check.sound
    for ident in ("MODE", "LNP", "ETYPE", "TDEF", "T ", "X ", "DX ", "TDAT"):
        assert f"\n{ident}" in text
    assert "number of steps: 3" in text
    assert "1 integer" in text
    assert "'PLBEAM' 'PLTRUSS'" in text
    assert text.index("TDEF") < text.index("DX") < text.index("TDAT")


def test_getss_of_a_step(tmp_path):
    ltv(tmp_path / "a.ltv")
    system = getss(tmp_path / "a", 2)
    np.testing.assert_array_equal(system.A, [[0, 1], [-5, -0.1]])
    assert (system.t, system.inputs, system.states) == (0.5, ("u1",), ("x1", "x2"))
    scipy = system.to_scipy()
    np.testing.assert_allclose(np.sort(scipy.poles.imag), [-2.2355, 2.2355], atol=1e-4)  # sqrt(5 - 0.05**2)
    np.testing.assert_array_equal(scipy.D, [[3.0]])
    for ending in ("mat", "npz", "json"):
        export_getss(system, tmp_path / f"ss.{ending}")
    np.testing.assert_array_equal(loadmat(tmp_path / "ss.mat")["A"], system.A)
    np.testing.assert_array_equal(np.load(tmp_path / "ss.npz")["C"], system.C)
    assert json.loads((tmp_path / "ss.json").read_text())["D"] == [[3.0]]


def test_getss_without_feedthrough_has_no_d(tmp_path):
    ltv(tmp_path / "a.ltv", feedthrough=0, YNAMES=["tip"])
    system = getss(tmp_path / "a")
    assert system.D is None
    assert system.outputs == ("tip",)
    np.testing.assert_array_equal(system.to_scipy().D, [[0.0]])
    export_getss(system, tmp_path / "ss.mat")
    assert "D" not in loadmat(tmp_path / "ss.mat")


def test_getss_says_what_is_missing(tmp_path, monkeypatch):
    ltv(tmp_path / "a.ltv")
    with pytest.raises(UsageError, match="step 3"):
        getss(tmp_path / "a", 3)
    with SbfWriter(tmp_path / "b.ltv", "ltv", {}, {"T": (1, 1)}) as out:
        out.append({"T": 0.0})
    with pytest.raises(UsageError, match="ID not found: A"):
        getss(tmp_path / "b")
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(UsageError, match="python-control is not installed"):
        getss(tmp_path / "a").to_control()


def test_getss_to_python_control(tmp_path):
    pytest.importorskip("control")
    ltv(tmp_path / "a.ltv")
    system = getss(tmp_path / "a").to_control()
    assert system.input_labels == ["u1"]
    np.testing.assert_array_equal(system.A, [[0, 1], [-4, -0.1]])


def test_a_changed_input_file_is_noticed_by_its_digest(tmp_path):
    dat = tmp_path / "a.dat"
    dat.write_text("PLBEAM 1 1 2 3 4\n")
    path = sbd(tmp_path / "a.sbd", SOURCE="a.dat", SHA256=digest(dat))
    with SbfFile(path) as file:
        assert notes(file) == []
        dat.write_text("PLBEAM 1 1 2 3 5\n")
        assert "run it again" in notes(file)[0]
        dat.unlink()
        assert notes(file) == []


def test_final_names_appear_only_at_the_end_and_the_old_result_is_kept(tmp_path):
    final = sbd(tmp_path / "a.sbd", steps=1)
    claim = Claim(final)
    claim.begin()
    assert (claim.part.name, final.exists()) == ("a.sbd.part", False)
    assert getfrsbf(tmp_path / "a.sbd.bak", "tdef") == [[1]]
    with claim.open() as part:
        part.write(sbd(tmp_path / "b.sbd", steps=2).read_bytes())
    (tmp_path / "b.sbd").unlink()
    assert not final.exists()
    claim.publish()
    assert getfrsbf(final, "tdef") == [[2]]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.sbd", "a.sbd.bak"]
    claim = Claim(final)
    claim.part.unlink()
    with pytest.raises(AnalysisError, match="removed or replaced"):
        claim.publish()
    claim.release()


def test_replacing_keeps_the_target_when_writing_fails(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("old")

    def fail_half_way():
        with safety.replacing(target) as side:
            side.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail_half_way()
    assert target.read_text() == "old"
    with pytest.raises(UsageError, match="cannot write"), safety.replacing(tmp_path / "absent" / "a.txt") as side:
        side.write_text("new")
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_importing_the_container_costs_numpy_and_the_standard_library_only():
    program = "import sys, spacar_formats.sbf; print([m for m in sys.modules if m.split('.')[0] in %r])"
    heavy = ("scipy", "click", "rich", "matplotlib", "sympy", "difflib")
    out = subprocess.run([sys.executable, "-c", program % (heavy,)], capture_output=True, text=True, check=True).stdout
    assert out.strip() == "[]"
