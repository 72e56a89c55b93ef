"""Spatial input files as symbolic models: their motion is that of mode 1, which shares no equations with them."""

import re
import shutil
from pathlib import Path

import pytest

pytest.importorskip("sympy")

from tests.command_line import call
from tests.examples import DATA

# a free body of two rods, on it a hinge about a skew axis with spring, damper and preload, a rod with rotary inertia
# and products of inertia of its section, an elastic truss to the ground, a force, gravity, inertias of a node
FREE = """
RBEAM 1 1 2 3   RBEAM 2 1 2 4   HINGE 3 2 5 1. 2. 2.   BEAM 4 3 5 6 7 0. 1. 0.3   TRUSS 5 6 8
X 1 0. 0. 0.   X 3 0.5 0.1 0.2   X 4 -0.2 0.4 0.   X 6 1.0 0.3 0.6   X 8 1.4 0.6 1.0
FIX 8   DYNE 3 1   DYNX 1   DYNX 2 2 3 4   RLSE 5 1   END HALT
EM 1 0.8 0.01 0.005 0.004   EM 2 1.2   EM 4 0.5 0.01 0.002 0.003 0.001   XM 4 0.3
XM 2 0.02 0.001 0. 0.03 0.002 0.04   XF 6 1. -2. 0.5   ESTIFF 5 30.   EDAMP 5 0.2   ESTIFF 3 2.
EDAMP 3 0.1   ESIG 3 0.4   GRAVITY 0. 0. -9.81
STARTDE 3 1 0.2 0.5   STARTDX 2 2 0.1 0.3   STARTDX 2 3 0.05 -0.2   TIMESTEP 0.3 10   END END
"""
# a beam that bends in both planes and twists, on a driven column
COLUMN = """
HINGE 1 1 2 0. 0. 1.   BEAM 2 3 2 4 5 0. 1. 0.5   X 3 0. 0. 0.   X 4 0.6 0.2 0.3
FIX 1   FIX 3   DYNE 1 1   DYNE 2 2 3 4 5 6   END HALT
EM 2 2. 0.02   XM 4 1.   XM 5 0.01 0. 0. 0.01 0. 0.01   XF 4 0. 0. -3.   ESTIFF 2 0. 60. 90. 120.
STARTDE 1 1 0.1 2.   TIMESTEP 0.1 10   END END
"""
# the same beam, thrown: it hangs on nothing
THROWN = (
    COLUMN.replace("HINGE 1 1 2 0. 0. 1.", "")
    .replace("FIX 1   FIX 3   DYNE 1 1 ", "DYNX 3   DYNX 2 2 3 4 ")
    .replace("STARTDE 1 1 0.1 2.", "STARTDX 2 4 0.05 1.")
)


def exported(*words: str | Path) -> tuple[str, float]:
    """What `spacar symbolic export` says, and by how much the positions differ from those of mode 1 [m]."""
    out = call.done("symbolic", "export", *words).out
    found = re.search(r"positions +differ by at most (\S+) m", out)
    assert found
    return out, float(found[1])


def test_a_manipulator_moves_as_in_mode_1(tmp_path: Path) -> None:
    shutil.copy(DATA / "robotsim.dat", tmp_path)
    out, difference = exported(tmp_path / "robotsim.dat", "--time", "0.05")
    assert difference < 1e-8  # both runs at rtol 1e-9
    assert "3 coordinates, 0 constraints" in out


@pytest.mark.slow
def test_a_free_body_with_a_skew_hinge_moves_as_in_mode_1(tmp_path: Path) -> None:
    (tmp_path / "free.dat").write_text(FREE)
    assert exported(tmp_path / "free.dat")[1] < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize(("text", "limit", "deflection"), [(COLUMN, 2e-6, "0.009"), (THROWN, 1e-8, "0.0001")])
def test_a_beam_in_two_planes_moves_as_in_mode_1(tmp_path: Path, text: str, limit: float, deflection: str) -> None:
    """Same two shapes in each plane, one of twist: what is left is of second order, 1e-4 of the deflection."""
    (tmp_path / "column.dat").write_text(text)
    out, difference = exported(tmp_path / "column.dat")
    assert difference < limit
    assert f"largest deflection {deflection}" in out
