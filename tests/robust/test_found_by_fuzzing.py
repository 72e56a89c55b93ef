"""Cases that `make fuzz` found: each ended in an internal error once."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from spacar_formats.sbf import SbfError, SbfWriter
from spacar_formats.vibration import modes_of_stored_matrices

import spacar
from spacar.deck import parse_deck
from spacar.errors import AnalysisError, Report
from spacar.simulation.reduction import tracked_modes
from tests.examples import DATA

from .test_one_sentence import is_one_sentence, run


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
    result = spacar.run(10, parse_deck(COLLAPSING, mode=10))
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
