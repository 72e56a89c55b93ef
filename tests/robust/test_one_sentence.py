"""Whatever is typed or read: one sentence that says what is wrong, never an internal error, never silence."""

import json
import os
import shutil
import struct
import time
import zlib
from pathlib import Path

import numpy as np
import pytest
from spacar_cli.environment import Environment, tell_error
from spacar_formats.exports import to_csv
from spacar_formats.sbf import SbfError, SbfFile, SbfWriter
from spacar_formats.sbf.record_layout import PREAMBLE, directory_crc
from spacar_formats.signal_tables import read_table, table_of_arrays
from spacar_formats.vibration import modes_of_stored_matrices

import spacar
from spacar.errors import LONGEST_LINE, AnalysisError, InputError, Report, UsageError, shown
from spacar.simulation.reduction import tracked_modes
from spacar.studies.runs.rows import Rows
from tests.command_line import call as run
from tests.examples import DATA

from .processes import done, model


def is_one_sentence(err):
    errors = [line for line in err.splitlines() if line.startswith("error: ")]
    return len(errors) == 1 and "internal" not in err and "Traceback" not in err


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    for name, mode in (("crank", 1), ("lateral4", 7), ("lever", 9)):
        model(folder, name)
        assert run(mode, folder / f"{name}.dat")[0] == 0
    return folder


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["1", "crank", "--steps", str(2**63)], "steps"),
        (["1", "crank", "--steps", "9" * 5000], "15 digits"),
        (["1", "crank", "--steps", "10000000000000000"], "1000000000000000"),
        (["1", "crank", "--atol", "inf"], "not a finite number"),
        (["1", "crank", "--atol", "nan"], "not a finite number"),
        (["1", "crank", "--rtol", "1e300"], "1e-100 ... 1e+100"),
        (["1", "crank", "--rtol", "2"], "range"),
        (["1", "crank", "--time", "inf"], "not a finite number"),
        (["1", "crank", "--time", "1e-320"], "1e-100 ... 1e+100"),
        (["plot", "crank", "9**9**9*t"], "nowhere a finite number"),
        (["plot", "crank", "1/0"], "nowhere a finite number"),
        (["plot", "crank", "(" * 5000 + "t" + ")" * 5000], "is no expression"),
        (["plot", "crank", "-" * 3000 + "t"], "-----"),
        (["plot", "crank", "t", "--dpi", "nan"], "not a finite number"),
        (["draw", "crank", "--section", "CIRC 1e400"], "positive dimensions"),
        (["getfrsbf", "", "x"], "is not the name of a result file"),
        (["getfrsbf", "/", "x"], "is not the name of a result file"),
        (["getfrsbf", "crank", "x" * 2_000_000], "characters left out"),
        (["repinsbf", "crank", "T", "9" * 5000, "--at", "1"], "VALUE is not JSON"),
        (["repinsbf", "crank", "T", "[" * 100_000, "--at", "1"], "VALUE is not JSON"),
        (["repinsbf", "crank", "T", "NaN", "--at", "1"], "finite numbers are needed"),
        (["repinsbf", "crank", "T", "1e999", "--at", "1"], "must be finite"),
        (["repinsbf", "crank", "NX", "1" + "0" * 30], "holds numbers"),
        (["bode", "lever", "--low", "nan"], "not a finite number"),
        (["bode", "lever", "--at", str(10**30)], "15 digits"),
        (["compliance", "crank", "-1"], "error"),
        (["trade", "crank", "--target", "nan"], "not a finite number"),
        (["spacntrl", "lever", "--omega", "nan"], "not a finite number"),
        (["1", "x\x1b[31m\x07"], r"x\x1b[31m\x07"),
        (["draw", "crank", "-o", "a\x1b]0;b\x07.png\x1b"], r"\x1b]0;b\x07"),
        (["x\x1b[31m"], r"\x1b[31m"),
        (["check", "a\0b"], "zero byte"),
        (["sweep", "crank", "--from", "latin.csv", "--result", "x[6,1]@end"], "no table in csv"),
        (["sweep", "crank", "--from", "null.csv", "--result", "x[6,1]@end"], "error"),
    ],
)
def test_wrong_words(results, monkeypatch, words, found):
    monkeypatch.chdir(results)
    Path("latin.csv").write_bytes("XM.6\n0.1 \xe4\n".encode("latin-1"))
    Path("null.csv").write_bytes(b"XM.6\n\0\n")
    status, _, err = run(*words)
    assert status in (1, 2), err
    assert is_one_sentence(err), err
    assert found in err
    assert not any(c < " " and c != "\n" for c in err)
    assert len(max(err.splitlines(), key=len)) < LONGEST_LINE + 300


