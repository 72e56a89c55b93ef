"""Linearized equations of a motion whose inertia is rounding: modes 7, 9 and 10 say so, as mode 1 does."""

import numpy as np
import pytest

import spacar
from spacar.errors import AnalysisError
from tests.dynamics.test_mass_check import in_line

WORDS = "inertia on the motion of element 3 (PLTRUSS) e1 elongation is that of rounding"


def said(mode: int, tilt: float, slope: float, mass: float) -> str:
    """The slider carries the mass and stands at its dead point; `mass` on the crank."""
    dynamics = [("XM", 3, 1.0), ("ESTIFF", 3, 100.0)] + ([("XM", 2, mass)] if mass else [])
    try:
        return " ".join(spacar.run(mode, spacar.Deck.build(in_line(tilt, slope), dynamics, mode=mode)).report)
    except AnalysisError as error:
        return str(error)


@pytest.mark.parametrize("mode", [7, 9, 10])
@pytest.mark.parametrize("slope", [1.5, 1e-2, 1e-4])
@pytest.mark.parametrize("tilt", [0.0, 0.3, 0.7])
def test_a_frequency_of_rounding_is_said(mode: int, slope: float, tilt: float) -> None:
    """In a skew frame the slider seems to move 1e-16 of the crank's way, which gave 1e17 rad/s without a word."""
    text = said(mode, tilt, slope, 0.0)
    assert WORDS in text or "singular mass matrix" in text


@pytest.mark.parametrize("mode", [7, 9, 10])
def test_a_light_crank_is_not_doubted(mode: int) -> None:
    """Its inertia is all there is of the motion, however light it is."""
    for mass in (1.0, 1e-8, 1e-12):
        assert "inertia" not in said(mode, 0.3, 1.5, mass)


def test_a_light_crank_has_its_frequency() -> None:
    """omega^2 = k/m of the truss that holds the crank, e = its elongation, m the mass along it."""
    rows = in_line(0.0, 1.5)
    values = []
    for mass in (1.0, 1e-8):
        dynamics = [("XM", 2, mass), ("XM", 3, 1.0), ("ESTIFF", 3, 100.0 * mass)]
        r = spacar.run(7, spacar.Deck.build(rows, dynamics, mode=7))
        values.append(np.abs(r.frames[0].matrices["eigval"]).max())
    assert values[1] == pytest.approx(values[0], rel=1e-9)
