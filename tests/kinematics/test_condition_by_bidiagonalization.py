"""The condition number of larger models against a singular value decomposition."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from spacar.deck import parse_deck
from spacar.dynamics.array_evaluator import Dynamics
from spacar.kinematics import constraint_condition
from spacar.mechanism import build

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
import sizes


@pytest.mark.parametrize(("model", "n"), [("planar", 60), ("spatial", 40), ("rods", 120), ("joints", 40)])
def test_three_digits(model, n):
    evaluator = Dynamics(build(parse_deck(sizes.MODELS[model](n), mode=1), 1))
    evaluator.place(0.0, evaluator.start())
    k = evaluator.kinematics
    exact = constraint_condition.of_gradient(k.mechanism, k.sweep.gradient())
    assert len(k.E) > 100
    assert constraint_condition._estimate(k) == pytest.approx(exact, rel=3e-3)
