"""A light body that carries a heavy one, in relative coordinates: the mass matrix is nearly singular, and right.

Two bars in line, the degrees of freedom their elongations: M = [[m1 + m2, m2], [m2, m2]], with the smallest eigenvalue
m1/(2 m2) when scaled. A force F on the light mass m1 gives it F/m1, the heavy one nothing.
"""

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.errors import AnalysisError


def rows() -> list[tuple]:
    return [
        ("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 2, 3), ("X", 2, 1.0, 0.0), ("X", 3, 2.0, 0.0), ("FIX", 1),
        ("FIX", 2, 2), ("FIX", 3, 2), ("DYNE", 1), ("DYNE", 2),
    ]  # fmt: skip


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("ratio", [1.0, 1e4, 1e8, 1e12, 1e13])
def test_a_light_part_is_accelerated_right(ratio: float, compiled: bool) -> None:
    """To 1e-6: sums of M lose eps times the ratio in the reduced form, nothing in the saddle-point form."""
    dynamics = [("XM", 2, 1.0), ("XM", 3, ratio), ("XF", 2, 1.0), ("TIMESTEP", 1e-3, 1)]
    r = spacar.run(1, Deck.build(rows(), dynamics), compiled=compiled)
    assert r.node(2, 1, "xdd")[0] == pytest.approx(1.0, rel=1e-6)
    assert abs(r.node(3, 1, "xdd")[0]) <= 1e-6


@pytest.mark.parametrize("compiled", [False, True])
def test_a_part_without_mass_is_refused(compiled: bool) -> None:
    with pytest.raises(AnalysisError) as caught:
        spacar.run(1, Deck.build(rows(), [("XM", 3, 1.0), ("TIMESTEP", 1e-3, 1)]), compiled=compiled)
    assert caught.value.code == "dynamics.singular-mass"
    np.testing.assert_equal("no inertia" in str(caught.value), True)
