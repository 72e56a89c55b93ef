"""Slow poles and low frequencies of systems whose masses, springs and dampers differ by up to 1e16.

Truth: mpmath with 60 digits. Every eigenvalue, from the smallest on, to 1e-10.
"""

import mpmath
import numpy as np
import pytest
from scipy.linalg import block_diag

import spacar
from spacar import Deck, parse_deck
from spacar.errors import Report
from spacar.linear import eigen
from spacar.linear.eigen import modes_of_matrices
from spacar.linear.graded import Factors, graded_modes

DIGITS = 1e-10


def worst(found, truth):
    """Largest relative distance of a true eigenvalue to the nearest one."""
    return max(float(np.abs(np.asarray(found) - complex(z)).min() / abs(complex(z))) for z in truth)


def exact(M, C, K):
    """Eigenvalues of z^2 M + z C + K."""
    with mpmath.workdps(60):
        n = len(M)
        M, C, K = (mpmath.matrix(np.asarray(A).tolist()) for A in (M, C, K))
        A = mpmath.zeros(2 * n)
        inverse = mpmath.inverse(M)
        A[:n, n:], A[n:, :n], A[n:, n:] = mpmath.eye(n), -inverse * K, -inverse * C
        return mpmath.eig(A, left=False, right=False)


def modes(M, C, K):
    n = len(M)
    return modes_of_matrices(M, C, K, np.eye(n), np.zeros((n, n)), Report())


@pytest.mark.parametrize("c", [0.0, 1e-3, 2.0, 1e5, 1e7, 1e8, 1e9, 1e12, 1e15])
def test_overdamped_oscillator(c):
    one = np.eye(1)
    assert worst(modes(one, c * one, one).values, exact(one, c * one, one)) < DIGITS


@pytest.mark.parametrize("decades", [10, 14])
def test_graded_blocks_of_many_degrees_of_freedom(decades):
    """Eleven unconnected systems in mixed order: the truth is that of each alone."""
    rng = np.random.default_rng(decades)

    def graded():
        X, d = rng.normal(size=(4, 4)), 10.0 ** rng.uniform(-decades / 2, decades / 2, 4)
        return (X @ X.T + 4 * np.eye(4)) * np.sqrt(np.outer(d, d))

    blocks = [[0.5 * (A + A.T) for A in (graded(), graded(), graded())] for _ in range(11)]
    mixed = rng.permutation(44)
    M, C, K = (block_diag(*A)[np.ix_(mixed, mixed)] for A in zip(*blocks, strict=True))
    assert worst(modes(M, C, K).values, [z for block in blocks for z in exact(*block)]) < DIGITS


@pytest.mark.parametrize(("seed", "damped", "n"), [(k, d, 2 + k % 4) for k in range(6) for d in (0, 1)] + [(0, 1, 11)])
def test_graded_systems(seed, damped, n):
    """Definite matrices of condition ten whose rows and columns are scaled over ten decades."""
    rng = np.random.default_rng(seed)

    def graded():
        X, d = rng.normal(size=(n, n)), 10.0 ** rng.uniform(-5, 5, n)
        return (X @ X.T + n * np.eye(n)) * np.sqrt(np.outer(d, d))

    M, K, C = graded(), graded(), graded() if damped else np.zeros((n, n))
    M, K, C = (0.5 * (A + A.T) for A in (M, K, C))
    found, truth = modes(M, C, K), exact(M, C, K)
    assert worst(found.values, truth) < DIGITS
    z, x = found.values, found.vectors[:n]
    residual = np.abs((z * z) * (M @ x) + z * (C @ x) + K @ x)
    size = np.abs(z) ** 2 * (np.abs(M) @ np.abs(x)) + np.abs(z) * (np.abs(C) @ np.abs(x)) + np.abs(K) @ np.abs(x)
    assert (residual <= 1e-7 * size.max(axis=0)).all()


def two_masses(k1, k2, m1, m2, how, c):
    rows = [("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 2, 3), ("X", 2, 1.0, 0.0), ("X", 3, 2.0, 0.0), ("FIX", 1),
            ("FIX", 2, 2), ("FIX", 3, 2)]  # fmt: skip
    given = [("DYNX", 2, 1), ("DYNX", 3, 1), ("RLSE", 1), ("RLSE", 2)]
    rows += [("DYNE", 1, 1), ("DYNE", 2, 1)] if how == "DYNE" else given
    dynamics = [("ESTIFF", 1, k1), ("ESTIFF", 2, k2), ("XM", 2, m1), ("XM", 3, m2), ("EDAMP", 1, c)]
    return Deck.build(rows, dynamics[: 5 if c else 4])


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("how", ["DYNE", "DYNX"])
@pytest.mark.parametrize("c", [0.0, 1e3])
@pytest.mark.parametrize("ratio", [1e6, 1e10, 1e12, 1e15, 1e16])
def test_two_masses(ratio, c, how, compiled):
    """ground - k1, c - m1 - k2 - m2: one of the four numbers is large."""
    for k in range(4):
        k1, k2, m1, m2 = (ratio if k == i else 1.0 for i in range(4))
        found = spacar.run(7, two_masses(k1, k2, m1, m2, how, c), compiled=compiled)["eigval"][-1]
        with mpmath.workdps(60):
            k1, k2, m1, m2, d = map(mpmath.mpf, (k1, k2, m1, m2, c))
            p = [m1 * m2, m2 * d, m1 * k2 + m2 * (k1 + k2), d * k2, k1 * k2]
            truth = mpmath.polyroots(p, maxsteps=500, extraprec=500)
        assert worst(found[:, 0] + 1j * found[:, 1], truth) < DIGITS, k


def test_fine_mesh_needs_no_second_method(monkeypatch):
    """K in deformations keeps its digits: the low frequencies of 40 beams, 1e-8 of the highest, are those of Jacobi's
    method."""
    lines = [f"PLBEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2} DYNE {k} 2 3" for k in range(1, 41)]
    lines += [f"X {2 * k + 1} {k / 40} 0" for k in range(41)] + ["FIX 1 FIX 2 END HALT"]
    lines += [f"EM {k} 1 ESTIFF {k} 0 1" for k in range(1, 41)] + ["END END"]
    found = spacar.run(7, parse_deck("\n".join(lines)))
    K, M = found["k0"][0], found["m0"][0]
    squares, _ = graded_modes(Factors.of_matrices(K, M), K)
    monkeypatch.setattr(eigen, "graded_modes", None)
    low = squares < eigen.SPREAD * squares[-1]
    assert low.sum() == 6
    np.testing.assert_allclose(eigen.accurate(K, M)[0][low], squares[low], rtol=DIGITS)
