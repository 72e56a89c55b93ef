"""The tangent of tubes with flow contains the momentum of the fluid, with and without gravity."""

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.mechanism import build
from spacar.stationary import LoadLevel, StationarySolver


@pytest.mark.parametrize("word", ["TUBE", "PLTUBE"])
def test_tangent_of_a_discharging_tube(word: str) -> None:
    """Against central differences of the residual: a bent tube with a jet at its end, no gravity."""
    spatial = word == "TUBE"
    y = (0.0, 1.0, 0.0) if spatial else ()
    stiffness = (90.0, 2.0, 3.0, 4.0) if spatial else (90.0, 3.0)
    rows = [(word, 1, 1, 2, 3, 4, *y), ("X", 3, 1.0, 0.2), ("FIX", 1), ("FIX", 2), ("DYNE", 1)]
    law = [("EM", 1, 0.7, 0.3, 0.4, 1.1, 2), ("ESTIFF", 1, *stiffness), ("XF", 3, 0.1, 0.3), ("ITERSTEP", 20, 1, 1e-9)]
    mechanism = build(Deck.build(rows, law, mode=7), 7)
    solver = StationarySolver(mechanism, spacar.errors.Report())
    solver.solve(LoadLevel(1.0, 0.0, True, 1, 1))
    q, tangent = solver.factorized()
    x, sigma = solver.dynamics.kinematics.x.copy(), solver.solution.sigma
    given = solver._evaluator.given
    matrix = tangent.dense()[: q.nf, : q.nf]
    for column, i in enumerate(q.F):
        h = 1e-6
        moved = []
        for s in (-1.0, 1.0):
            z = x.copy()
            z[i] += s * h
            moved.append(q.point(z, sigma, given).right[: q.nf])
        # `right` is minus the residual
        np.testing.assert_allclose(-(moved[1] - moved[0]) / (2 * h), matrix[:, column], atol=1e-7, rtol=1e-6)
