"""An absolute ERROR that is large beside the motion is told, lengths and rotations apart."""

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.compiled.library import why_off

ENGINES = [pytest.param(True, marks=pytest.mark.skipif(why_off() is not None, reason="no engine")), False]


def resonator(start: float, *, turning: bool = False) -> Deck:
    """2 pi rad/s; turning: an inertia on a hinge instead of a mass on a truss."""
    if turning:
        rows = [("HINGE", 1, 1, 2, 0.0, 0.0, 1.0), ("FIX", 1), ("DYNE", 1, 1)]
        more = [("XM", 2, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0), ("ESTIFF", 1, 4.0 * np.pi**2)]
    else:
        length = 1e-4 if start < 1e-5 else 1.0
        rows = [("PLTRUSS", 1, 1, 2), ("X", 2, length), ("FIX", 1), ("FIX", 2, 2), ("DYNE", 1, 1)]
        more = [("XM", 2, 1.0), ("ESTIFF", 1, 4.0 * np.pi**2 * length)]
    return Deck.build(rows, [*more, ("STARTDE", 1, 1, start, 0.0), ("TIMESTEP", 3.0, 20)])


@pytest.mark.parametrize("compiled", ENGINES)
@pytest.mark.parametrize(("start", "turning", "kind"), [(1e-7, False, "lengths"), (1e-6, True, "rotations")])
def test_a_motion_below_error_is_told(start: float, turning: bool, kind: str, compiled: bool) -> None:
    result = spacar.run(1, resonator(start, turning=turning), compiled=compiled)
    (line,) = result.report
    assert line.startswith("warning: ERROR allows 1e-05")
    assert kind in line
    advised = spacar.run(1, resonator(start, turning=turning), compiled=compiled, atol=2e-4 * start)
    assert advised.report == ()
    exact = start * np.cos(2.0 * np.pi * np.linspace(0.0, 3.0, 21))
    np.testing.assert_allclose(advised.element(1, 1, "e"), exact, rtol=0, atol=1e-3 * start)


def test_a_motion_of_centimetres_is_not() -> None:
    assert spacar.run(1, resonator(2e-5 / 0.01)).report == ()
    assert spacar.run(1, resonator(0.0)).report == ()
