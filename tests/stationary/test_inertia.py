"""Count of negative eigenvalues: exact, and with linear cost."""

import numpy as np
import pytest
from statics import cantilever

from spacar.deck import parse_deck
from spacar.errors import Report
from spacar.linear_systems import matrix_inertia
from spacar.linear_systems.matrix_inertia import Inertia
from spacar.mechanism import build
from spacar.stationary import LoadProgram, StationarySolver
from spacar.stationary.resting_tangent import RestingTangent


def chain(k: int, free: bool) -> tuple[int, np.ndarray, np.ndarray, np.ndarray]:
    """k masses and k or k - 1 springs of compliance 1 in a row, every third one rigid and one mass in four drawn by a
    negative spring to the ground; unknowns in random order."""
    n = 2 * k
    A = np.zeros((n, n))
    for i in range(free, k):  # spring i between masses i - 1 and i
        A[k + i, i] = A[i, k + i] = 1.0
        if i:
            A[k + i, i - 1] = A[i - 1, k + i] = -1.0
        A[k + i, k + i] = -1.0 * (i % 3 > 0)
    A[k, k] = -1.0 if free else A[k, k]
    A[range(3, k, 4), range(3, k, 4)] = -0.03
    p = np.random.default_rng(k).permutation(n)
    A = A[np.ix_(p, p)]
    rows, columns = np.nonzero(A)
    return n, rows, columns, A[rows, columns]


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("k", [20, 100, 317])
def test_both_ways_agree_with_the_spectrum(k, free):
    n, rows, columns, entries = chain(k, free)
    A = np.zeros((n, n))
    A[rows, columns] = entries
    spectrum = np.linalg.eigvalsh(A)
    assert np.abs(spectrum).min() > 1e-6  # no sign is in doubt
    expected = int(np.sum(spectrum < 0.0)), 0
    count = Inertia(n, rows, columns)
    assert count(entries) == expected
    if n > matrix_inertia.SINGLE:
        values = count._equilibrated(entries)
        assert matrix_inertia._by_spectra(n, count._blocks(values, False, matrix_inertia.SMALLEST_BLOCK)) == expected
        blocks = count._blocks(values, False, matrix_inertia.FACTORED_BLOCK)
        assert matrix_inertia._by_factors(n, blocks) in (expected[0], None)


def test_few_directions_wait(monkeypatch):
    """A chain of beams before and after its bending: what is small but not coupled must not wait for the last block.

    The blocks of all orders together would make the cost grow with the cube of the number of beams.
    """
    m = build(parse_deck(cantilever(200), mode=7), 7)
    orders, eigh = [], np.linalg.eigh
    seen: list[tuple[int, int]] = []

    def counted(self, point):
        count = self.t.pattern(("geometric", "load", "moment"))
        solver = Inertia(self.t.nf + self.t.ne, *count)
        blocks = solver._blocks(solver._equilibrated(self.entries(point)), False, matrix_inertia.SMALLEST_BLOCK)
        monkeypatch.setattr(np.linalg, "eigh", lambda S: (orders.append(len(S)), eigh(S))[1])
        seen.append(matrix_inertia._by_spectra(solver.n, blocks))
        monkeypatch.setattr(np.linalg, "eigh", eigh)
        assert seen[-1] == self.inertia(point)
        return False  # not proved: the walk counts

    monkeypatch.setattr(RestingTangent, "is_definite", counted)
    solver = StationarySolver(m, Report())
    for level in LoadProgram(m.settings):
        solver.solve(level)
    assert seen
    assert max(orders) <= 2 * matrix_inertia.SMALLEST_BLOCK
