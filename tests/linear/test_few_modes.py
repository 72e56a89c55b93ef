"""Few modes of a dense pencil are computed alone: they agree with all of them, and with what is known."""

import numpy as np
import pytest

from spacar.errors import Report
from spacar.linear import eigen
from spacar.linear_systems.linear_system import is_zero_matrix, matrix, zero_matrix
from spacar.linearization.matrices import selected


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


def test_matrices_of_zeros():
    for n in (4, 400):
        assert is_zero_matrix(zero_matrix((n, n)))
        assert is_zero_matrix(matrix(np.arange(n), np.arange(n), np.zeros(n), (n, n)))


def test_rows_in_another_order():
    A = np.arange(9.0).reshape(3, 3)
    every, turned = np.arange(3), np.array([0, 2, 1])
    np.testing.assert_array_equal(selected(A, turned, every), A[turned])
    np.testing.assert_array_equal(selected(A, every, turned), A[:, turned])
    np.testing.assert_array_equal(selected(A, every[1:], every[:2]), A[1:, :2])
