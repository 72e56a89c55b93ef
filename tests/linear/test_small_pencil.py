"""Small matrices in C (pencil.c) give what NumPy gives, and leave to it what has to be decided."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from spacar.compiled.library import why_off
from spacar.compiled.small_pencil import LARGEST, NotSmall, SmallPencil, compliances
from spacar.errors import Report
from spacar.linear import backward_error, buckling, eigen
from spacar.linear.buckling import CERTAIN, NEGLIGIBLE, buckling_modes, directional_compliances
from spacar.linear.eigen import SYMMETRIC, small_pencil, undamped_modes

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
ROUNDING = 1e-11  # of matrices whose condition is below 1e3 after scaling


def matrices(n, seed=3):
    """Symmetric, and symmetric and positive definite, in units that differ by 1e6."""
    rng = np.random.default_rng(seed)
    A, B, unit = rng.normal(size=(n, n)), rng.normal(size=(n, n)), 10.0 ** rng.uniform(-3, 3, n)
    scale = np.outer(unit, unit)
    return (A + A.T) * scale, (B @ B.T + n * np.eye(n)) * scale


def refused(*args, **kwargs):
    raise AssertionError("NumPy was asked")


@pytest.mark.parametrize("n", [1, 2, 7, 26, LARGEST])
def test_load_multipliers_are_those_of_numpy(n, monkeypatch):
    G, K = matrices(n)
    expected = buckling_modes(K, G, report := Report())
    monkeypatch.setattr(buckling, "is_symmetric", refused)
    found = buckling_modes(K, G, report, compiled=True)
    np.testing.assert_allclose(found.multipliers, expected.multipliers, rtol=ROUNDING)
    signs = np.sign((found.modes * expected.modes).sum(axis=0))
    np.testing.assert_allclose(found.modes * signs, expected.modes, atol=1e-9)  # the values differ by a hundredth
    assert not report.lines


def test_a_load_on_some_unknowns_has_infinite_multipliers():
    K, G = np.diag([2.0, 3.0, 5.0]), np.diag([0.0, -1.0, 1e-30])
    found = buckling_modes(K, G, Report(), compiled=True)
    np.testing.assert_allclose(found.multipliers, [3.0, np.inf, np.inf], rtol=1e-15)


@pytest.mark.parametrize("n", [1, 2, 7, 26, LARGEST])
def test_frequencies_are_those_of_numpy(n):
    A, M = matrices(n)
    K = A @ np.linalg.solve(M, A) + 0.1 * M
    K = (K + K.T) / 2
    expected = undamped_modes(K, M, report := Report())
    small = small_pencil(K, M, 1.0 / np.sqrt(M.diagonal()))
    found = undamped_modes(K, M, report, small=small)
    np.testing.assert_allclose(found.values, expected.values, rtol=ROUNDING)
    size = np.abs((found.vectors.conj() * expected.vectors).sum(axis=0))
    np.testing.assert_allclose(size, 1.0, rtol=1e-9)
    assert not report.lines


def test_oscillations_are_arranged_as_all_modes_are():
    rng = np.random.default_rng(8)
    squares, shapes = rng.uniform(1.0, 9.0, 5), rng.normal(size=(6, 5))
    root = np.sqrt(squares)
    values, both = np.concatenate((1j * root, -1j * root)), np.hstack((shapes, shapes))
    expected = eigen.arranged(values, np.vstack((both, both * values)), 6)
    found = eigen._oscillations(squares, shapes)
    np.testing.assert_allclose(found.values, expected.values, rtol=1e-15)
    np.testing.assert_allclose(found.vectors, expected.vectors, atol=1e-15)


def test_the_backward_error_is_that_of_numpy():
    A, B = matrices(9)
    d = 1.0 / np.sqrt(B.diagonal())
    pencil = SmallPencil(A, B, d, SYMMETRIC)
    values, vectors = pencil.pairs()
    assert pencil.error(values, vectors).max() < backward_error.EPS * 9
    wrong, few = values[[1, 4]] * (1.0 + 1e-7), vectors[:, [1, 4]]
    expected = backward_error.of_pencil(A, B, wrong, few, d)
    np.testing.assert_allclose(pencil.error(wrong, few), expected, rtol=1e-5)  # a residual of 1e-8 of its terms


@pytest.mark.parametrize("what", ["indefinite", "pivot", "unsymmetric A", "unsymmetric B", "not a number", "large"])
def test_what_has_to_be_decided_is_left_to_numpy(what):
    n = LARGEST + 1 if what == "large" else 4
    A, B = matrices(n)
    least = 0.0
    if what == "indefinite":
        B[1] *= -1.0
        B[:, 1] *= -1.0
        B[1, 1] *= -1.0
    elif what == "pivot":
        B, least = np.array([[1.0, 1.0 - 1e-15], [1.0 - 1e-15, 1.0]]), 1e-14
        A = np.eye(2)
    elif what == "not a number":
        A[2, 2] = np.nan
    elif what.startswith("unsymmetric"):
        changed = A if what.endswith("A") else B
        changed[0, 1] += 1e-6 * np.sqrt(abs(changed[0, 0] * changed[1, 1]))
    with pytest.raises(NotSmall):
        SmallPencil(A, B, 1.0 / np.sqrt(np.abs(B.diagonal())), SYMMETRIC, least)


@pytest.mark.parametrize("n", [1, 5, 26])
def test_compliances_are_those_of_numpy(n, monkeypatch):
    A, K = matrices(n)
    K[0, n - 1] *= 1.01  # a follower load: K is not symmetric
    W = np.vstack((np.diag(1.0 / np.sqrt(K.diagonal())), np.zeros(n), A / np.abs(A).max(axis=0)))
    L = SimpleNamespace(stiffness=K, W=W)
    everything = np.arange(n)
    expected = directional_compliances(L, everything, Report())
    monkeypatch.setattr(buckling, "_scale", refused)
    found = directional_compliances(L, everything, Report(), compiled=True)
    np.testing.assert_allclose(found, expected, rtol=ROUNDING, atol=0.0)


@pytest.mark.parametrize("digits", [11, 13, None])
def test_compliances_of_a_stiffness_that_may_be_singular_are_left_to_numpy(digits):
    s = 0.0 if digits is None else 10.0**-digits
    Q = np.array([[0.6, 0.8], [-0.8, 0.6]])
    found = compliances(Q @ np.diag([1.0, s]) @ Q.T, np.eye(2), NEGLIGIBLE, CERTAIN)
    assert (found is None) == (digits != 11)