def test_titles_are_text_and_no_formulas(results, monkeypatch):
    monkeypatch.chdir(results)
    for words in (["plot", "crank", "t"], ["draw", "crank"], ["visual", "lateral4"]):
        assert run(*words, "--title", r"$\frac{$", "-o", "title.svg")[0] == 0
        assert "frac" in Path("title.svg").read_text()


def test_values_that_are_not_finite_are_told(results, monkeypatch):
    monkeypatch.chdir(results)
    _, out, err = run.done("plot", "crank", "1/t", "--csv", "-")
    assert "warning: '1/t' is not a finite number at 1 of 101 steps" in err
    assert out.startswith("t (s)")


@pytest.mark.parametrize("value", ["1e150", "-1e101", "1e308", "1e-150", "1e-400", "4d-120"])
@pytest.mark.parametrize("mode", [0, 1, 7])
def test_sizes_that_cannot_be_squared_are_refused_with_their_place(value, mode):
    text = (DATA / "crank.dat").read_text()
    x = next(line for line in text.splitlines() if line.startswith("X "))
    words = x.split("%")[0].split()
    changed = text.replace(x, " ".join([*words[:2], value, *words[3:]]))
    with pytest.raises(InputError, match=rf"argument '{value}' is too (large|small)") as caught:
        spacar.parse_deck(changed, "crank.dat", mode)
    assert caught.value.messages[0].line == text.splitlines().index(x) + 1


def test_zero_in_every_form_is_a_number():
    text = (DATA / "crank.dat").read_text().replace("0.0", "0.000e-300")
    spacar.parse_deck(text, "crank.dat", 1)


def test_long_words_are_shortened_and_quick(tmp_path):
    path = tmp_path / "long.dat"
    path.write_text("K" * 2_000_000 + " 1 2\nEND\nHALT\nEND\nEND\n")
    begun = time.process_time()
    err = run.refused("check", path)
    assert len(err) < 5000
    assert time.process_time() - begun < 20.0  # 0.5 s; the old text alone took that long to print
    assert shown("a\tb\nc\x00") == "a\tb\nc\\x00"


def test_a_byte_that_is_no_text_in_a_file_name(tmp_path, monkeypatch):
    """In a process of its own where the name comes from the shell and back to the screen, and where a prompt opens."""
    monkeypatch.chdir(tmp_path)
    name = os.fsdecode(b"a\xff")
    shutil.copy(DATA / "crank.dat", tmp_path / f"{name}.dat")
    for words in ([1, name, "-v"], ["draw", name], ["plot", name, "t"], ["report", name], ["check", name],
                  ["loadsbd", name], ["checksbf", name], ["checksbf", name, "--json"], [1, name, "--json"],
                  ):  # fmt: skip
        status, _, err = done(tmp_path, *words) if words in ([1, name, "-v"], ["loadsbd", name]) else run(*words)
        assert status == 0, err
        assert "internal" not in err
    assert done(tmp_path, 1, os.fsdecode(b"b\xff"))[0] == 2


def test_a_screen_that_knows_only_ascii(results):
    process = done(results, "plot", "crank", "xdd[6,1]", "--csv", "-",
                   env={**os.environ, "PYTHONIOENCODING": "ascii"})  # fmt: skip
    assert process[0] == 0, process[2]
    assert process[1].startswith(r"t (s),\"xdd[6,1] (m/s\xb2)\"".replace("\\\"", '"'))


# -- forged result files ------------------------------------------------------------------------------------------
def forge(path, ident, value, at=0):
    """Put a number into a header variable and make all checksums right."""
    with SbfFile(path) as file:
        record, first = file.header_records[ident], file.directory
    raw = bytearray(path.read_bytes())
    item = struct.pack("<q", value) if record.type == 1 else struct.pack("<d", value)
    raw[record.offset + 8 * at : record.offset + 8 * at + 8] = item
    body = bytes(raw[PREAMBLE.size : first.data_offset])
    struct.pack_into("<I", raw, 56, directory_crc(body, first.tdef_offset))
    covered = bytearray(raw[:60])
    covered[13] = 0
    struct.pack_into("<I", raw, 60, zlib.crc32(covered))
    path.write_bytes(bytes(raw))


