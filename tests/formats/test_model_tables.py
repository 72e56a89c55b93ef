"""What a result file holds once is in the Python result under the same name, with the same values."""

from pathlib import Path

import numpy as np
import pytest
from spacar_formats.sbf import SbfFile
from spacar_formats.sbf.record_layout import matlab_name
from spacar_formats.sinks.results import result_sinks

import spacar
from spacar.errors import InputError, UsageError
from spacar.result import Result
from tests.examples import DATA

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
