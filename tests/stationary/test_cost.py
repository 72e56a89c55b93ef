"""What small stationary solutions cost, in evaluations, which do not depend on the machine."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from spacar.deck import parse_deck
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import Report
from spacar.linear_systems.matrix import dense
from spacar.linearization import contractions
from spacar.mechanism import build
from spacar.stationary import StationarySolver, load_program
from spacar.stationary.rate_matrices import RateMatrices, SquareSum

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
from statics import cantilever

ROOT = Path(__file__).resolve().parents[2]


def evaluations(text: str) -> int:
    m = build(parse_deck(text, mode=7), 7)
    solver = StationarySolver(m, Report())
    for level in load_program(m.settings):
        solver.solve(level)
    return solver.dynamics.sweep.count


@pytest.mark.parametrize(("name", "most"), [("crankfl", 10), ("finger", 10), ("fingersim", 18), ("lateral4", 8)])
def test_examples(name, most):
    """Four load steps each; a crank under inertia forces, fingers whose stiffness is that of their loads."""
    assert evaluations((ROOT / "data" / f"{name}.dat").read_text()) <= most


def test_the_way_back_ends_when_it_is_known_where_it_leads():
    """A cantilever bent by 82 degrees in ten steps; the first part is walked back to the unloaded state, where no
    residual is small beside the forces."""
    text = cantilever(10).replace("ITERSTEP 20 4", "ITERSTEP 20 10")
    assert evaluations(text) <= 50


@pytest.mark.parametrize("name", ["crankfl", "trike3v", "screw", "robotflexsim", "finger"])
def test_matrices_of_rates_are_those_of_the_linearization(name):
    d = Dynamics(build(parse_deck((ROOT / "data" / f"{name}.dat").read_text(), mode=7), 7))
    sweep = d.sweep
    sweep.strain(d.kinematics.x)
    v, a = np.random.default_rng(1).standard_normal((2, sweep.nx))
    H1, second, swept = RateMatrices(sweep)(v, a)
    by_v = dense(contractions.gradient_rate(sweep, v))
    expected = by_v, by_v + dense(contractions.gradient_transport(sweep, v))
    expected += (dense(contractions.gradient_rate(sweep, a)) + dense(contractions.rate_gradient(sweep, v)),)
    for found, known in zip((H1, second, swept), expected, strict=True):
        np.testing.assert_allclose(found, known, rtol=1e-13, atol=1e-13 * max(np.abs(known).max(initial=0.0), 1e-300))
    blocks = contractions.geometric_blocks(sweep, np.arange(float(sweep.ne)))
    np.testing.assert_allclose(SquareSum(sweep.nx)(blocks), dense(contractions.scatter(sweep.nx, blocks)), rtol=1e-13)
