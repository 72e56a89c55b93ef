"""The size of results is known before the first step, and what does not fit on the disk is refused."""

import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from spacar_formats import disk_room
from spacar_formats.disk_room import bytes_of_a_step, steps_of
from spacar_formats.result_files import result_sinks
from spacar_formats.sbf import SbfFile
from spacar_formats.sbf.record_layout import matlab_name

import spacar
from spacar.errors import InputError, UsageError
from spacar.result import Result
from tests import command_line
from tests.examples import DATA


@pytest.fixture
def call(tmp_path, monkeypatch):
    shutil.copy(DATA / "crank.dat", tmp_path)
    monkeypatch.chdir(tmp_path)
    return lambda *words: command_line.call(*words)[::2]


@pytest.mark.parametrize(
    ("name", "mode"), [("crank", 1), ("crank", 4), ("lever", 9), ("lever", 7), ("robotinv", 2), ("screw", 1)]
)
def test_the_size_is_known_before_the_first_step(name: str, mode: int, tmp_path: Path) -> None:
    """That of the .sbd to the byte, but for its header; matrices within the ones that a mode may leave out."""
    run = spacar.frames(mode, DATA / f"{name}.dat")
    steps, sizes = steps_of(run), bytes_of_a_step(run)
    spacar.run(mode, DATA / f"{name}.dat").save(tmp_path / "a")
    for kind in run.mode.files:
        with SbfFile(tmp_path / f"a.{kind}") as file:
            assert file.steps == steps
            left = (tmp_path / f"a.{kind}").stat().st_size - steps * sizes[kind]
            assert 0 < left < 9000 or (kind != "sbd" and left > -0.6 * steps * sizes[kind])
    log = (tmp_path / "a.log").read_text()
    if mode in (1, 4):
        assert len(log) < 1.5 * steps * sizes["log"] + 20_000


def test_a_run_that_does_not_fit_is_refused_at_once(call, tmp_path: Path) -> None:
    """With the numbers; the earlier result stays where it was."""
    assert call("1", "crank", "-q")[0] == 0
    before = (tmp_path / "crank.sbd").read_bytes()
    for mode in ("1", "4"):
        status, told = call(mode, "crank", "--steps", "1000000000000", "--time", "1")
        assert status == 2
        assert "the results of 1000000000001 steps take" in told
        assert "are free in" in told
        assert "--force" in told
    assert (tmp_path / "crank.sbd").read_bytes() == before
    assert not (tmp_path / "crank.sbd.part").exists()


def test_force_goes_on(call, monkeypatch) -> None:
    """On a disk of 100 kB: 101 steps of 688 bytes and 81 fit, 201 do not."""
    monkeypatch.setattr(disk_room.shutil, "disk_usage", lambda folder: SimpleNamespace(free=100_000))
    assert call("1", "crank", "-q") == (0, "")
    status, told = call("1", "crank", "-q", "--steps", "200")
    assert (status, "155 kB (log 16.3 kB, sbd 138 kB), but 100 kB are free" in told) == (2, True)
    assert call("1", "crank", "-q", "--steps", "200", "--force") == (0, "")


def test_a_sweep_that_does_not_fit_is_refused(call) -> None:
    words = ["sweep", "crank", "--set", "EM.2=1:2:1000000", "--set", "XM.6=1:2:1000000"]
    status, told = call(*words, "-r", "x[6,1]@end")
    assert (status, "1000000000000 rows take" in told) == (2, True)


def test_mode_3_on_the_file_of_the_setpoints_leaves_their_result(call, tmp_path: Path) -> None:
    shutil.copy(DATA / "robotinv.dat", tmp_path)
    assert call("2", "robotinv", "-q")[0] == 0
    assert call("3", "robotinv", "-q")[0] == 2
    assert (tmp_path / "robotinv.sbd").exists()
    assert not (tmp_path / "robotinv.sbd.bak").exists()


def test_a_result_that_mode_3_replaced_is_named_and_can_be_used(call, tmp_path: Path) -> None:
    for name in ("robotinv", "robotinvlin"):
        shutil.copy(DATA / f"{name}.dat", tmp_path)
    assert call("2", "robotinv", "-q")[0] == 0
    assert call("3", "robotinv", "--setpoints", "robotinv", "-q")[0] == 0
    status, told = call("3", "robotinvlin", "-q")
    assert (status, "a result of mode 3 (robotinv.sbd.bak is the one before" in told) == (2, True)
    assert call("3", "robotinvlin", "-q", "--setpoints", "robotinv.sbd.bak")[0] == 0


# What a result file holds once is in the Python result under the same name, with the same values.
PROVENANCE = {"VERSION", "SOURCE", "SHA256", "MODE", "ETYPE"}


@pytest.mark.parametrize(("mode", "name"), [(0, "crank"), (0, "robotsim"), (0, "trike3i"), (7, "column2")])
def test_names_and_values_are_those_of_the_file(mode: int, name: str, tmp_path: Path) -> None:
    run = spacar.frames(mode, DATA / f"{name}.dat")
    frames = list(run)
    with result_sinks(tmp_path / name, ("sbd",)) as (sink,):
        sink.start(run)
        for frame in frames:
            sink.frame(frame)
        sink.finish(None)
    result = Result(run.mechanism, mode, tuple(frames), (), {})
    with SbfFile(tmp_path / f"{name}.sbd") as file:
        stored = {matlab_name(ident): file.header[ident] for ident in file.header_records if ident not in PROVENANCE}
    assert {"ndof", "nxp", "nep", "rl0", "einit", "estiff", "rxyz", "rxyzq", "dr0", "kdform", "em"} <= set(
        result.tables
    )
    assert set(result.tables) <= set(stored)
    for variable in result.tables:
        assert np.size(result[variable]) == np.size(stored[variable]), variable
        np.testing.assert_array_equal(np.ravel(result[variable]), np.ravel(stored[variable]), err_msg=variable)


def test_values_of_the_slider_crank() -> None:
    result = spacar.run(1, DATA / "crank.dat", n_steps=1, duration=0.01)
    assert result["rl0"] == pytest.approx([0.15, 0.30])
    assert (result["ndof"], result["nddof"], result["nx"]) == (1, 0, 10)
    assert result["em"][1, 0] == 0.2225
    with pytest.raises(UsageError, match="rl1 was not computed"):
        result["rl1"]


@pytest.mark.parametrize(
    ("extra", "expected"), [("", [0.3, 0.4]), ("DRPINBOD 1 0.25 0.5\n", [0.25, 0.5]), ("ORPINBOD 1 0 1\n", [0.4, -0.3])]
)
def test_dr0_of_a_planar_pinbody(extra: str, expected: list[float]) -> None:
    """Projections of p-q on the directions of the body at the start, as those of PINBODY."""
    text = f"PLPINBOD 1 1 2 3\nX 1 0 0\nX 3 0.3 0.4\n{extra}FIX 1\nINPUTX 2 1\nEND\nEND\n"
    result = spacar.run(0, spacar.parse_deck(text, "body"))
    assert result["dr0"][0] == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("block", ["", "NOMS 1 1 1\nEND\n"])
def test_mode_2_without_a_trajectory_is_one_sentence(block: str) -> None:
    """A deck that was read for no mode in particular."""
    text = (DATA / "robotinv.dat").read_text().split("HALT\nTRAJECT")[0]
    deck = spacar.parse_deck(text + (f"HALT\n{block}" if block else "") + "END\n", "rest")
    with pytest.raises(InputError, match=r"error: rest: mode 2 needs a third block with at least one TRAJECT$"):
        spacar.run(2, deck)