READERS = [
    ["draw", "F", "-o", "x.png"], ["report", "F", "-o", "x.html"], ["plot", "F", "x[2,1]", "--csv", "-"],
    ["compliance", "F", "2"], ["visual", "F", "-o", "x.png"], ["eigen", "F"], ["checksbf", "F", "--json"],
]  # fmt: skip


IDENTS = ["LNP", "LE", "LN", "NX", "NE", "NXP", "NEP", "MODE", "NDOF", "IT", "KDEF"]
LONG = {("report", ident) for ident in ("LNP", "LE", "LN", "NDOF", "IT", "KDEF")}
LONG |= {("visual", ident) for ident in ("IT", "KDEF", "NDOF")} | {("draw", "IT"), ("draw", "KDEF")}


@pytest.mark.parametrize(("ident", "words"), [
    pytest.param(ident, words, id=f"{ident}-{words[0]}", marks=[pytest.mark.slow] * ((words[0], ident) in LONG))
    for ident in IDENTS for words in READERS
])  # fmt: skip
def test_forged_indices(results, tmp_path, monkeypatch, ident, words):
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(7)
    for value in (-1, 10**6, 2**62, -(2**63), 3):
        for kind in ("sbd", "sbm"):
            shutil.copy(results / f"lateral4.{kind}", f"F.{kind}")
        with SbfFile(Path("F.sbd")) as file:
            size = file.header_records[ident].size
        forge(Path("F.sbd"), ident, value, int(rng.integers(size)))
        status, _, err = run(*words)
        assert status in (0, 1, 2)
        assert "internal" not in err, (ident, value, err)


