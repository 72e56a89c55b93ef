"""Wheels in stationary rolling: the tricycles with a spring on the steering, against differences of whole analyses."""

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck, read_deck
from spacar.errors import UsageError
from tests.examples import DATA

from .difference_truth import agree

STEERED = {
    "planar": ("trike2", "ESTIFF 6 30\nESIG 6 14\n"),
    "spatial": ("trike3v", "ESTIFF 8 30\nESIG 8 14\n"),
}
ASKED = {
    "planar": (
        ["XM.1", "X.1[2]", "X.7[2]", "STARTDX.4.1[start rate]", "PLWHEEL.2[5]", "PLWHEEL.2[6]", "ESTIFF.6", "ESIG.6"],
        ["sig[1,1]", "sig[5,2]", "sig[2,2]", "x[9,2]", "e[6,1]"],
    ),
    "spatial": (
        ["XM.1", "X.1[2]", "X.9[2]", "STARTDE.2.1[start rate]", "ESTIFF.8", "ESIG.8", "GRAVITY[3]"],
        ["sig[3,1]", "sig[11,2]", "sig[4,3]", "x[13,2]", "e[8,1]"],
    ),
}


def tricycle(kind: str):
    name, steering = STEERED[kind]
    return parse_deck((DATA / f"{name}.dat").read_text().replace("TIMESTEP", f"{steering}TIMESTEP"), mode=7)


@pytest.mark.parametrize("kind", STEERED)
def test_circles_that_a_tricycle_rolls(kind: str) -> None:
    """Constraint forces, slip forces and the steering angle of steady rolling by masses, places, radii, speed."""
    found = agree(tricycle(kind), *ASKED[kind], rel=1e-7)
    assert np.abs(found.derivatives).max(axis=0).all()  # every number matters


def test_where_it_rolls_is_kept() -> None:
    """The spin angle has no stiffness: it stays where the file puts it, and so do the kinematic coordinates."""
    names = ["STARTDX.4.1[start value]", "X.1[2]", "ESTIFF.6"]
    found = spacar.sensitivity(tricycle("planar"), names, ["x[4,1]", "x[1,1]", "e[6,1]"])
    np.testing.assert_allclose(found.derivatives[0], [1.0, 0.0, 0.0], atol=1e-12)
    assert found.of("x[1,1]", "X.1[2]") == pytest.approx(1.0, abs=1e-12)
    assert found.of("e[6,1]", "STARTDX.4.1[start value]") == pytest.approx(0.0, abs=1e-12)


def test_their_linearized_equations_are_refused() -> None:
    with pytest.raises(UsageError, match="wheels for eigenvalues"):
        spacar.sensitivity(read_deck(DATA / "trike2.dat", 7), ["XM.1"], ["frequency[1]"])
