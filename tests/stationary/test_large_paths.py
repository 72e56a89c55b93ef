"""More unknowns than are counted at every level: the determinant of the factorization tells where to count."""

import pytest

from spacar import Deck
from spacar.errors import Report
from spacar.mechanism import build
from spacar.stationary import LoadProgram, StationarySolver, continuation
from spacar.stationary.level_evaluator import ArrayEquilibrium


def report_of_column(n: int, load: float, steps: int) -> list[str]:
    """A straight column of length 1 with EI = 1, clamped at its foot, in n beams, loaded in equal steps."""
    rows: list[tuple] = [("PLBEAM", k + 1, 2 * k + 1, 2 * k + 2, 2 * k + 3, 2 * k + 4) for k in range(n)]
    rows += [("X", 2 * k + 1, k / n, 0.0) for k in range(1, n + 1)] + [("FIX", 1), ("FIX", 2)]
    rows += [("DYNE", k + 1, 1, 2, 3) for k in range(n)]
    dynamics: list[tuple] = [("ESTIFF", k + 1, 1e4, 1.0) for k in range(n)]
    m = build(Deck.build(rows, [*dynamics, ("XF", 2 * n + 1, -load), ("ITERSTEP", 20, steps, 1e-8)]), 7)
    solver = StationarySolver(m, Report())
    for level in LoadProgram(m.settings):
        solver.solve(level)
    return solver.report.lines


@pytest.mark.parametrize("n", [20, 120])
def test_a_critical_load_between_stored_levels_is_said_where_it_is(n: int) -> None:
    """pi^2/4 = 2.467 of the load 4 is 0.617: the path loses its stability in step 7 of 10, nothing else is stored."""
    report = report_of_column(n, 4.0, 10)
    passed = [line for line in report if "critical state is passed" in line]
    assert len(passed) == 1
    assert "load step 7 of 10" in passed[0]
    assert "1 negative eigenvalue more" in passed[0]
    assert any("unstable equilibrium" in line for line in report)


def test_levels_between_stored_ones_cost_no_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """Below the critical load: one count at the start, one at the stored level."""
    counts, counted = [], ArrayEquilibrium.stability
    monkeypatch.setattr(ArrayEquilibrium, "stability", lambda *a: counts.append(counted(*a)) or counts[-1])
    report_of_column(120, 2.0, 10)
    assert [c.negative for c in counts] == [0, 0]
    assert continuation.LARGE < 3 * 120 * 2
