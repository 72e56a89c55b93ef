"""What is told from a bound, without the full computation, is the same as with it."""

from types import SimpleNamespace

import numpy as np
import pytest

from spacar.errors import Report
from spacar.linear.backward_error import of_pencil, of_scaled_pencil
from spacar.linear.buckling import directional_compliances, order_of
from spacar.linear.eigen import is_symmetric


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
