"""The condition number of larger models against a singular value decomposition."""

import numpy as np
import pytest
import sizes

import spacar
from spacar.dynamics.array_evaluator import Dynamics
from spacar.kinematics import constraint_condition, constraint_matrices
from spacar.mechanism import build


@pytest.mark.parametrize(("model", "n"), [("planar", 60), ("spatial", 40), ("rods", 120), ("joints", 40)])
def test_three_digits(model, n):
    evaluator = Dynamics(build(spacar.parse_deck(sizes.MODELS[model](n), mode=1), 1))
    evaluator.place(0.0, evaluator.start())
    k = evaluator.kinematics
    exact = constraint_condition.of_entries(k.mechanism, constraint_matrices.entries_of(k.sweep))
    assert len(k.E) > 100
    assert constraint_condition._estimate(k) == pytest.approx(exact, rel=3e-3)


def test_a_submatrix_is_made_alone(monkeypatch):
    """No array of the size deformations x coordinates is made for the few rows that are asked for (a frame whose
    coordinates are all degrees of freedom asks for none), and entries of the same place add up."""
    evaluator = Dynamics(build(spacar.parse_deck(sizes.MODELS["planar"](12), mode=1), 1))
    evaluator.place(0.0, evaluator.start())
    k = evaluator.kinematics
    rows, columns, values = constraint_matrices.entries_of(k.sweep)
    whole = k.sweep.gradient() * k.mechanism.scale / k.mechanism.deformation_scale[:, None]
    twice = np.tile(rows, 2), np.tile(columns, 2), np.concatenate((0.25 * values, 0.75 * values))
    monkeypatch.setattr(k.sweep, "gradient", None)
    D = constraint_matrices.scaled_difference_matrix(k.mechanism, twice, k.E, k.U)
    np.testing.assert_allclose(D, whole[np.ix_(k.E, k.U)], rtol=1e-15)
    assert constraint_condition.condition_number(k) == pytest.approx(constraint_condition.of_scaled(D), rel=1e-12)


def test_header_has_that_of_the_first_step():
    deck = spacar.parse_deck(sizes.MODELS["planar"](12).replace("-1. -1.", "0. 0."), mode=7)
    evaluator = Dynamics(build(deck, 7))
    evaluator.place(0.0, evaluator.start())
    condition = constraint_condition.condition_number(evaluator.kinematics)
    assert spacar.run(7, deck).header["condition"] == pytest.approx(condition, rel=1e-9)  # other storage
