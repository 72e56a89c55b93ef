"""Few modes of a dense pencil are computed alone: they agree with all of them, and with what is known."""

from types import SimpleNamespace

import mpmath as mp
import numpy as np
import pytest
from scipy.linalg import block_diag

import spacar
from spacar.errors import Report
from spacar.linear import eigen
from spacar.linear.backward_error import of_pencil, of_scaled_pencil
from spacar.linear.buckling import directional_compliances, order_of
from spacar.linear.eigen import is_symmetric, modes_of_matrices
from spacar.linear.graded import Factors, graded_modes
from spacar.linear_systems.linear_system import is_zero_matrix, matrix, zero_matrix
from spacar.linearization.matrices import selected
from tests.examples import DATA


def random_pencil(n: int, squares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """K, M (n, n) of the known omega^2: M = L L^T, K = L Q diag Q^T L^T."""
    rng = np.random.default_rng(5)
    L = np.tril(rng.normal(size=(n, n))) / np.sqrt(n) + 2.0 * np.eye(n)
    Q = np.linalg.qr(rng.normal(size=(n, n)))[0]
    return L @ Q @ np.diag(squares) @ Q.T @ L.T, L @ L.T


@pytest.mark.parametrize("n", [61, 90])
def test_few_modes_are_the_lowest_of_all(n):
    """Known omega^2 over eight decades, a double one among the lowest three. Both ways solve a pencil that differs from
    K, M by rounding of their largest entries, which leaves every omega^2 an error of eps times the largest one."""
    squares = np.geomspace(1.0, 1e8, n)
    squares[2] = squares[1]
    K, M = random_pencil(n, squares)
    few = eigen.undamped_modes(K, M, Report(), 4)
    every = eigen.undamped_modes(K, M, Report())
    assert len(few.values) == 8
    # K is rounded to eps of its largest entries
    np.testing.assert_allclose(few.values.imag[::2] ** 2, squares[3::-1], rtol=1e-6)
    known = float(np.finfo(float).eps) * squares[-1]
    np.testing.assert_allclose(few.values.imag[::2] ** 2, every.values.imag[-8::2] ** 2, rtol=0, atol=known)
    np.testing.assert_array_equal(few.values.imag[1::2], -few.values.imag[::2])


def test_low_modes_keep_their_digits():
    """A chain of masses and springs in line: omega_k = 2 sin((2 k - 1) pi/(2 (2 n + 1))), and a stiff one far above."""
    n = 60
    K = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    K[-1, -1] = 1.0
    omega = 2 * np.sin((2 * np.arange(1, n + 1) - 1) * np.pi / (2 * (2 * n + 1)))
    everything, mass = np.zeros((n + 1, n + 1)), np.eye(n + 1)
    everything[:n, :n], everything[n, n] = K, 1e9
    few = eigen.undamped_modes(everything, mass, Report(), 3)
    np.testing.assert_allclose(few.values.imag[::2], omega[2::-1], rtol=1e-12)


def test_unstable_modes_of_lowest_modulus():
    """Two negative omega^2, one of them larger in modulus than the positive ones that are wanted."""
    squares = np.concatenate(([-50.0, -2.0], np.arange(1.0, 39.0)))
    K, M = random_pencil(40, squares)
    few = eigen.undamped_modes(K, M, Report(), 3)
    np.testing.assert_allclose((few.values**2).real[::2], [-2.0, 2.0, -1.0], rtol=1e-9)


def test_rows_in_another_order_and_matrices_of_zeros():
    for n in (4, 400):
        assert is_zero_matrix(zero_matrix((n, n)))
        assert is_zero_matrix(matrix(np.arange(n), np.arange(n), np.zeros(n), (n, n)))
    A = np.arange(9.0).reshape(3, 3)
    every, turned = np.arange(3), np.array([0, 2, 1])
    for rows, columns in ((turned, every), (every, turned), (every[1:], every[:2])):
        np.testing.assert_array_equal(selected(A, rows, columns), A[np.ix_(rows, columns)])


# What is told from a bound, without the full computation, is the same as with it.
@pytest.mark.parametrize("power", [0, 4, 8])
@pytest.mark.parametrize("relative", [0.0, 1e-13, 1e-10, 1e-8, 1e-6])
def test_symmetry_does_not_depend_on_units(power, relative):
    rng = np.random.default_rng(2)
    A = rng.normal(size=(6, 6))
    A = A @ A.T
    size = np.sqrt(np.diag(A))
    A[1, 4] += relative * size[1] * size[4]
    unit = 10.0 ** np.linspace(-power, power, 6)
    assert is_symmetric(A * np.outer(unit, unit)) == (relative < 1e-9)


@pytest.mark.parametrize("digits", [2, 11, 13])
def test_compliances_of_a_badly_conditioned_stiffness(digits):
    """K = Q diag(s) Q^T: the compliance of q_i is sum_k Q_ik^2/s_k, with and without singular values."""
    Q = np.array([[0.6, 0.8], [-0.8, 0.6]])
    s = np.array([1.0, 10.0**-digits])
    L = SimpleNamespace(stiffness=Q @ np.diag(s) @ Q.T, W=np.eye(2))
    report = Report()
    found = directional_compliances(L, np.arange(2), report)
    np.testing.assert_allclose(found, (Q**2 / s).sum(axis=1), rtol=10.0 ** (digits - 15))
    assert not report.lines


def test_compliances_of_a_singular_stiffness_are_infinite_where_it_moves():
    L = SimpleNamespace(stiffness=np.diag([2.0, 0.0]), W=np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]))
    report = Report()
    np.testing.assert_array_equal(directional_compliances(L, np.arange(2), report), [0.5, np.inf, 0.0])
    assert len(report.lines) == 1


