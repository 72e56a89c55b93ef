"""Low modes of an unsymmetric stiffness, against 40 digits."""

import numpy as np
import pytest

import spacar
from spacar.errors import Report
from spacar.linear.eigen import modes_of_matrices
from tests.examples import DATA

mp = pytest.importorskip("mpmath")
N = 8


def pencil(seed: int, damping: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """M, C, and K with omega^2 over ten decades on its diagonal in any order, coupled and unsymmetric."""
    rng = np.random.default_rng(seed)
    omega = rng.permutation(np.logspace(0.0, 5.0, N))
    K = (np.eye(N) + 0.1 * rng.normal(size=(N, N))) * np.outer(omega, omega)
    M = np.eye(N) + 0.1 * np.ones((N, N))
    return M, damping * np.diag(omega), K


def exact(M: np.ndarray, C: np.ndarray, K: np.ndarray) -> np.ndarray:
    with mp.workdps(40):
        A, inverse = mp.zeros(2 * N), mp.inverse(mp.matrix(M.tolist()))
        A[:N, N:] = mp.eye(N)
        A[N:, :N], A[N:, N:] = -inverse * mp.matrix(K.tolist()), -inverse * mp.matrix(C.tolist())
        values, _ = mp.eig(A)
        return np.array([complex(v) for v in values])


@pytest.mark.parametrize(("seed", "damping"), [
    pytest.param(seed, damping, marks=[pytest.mark.slow] * ((seed, damping) not in ((0, 0.0), (1, 0.02))))
    for seed in range(5) for damping in (0.0, 0.02)
])  # fmt: skip
def test_every_mode_of_a_stiffness_over_ten_decades(seed: int, damping: float) -> None:
    """Half of the decades from either end: eps 1e10 / 1e5, and some for the coupling."""
    M, C, K = pencil(seed, damping)
    found = modes_of_matrices(M, C, K, np.eye(N), np.zeros((N, N)), Report())
    truth = exact(M, C, K)
    for value in truth:
        nearest = found.values[np.argmin(np.abs(found.values - value))]
        assert abs(nearest - value) < 1e-9 * abs(value), (value, nearest)
    for value, z in zip(found.values, found.vectors.T, strict=True):
        q = z[:N]
        terms = [value**2 * (M @ q), value * (C @ q), K @ q]
        np.testing.assert_allclose(z[N:], value * q, atol=1e-9 * np.abs(z).max())
        assert np.abs(sum(terms)).max() < 1e-8 * sum(np.abs(t).max() for t in terms)


def test_a_rigid_motion_is_left_to_the_other_computation() -> None:
    K = np.array([[1.0, -1.0], [-1.0, 1.0 + 1e-13]])
    found = modes_of_matrices(np.eye(2), np.zeros((2, 2)), K, np.eye(2), np.zeros((2, 2)), Report())
    assert np.isfinite(found.values).all()
    assert np.abs(found.values).max() == pytest.approx(np.sqrt(2.0), rel=1e-12)


def eigenvalue_near(K: np.ndarray, M: np.ndarray, w: float) -> float:
    """omega^2 in 40 digits, from the shape and its left counterpart: two-sided Rayleigh quotient iteration."""
    with mp.workdps(40):
        A, B, value = mp.matrix(K.tolist()), mp.matrix(M.tolist()), mp.mpf(w)
        x, y = mp.ones(len(K), 1), mp.ones(len(K), 1)
        before = mp.mpf(0)
        while abs(value - before) > mp.mpf(10) ** -15 * abs(value):  # cubic: the last step leaves far less
            before = value
            near = A - value * (1 + mp.mpf(10) ** -30) * B
            x, y = mp.lu_solve(near, B * x), mp.lu_solve(near.T, B.T * y)
            x, y = x / mp.norm(x), y / mp.norm(y)
            value = (y.T * A * x)[0] / (y.T * B * x)[0]
        return float(value)


def test_the_loaded_cross_hinge_has_the_frequencies_of_its_matrices() -> None:
    """Unsymmetric by what the iteration leaves of the forces; the largest omega^2 is 2e9 times the second one, of which
    rounding took 1e-7 and more, otherwise on every kernel of OpenBLAS."""
    result = spacar.run(10, DATA / "crosshingew.dat")
    m = result.frames[-1].matrices
    K = m["k0"] + m["n0"] + m["g0"]
    assert not np.array_equal(K, K.T)
    for f in result.frequencies[-1][:3]:
        w = (2.0 * np.pi * f) ** 2
        assert w == pytest.approx(eigenvalue_near(K, m["m0"], w), rel=2e-8)  # entries of K: 4e-9
