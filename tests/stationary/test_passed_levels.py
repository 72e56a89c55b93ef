"""Levels that C passes in one call (`spacar.stationary.passed_levels`) against one level after the other."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from spacar.compiled.compiled_elements import with_compiled_elements
from spacar.compiled.library import why_off
from spacar.deck import parse_deck
from spacar.errors import AnalysisError, Report
from spacar.mechanism import build
from spacar.stationary import StationarySolver, load_program
from spacar.stationary.continuation import Continuation

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
from statics import cantilever

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))

COLUMN = """PLBEAM 1 1 2 3 4
PLBEAM 2 3 4 5 6
X 3 0. 0.5
X 5 0. 1.
FIX 1
FIX 2
DYNE 1 2 3
DYNE 2 2 3
END
HALT
ESTIFF 1 0. 1.
ESTIFF 2 0. 1.
XF 5 {side} -4.
ITERSTEP 20 {steps} 1e-10
END
END
"""
INITIAL = """PLBEAM 1 1 2 3 4
X 3 1. 0.
FIX 1
FIX 2
DYNE 1 2 3
END
HALT
ESTIFF 1 0. 1.
ESIG 1 0. 0.3 0.2
STARTDE 1 2 0.1
XF 3 0. 1.
DELXF 3 0.5 2.
ITERSTEP 20 9 1e-10 3 2 7
END
END
"""
TEXTS = {
    "cantilever": cantilever(8, 10.0, 12),
    "long": cantilever(40, 3.0, 9),
    "large steps": cantilever(8, 80.0, 6),
    "column": COLUMN.format(side="1e-3", steps=20),  # unstable beyond a quarter of pi^2
    "perfect column": COLUMN.format(side="0.", steps=16),
    "held start, additional loading": INITIAL,
}


def states(text: str) -> tuple[list, list[str], str]:
    m, report = build(parse_deck(text, 7), 7), Report()
    solver, found, error = StationarySolver(with_compiled_elements(m), report), [], ""
    try:
        for level, iterations in solver.stored(load_program(m.settings)):
            found.append((level, iterations, solver.dynamics.kinematics.x.copy(), solver.solution.sigma.copy()))
    except AnalysisError as failure:
        error = str(failure)
    return found, report.lines, error


@pytest.mark.parametrize("name", TEXTS)
def test_states_iterations_and_words_are_those_of_one_level_after_the_other(name, monkeypatch):
    passed: list[int] = []
    together = Continuation.pass_by

    def counted(self: Continuation, levels: list) -> int:
        passed.append(together(self, levels))
        return passed[-1]

    monkeypatch.setattr(Continuation, "pass_by", counted)
    found, lines, error = states(TEXTS[name])
    monkeypatch.setattr(Continuation, "pass_by", lambda self, levels: 0)
    expected, words, failure = states(TEXTS[name])
    assert (lines, error, len(found)) == (words, failure, len(expected))
    assert sum(passed) > 0 or name == "perfect column"
    for (level, iterations, x, sigma), (level_1, iterations_1, x_1, sigma_1) in zip(found, expected, strict=True):
        assert (level, iterations) == (level_1, iterations_1)
        np.testing.assert_allclose(x, x_1, rtol=0.0, atol=1e-11)
        np.testing.assert_allclose(sigma, sigma_1, rtol=0.0, atol=1e-10 * np.abs(sigma_1).max())


def test_what_needs_a_decision_is_left():
    """The load at which the column becomes unstable lies between two levels: the walk that C makes ends before it."""
    m = build(parse_deck(TEXTS["perfect column"], 7), 7)
    solver = StationarySolver(with_compiled_elements(m), Report())
    levels = list(load_program(m.settings))
    solver.solve(levels[0])
    walk = solver._walk
    assert walk is not None
    done = walk.pass_by(levels[1:-1])
    critical = 2.467 / 4.0 * len(levels)  # pi^2/4 EI/l^2
    assert 1 + done <= critical
    assert walk.level == levels[done]


def test_the_first_and_the_stored_level_are_passed_too(monkeypatch):
    """A smooth path: Python solves no level, also where the first part is walked back, and makes no equations."""
    from spacar.stationary.level_evaluator import LevelEvaluator, StationaryEquations

    monkeypatch.setattr(LevelEvaluator, "newton", lambda *_: pytest.fail("an iteration of Python"))
    monkeypatch.setattr(StationaryEquations, "__init__", lambda *_: pytest.fail("equations of NumPy"))
    found, lines, error = states(TEXTS["cantilever"])
    assert (len(found), lines, error) == (1, [], "")
