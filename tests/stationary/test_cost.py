"""What small stationary solutions cost, in evaluations, which do not depend on the machine."""

from pathlib import Path

import pytest
from statics import cantilever

from spacar.deck import parse_deck
from spacar.errors import Report
from spacar.mechanism import build
from spacar.stationary import LoadProgram, StationarySolver

ROOT = Path(__file__).resolve().parents[2]


def evaluations(text: str) -> int:
    m = build(parse_deck(text, mode=7), 7)
    solver = StationarySolver(m, Report())
    for level in LoadProgram(m.settings):
        solver.solve(level)
    return solver.dynamics.sweep.count


@pytest.mark.parametrize(("name", "most"), [("crankfl", 10), ("finger", 10), ("fingersim", 27), ("lateral4", 8)])
def test_examples(name, most):
    """Four load steps each; a crank under inertia forces, fingers whose stiffness is that of their loads,
    one of them from a displaced start, which is held under all loads."""
    assert evaluations((ROOT / "data" / f"{name}.dat").read_text()) <= most


def test_the_way_back_ends_when_it_is_known_where_it_leads():
    """A cantilever bent by 82 degrees in ten steps; the first part is walked back to the unloaded state, where no
    residual is small beside the forces."""
    text = cantilever(10).replace("ITERSTEP 20 4", "ITERSTEP 20 10")
    assert evaluations(text) <= 50