def test_a_scaled_pencil_has_the_backward_error_of_the_pencil():
    rng = np.random.default_rng(4)
    A, B, z = rng.normal(size=(5, 5)), rng.normal(size=(5, 5)), rng.normal(size=(5, 3))
    values = np.array([1.0, -2.0, 3.0])
    d = 10.0 ** rng.normal(size=5)
    D = np.diag(d)
    expected = of_pencil(A, B, values, z, d)
    found = of_scaled_pencil(D @ A @ D, D @ B @ D, values, z / d[:, None])
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_order_with_and_without_pairs():
    np.testing.assert_array_equal(order_of(np.array([3.0, -1.0, 2.0])), [1, 2, 0])
    np.testing.assert_array_equal(order_of(np.array([3.0, -1.0, 1.0])), [2, 1, 0])


# Low modes of an unsymmetric stiffness, against 60 digits.
N = 8


def pencil(seed: int, damping: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """M, C, and K with omega^2 over ten decades on its diagonal in any order, coupled and unsymmetric."""
    rng = np.random.default_rng(seed)
    omega = rng.permutation(np.logspace(0.0, 5.0, N))
    K = (np.eye(N) + 0.1 * rng.normal(size=(N, N))) * np.outer(omega, omega)
    M = np.eye(N) + 0.1 * np.ones((N, N))
    return M, damping * np.diag(omega), K


@pytest.mark.parametrize(("seed", "damping"), [
    pytest.param(seed, damping, marks=[pytest.mark.slow] * ((seed, damping) not in ((0, 0.0), (1, 0.02))))
    for seed in range(5) for damping in (0.0, 0.02)
])  # fmt: skip
def test_every_mode_of_a_stiffness_over_ten_decades(seed: int, damping: float) -> None:
    """Half of the decades from either end: eps 1e10 / 1e5, and some for the coupling."""
    M, C, K = pencil(seed, damping)
    found = modes(M, C, K)
    assert worst(found.values, exact_values(M, C, K)) < 1e-9
    for value, z in zip(found.values, found.vectors.T, strict=True):
        q = z[:N]
        terms = [value**2 * (M @ q), value * (C @ q), K @ q]
        np.testing.assert_allclose(z[N:], value * q, atol=1e-9 * np.abs(z).max())
        assert np.abs(sum(terms)).max() < 1e-8 * sum(np.abs(t).max() for t in terms)


def test_low_modes_beside_a_motion_of_hardly_any_mass() -> None:
    """Also of a warped beam with a moment at its end, whose twist rate has next to no inertia; K is unsymmetric."""
    M = np.array([[2.0, 0.3, 1e-11], [0.3, 1.0, 2e-11], [1e-11, 2e-11, 1.5e-21]])
    K = np.array([[90.0, 4.0, 1.0], [-3.0, 40.0, 0.5], [0.8, 0.6, 2.0]])
    found = modes(M, np.zeros((3, 3)), K)
    want = exact_values(M, np.zeros((3, 3)), K)
    assert worst(found.values[-4:], sorted(want, key=abs)[:4]) < 1e-9
    rows = [("BEAMW", 1, 1, 2, 3, 4, 5, 6, 0.1, 1.0, 0.2), ("X", 4, 0.5, 0.1, 0.2), ("FIX", 1), ("FIX", 2), ("FIX", 3),
            ("DYNE", 1)]  # fmt: skip
    law = [("ESTIFF", 1, 90.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.05), ("EM", 1, 0.7, 0.01, 0.006, 0.007), ("XM", 4, 0.3),
           ("XF", 4, 0.3, -0.6, 0.4), ("XM", 5, 0.01, 0.0, 0.0, 0.01, 0.0, 0.01)]  # fmt: skip
    decks = [spacar.Deck.build(rows, [*law, ("XF", 5, moment)], mode=10) for moment in (0.0, 1e-4)]
    plain, turned = (spacar.run(10, deck).frequencies[0] for deck in decks)
    np.testing.assert_allclose(turned[:6], plain[:6], rtol=1e-4)


def test_a_rigid_motion_is_left_to_the_other_computation() -> None:
    K = np.array([[1.0, -1.0], [-1.0, 1.0 + 1e-13]])
    found = modes(np.eye(2), np.zeros((2, 2)), K)
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


# Slow poles and low frequencies of systems whose masses, springs and dampers differ by up to 1e16. Truth: mpmath
# with 60 digits. Every eigenvalue, from the smallest on, to 1e-10.
DIGITS = 1e-10


def worst(found, truth):
    """Largest relative distance of a true eigenvalue to the nearest one."""
    return max(float(np.abs(np.asarray(found) - complex(z)).min() / abs(complex(z))) for z in truth)


def exact_values(M, C, K):
    """Eigenvalues of z^2 M + z C + K."""
    with mp.workdps(60):
        n = len(M)
        M, C, K = (mp.matrix(np.asarray(A).tolist()) for A in (M, C, K))
        A = mp.zeros(2 * n)
        inverse = mp.inverse(M)
        A[:n, n:], A[n:, :n], A[n:, n:] = mp.eye(n), -inverse * K, -inverse * C
        return mp.eig(A, left=False, right=False)


def modes(M, C, K):
    n = len(M)
    return modes_of_matrices(M, C, K, np.eye(n), np.zeros((n, n)), Report())


@pytest.mark.parametrize("c", [0.0, 1e-3, 2.0, 1e5, 1e7, 1e8, 1e9, 1e12, 1e15])
def test_overdamped_oscillator(c):
    one = np.eye(1)
    assert worst(modes(one, c * one, one).values, exact_values(one, c * one, one)) < DIGITS


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
    assert worst(modes(M, C, K).values, [z for block in blocks for z in exact_values(*block)]) < DIGITS


@pytest.mark.parametrize(("seed", "damped", "n"), [(k, d, 2 + k % 4) for k in range(6) for d in (0, 1)] + [(0, 1, 11)])
def test_graded_systems(seed, damped, n):
    """Definite matrices of condition ten whose rows and columns are scaled over ten decades."""
    rng = np.random.default_rng(seed)

    def graded():
        X, d = rng.normal(size=(n, n)), 10.0 ** rng.uniform(-5, 5, n)
        return (X @ X.T + n * np.eye(n)) * np.sqrt(np.outer(d, d))

    M, K, C = graded(), graded(), graded() if damped else np.zeros((n, n))
    M, K, C = (0.5 * (A + A.T) for A in (M, K, C))
    found, truth = modes(M, C, K), exact_values(M, C, K)
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
    return spacar.Deck.build(rows, dynamics[: 5 if c else 4])


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("how", ["DYNE", "DYNX"])
@pytest.mark.parametrize("c", [0.0, 1e3])
@pytest.mark.parametrize("ratio", [1e6, 1e10, 1e12, 1e15, 1e16])
def test_two_masses(ratio, c, how, compiled):
    """ground - k1, c - m1 - k2 - m2: one of the four numbers is large."""
    for k in range(4):
        k1, k2, m1, m2 = (ratio if k == i else 1.0 for i in range(4))
        found = spacar.run(7, two_masses(k1, k2, m1, m2, how, c), compiled=compiled)["eigval"][-1]
        with mp.workdps(60):
            k1, k2, m1, m2, d = map(mp.mpf, (k1, k2, m1, m2, c))
            p = [m1 * m2, m2 * d, m1 * k2 + m2 * (k1 + k2), d * k2, k1 * k2]
            truth = mp.polyroots(p, maxsteps=500, extraprec=500)
        assert worst(found[:, 0] + 1j * found[:, 1], truth) < DIGITS, k


def test_fine_mesh_needs_no_second_method(monkeypatch):
    """K in deformations keeps its digits: the low frequencies of 40 beams, 1e-8 of the highest, are those of Jacobi's
    method."""
    lines = [f"PLBEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2} DYNE {k} 2 3" for k in range(1, 41)]
    lines += [f"X {2 * k + 1} {k / 40} 0" for k in range(41)] + ["FIX 1 FIX 2 END HALT"]
    lines += [f"EM {k} 1 ESTIFF {k} 0 1" for k in range(1, 41)] + ["END END"]
    found = spacar.run(7, spacar.parse_deck("\n".join(lines)))
    K, M = found["k0"][0], found["m0"][0]
    squares, _ = graded_modes(Factors.of_matrices(K, M), K)
    monkeypatch.setattr(eigen, "graded_modes", None)
    low = squares < eigen.SPREAD * squares[-1]
    assert low.sum() == 6
    np.testing.assert_allclose(eigen.accurate(K, M)[0][low], squares[low], rtol=DIGITS)


@pytest.mark.parametrize("wanted", [None, 6])
def test_numbers_that_overflow_give_nan(wanted: int | None) -> None:
    """Who computed them says what is wrong."""
    n = 80
    K = np.diag(np.arange(1.0, n + 1.0))
    K[0, 0] = np.inf
    squares, vectors = eigen.symmetric_pencil(K, np.eye(n), wanted)
    assert np.isnan(squares).any()
    assert squares.shape == (n,)
    assert vectors.shape == (n, n)
