"""Right-hand sides of lattices: the engine's where its factors are cheap, else NumPy's with condensed factors."""

import frames
import numpy as np
import pytest

from spacar.compiled import CompiledDynamics
from spacar.deck import parse_deck
from spacar.dynamics.array_evaluator import Dynamics
from spacar.mechanism import build

CELLS = [((4, 2, 2), False), ((12, 12), False), ((8, 4, 4), False), ((10, 5, 5), True)]


@pytest.mark.parametrize(("cells", "large"), CELLS)
def test_the_engine_leaves_large_lattices_to_numpy_and_both_agree(cells, large):
    """Accelerations at a displaced, moving state; 2e-13 of the largest was found (condition of the mass matrix)."""
    mechanism = build(parse_deck(frames.deck(cells, 1)), 1)
    compiled = CompiledDynamics(mechanism)
    assert compiled.solver.too_large() == large
    numpy_evaluator = Dynamics(mechanism)
    y = numpy_evaluator.start_values()
    y = y + 1e-4 * np.random.default_rng(3).normal(size=y.size)
    want, got = (e.rhs(0.0, y).copy() for e in (numpy_evaluator, compiled))
    np.testing.assert_allclose(got, want, rtol=0, atol=1e-10 * np.abs(want).max())