def test_no_cell_of_a_csv_is_a_formula(tmp_path):
    """Names of quantities are refused; titles and reasons, which somebody else may write, are marked as text."""
    model(tmp_path)
    for name in ("=cmd", "@a", "a\x1b[2J"):
        err = run.refused("sweep", tmp_path / "crank", "--set", "XM.6=1", "--result", f"{name}:x[6,1]@end")
        assert "begins with = or @ or has a control character" in err
    with Rows(tmp_path / "r.csv", ("case", "status", "reason")) as rows:
        rows.add({"case": "a", "status": "failed", "reason": "=1+1"})
    assert (tmp_path / "r.csv").read_text().endswith("a,failed,'=1+1\n")
    to_csv({"=name": np.array(["=1", "@2", "-3"])}, tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text().split() == ["'=name", "'=1", "'@2", "-3"]


def test_long_file_names(tmp_path):
    """The files beside a result have longer names: 240 characters leave room for .sbd.part."""
    name = "a" * 240
    model(tmp_path)
    (tmp_path / "crank.dat").rename(tmp_path / f"{name}.dat")
    for _ in range(2):
        assert run(1, tmp_path / name, "--steps", 2)[0] == 0
    assert run("draw", tmp_path / name, "-o", tmp_path / f"{name}.png")[0] == 0


@pytest.mark.parametrize(
    "forged",
    [{"columns": [3]}, {"columns": [True]}, {"columns": [1, 2]}, {"columns": "1"}, {"labels": 3}, {"title": None}, {}],
)
def test_forged_scopes(tmp_path, forged):
    """The text is under a checksum, so only one who wrote the file can have put it there."""
    table = table_of_arrays({"plant": (("a", "b"), np.ones((1, 2)))})
    scope = {"title": "t", "unit": "m", "labels": ["a"], "columns": [1]} | forged if forged else forged
    path = tmp_path / "f.sbd"
    header = {"TITLE": "f", "KIND": "signals"} | table.header() | {"SCOPES": [json.dumps(scope)]}
    with SbfWriter(path, "sbd", header, {"T": (1, 1), "SIGNAL": (2, 1)}) as writer:
        writer.append({"T": 0.0, "SIGNAL": np.ones(2)})
    with pytest.raises(SbfError, match="line 1 of SCOPES"):
        read_table(SbfFile(path))


# Cases that `make fuzz` found: each ended in an internal error once.
def test_a_continued_line_without_a_value_in_a_simulation_model(tmp_path):
    model = tmp_path / "loop.sim"
    model.write_text("[simulation]\ntime = 1\nstep = 0.1\n[y0]\nbl\n reference-y0\n[wires]\n")
    err = run.refused("sim", model)
    assert is_one_sentence(err)
    assert "an indented line follows a name without a value" in err


def test_a_beam_without_bending_stiffness_of_its_own(tmp_path):
    """A shear factor of 1e18: S = (1, -1; -1, 1) EI/l to working precision, which has no inverse."""
    (tmp_path / "soft.dat").write_text(
        "PLBEAM 1 1 2 3 4\nX 3 1 0\nFIX 1\nFIX 2\nDYNE 1 2 3\nEND\nHALT\nEM 1 1\nESTIFF 1 0 100 1e18\nEND\nEND\n"
    )
    err = run.refused(9, tmp_path / "soft.dat", status=1)
    assert is_one_sentence(err)
    assert "the stiffness of element 1 (PLBEAM) is singular" in err


# four rigid bars around a spring, which the weight flattens: no frequencies at the dead point
COLLAPSING = """
PLTRUSS 1 1 2
PLTRUSS 2 1 3
PLTRUSS 3 2 3
PLTRUSS 4 2 4
PLTRUSS 5 3 4
X 1  0.     0.
X 2 -0.7071 0.7071
X 3  0.7071 0.7071
FIX 1
FIX 4 1
DYNE 3 1
END
HALT
XM 4 1.
XF 4 0. -10.
ESTIFF 3 1.4142
END
END
"""


def test_no_frequencies_in_a_flattened_mechanism():
    result = spacar.run(10, spacar.parse_deck(COLLAPSING, mode=10))
    assert np.isnan(result["eigval"][-1]).all()
    assert any("no frequencies, they are stored as nan" in line for line in result.report)


def test_matrices_that_are_not_finite():
    K = np.ones((2, 1, 1))
    K[1] = np.nan
    with pytest.raises(AnalysisError, match=r"at t = 0\.5 holds numbers that are not finite"):
        tracked_modes(np.array([0.0, 0.5]), np.ones((2, 1, 1)), K)


def test_a_time_varying_system_without_a_step(tmp_path):
    with SbfWriter(tmp_path / "empty.ltv", "ltv", {"NX": 2, "NU": 1, "NY": 1}, {"T": (1, 1), "A": (2, 2)}):
        pass
    for words in (("ltv", tmp_path / "empty", "-o", tmp_path / "y.npz"), ("mrltv", tmp_path / "empty", "1")):
        err = run.refused(*words)
        assert is_one_sentence(err)
        assert "empty.ltv holds no step" in err


class DamagedMatrices:
    path = Path("lever.sbm")

    def has(self, ident):
        return False

    def array(self, ident, step):
        return np.full((1, 1), np.inf)


def test_stored_matrices_that_are_not_finite():
    with pytest.raises(SbfError, match=r"lever\.sbm is damaged: a matrix of step 3 holds numbers that are not finite"):
        modes_of_stored_matrices(DamagedMatrices(), 3, Report())


def test_a_nominal_result_without_a_name(tmp_path):
    shutil.copy(DATA / "crank.dat", tmp_path)
    assert is_one_sentence(run.refused(3, tmp_path / "crank.dat", "--setpoints", "."))


@pytest.mark.parametrize(
    ("mode", "name", "old", "new", "ended", "found"),
    [
        (8, "lateral4", "1 0.0 2.0 0.0 1.0", "1 0.0 2.0 0.0 1e308", 1, "the stiffness of element 1 (BEAM)"),
        (10, "plbeam5free", "EM 3 1.0", "EM 3 1e308", 1, "the linearized equations overflow"),
        (9, "cardan", "4 5  0.707 -0.707 0.", "4 5  0.707 -0.707 1e8", 0, ""),
    ],
)
def test_numbers_of_any_size(tmp_path, mode, name, old, new, ended, found):
    """Products of the largest numbers overflow; an axis of 1e8 leaves the position all but undetermined."""
    text = (DATA / f"{name}.dat").read_text()
    assert old in text
    (tmp_path / "far.dat").write_text(text.replace(old, new))
    status, _, err = run(mode, tmp_path / "far.dat")
    assert status == ended, err
    assert found in err
    assert "internal" not in err


@pytest.mark.parametrize("path", [300 * "a", "", ".", "/"])
def test_what_is_no_path_of_an_input_file(path):
    with pytest.raises(UsageError) as caught:
        spacar.read_deck(path)
    assert caught.value.code == "files.not-readable"


def test_an_error_that_is_its_own_cause_is_told(capsys):
    first, second = ImportError("no module"), ValueError("why")
    first.__cause__, second.__cause__ = second, first
    assert tell_error(Environment(), first) == 1
    assert "no module" in capsys.readouterr().err
