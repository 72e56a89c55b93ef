"""Condensed and band matrices of random frames against the dense mixed matrix: solutions, signs, compliances; repeated
modes."""

import numpy as np
import pytest

import spacar
from spacar.linear import form
from spacar.linear_systems import assemble
from spacar.linear_systems.condensed import CondensedSystem
from spacar.linear_systems.linear_system import SingularMatrixError
from spacar.linear_systems.matrix_inertia import Inertia
from spacar.linear_systems.selected_inverse import inverse_diagonal, selected_inverse
from spacar.stationary.tangent import STATIC

from .random_frames import frame, tangent_of

NAMES = tuple(STATIC)


def condensed(t):
    """The system of a tangent, factored, and the dense matrix."""
    n, (rows, columns) = t.nf + t.ne, t.pattern(NAMES)
    entries, size = t.entries(STATIC)
    A = np.zeros((n, n))
    np.add.at(A, (rows, columns), entries)
    system = CondensedSystem(n, rows, columns, t.nf)
    system.factor(entries)
    return system, A, size


def equilibrated_spectrum(A):
    for _ in range(5):
        d = 1.0 / np.sqrt(np.abs(A).max(axis=1))
        A = A * d * d[:, None]
    return np.linalg.eigvalsh((A + A.T) / 2.0)


def exact_solution(A, b):
    """Refined: an unrefined one of a stiffness ratio of 1e8 has 1e-10 itself."""
    x = np.linalg.solve(A, b)
    for _ in range(3):
        x = x + np.linalg.solve(A, b - A @ x)
    return x


def check(seed, spatial, ratio, rigid, stress, warping=False):
    """Everything against dense algebra; whether the signs were told by the condensed factors."""
    t = tangent_of(frame(seed, spatial, ratio, rigid, warping=warping), seed, stress)
    system, A, size = condensed(t)
    spectrum = equilibrated_spectrum(A)
    assert np.abs(spectrum).min() > len(A) * 1e-15  # no sign is in doubt
    negative = int(np.sum(spectrum < 0.0))
    assert system.negative() in (negative, None)
    assert system.determinant_sign() == np.linalg.slogdet(A)[0]
    b = np.random.default_rng(seed).standard_normal((len(A), 2))
    b[:, 0] = 0.0
    b[: t.nf, 0] = size
    for z, exact in (
        (system.solve(b), exact_solution(A, b)), (system.solve_transposed(b[:, 1]), exact_solution(A.T, b[:, 1])),
    ):  # fmt: skip
        assert np.abs(z - exact).max() <= 1e-11 * np.abs(exact).max()
    own = system.inverse_diagonal()
    exact = exact_solution(A, np.eye(len(A)))
    band = assemble(len(A), *t.pattern(NAMES), "banded")
    band.factor(t.entries(STATIC)[0])
    assert np.abs(band.refined(b) - exact_solution(A, b)).max() <= 1e-10 * np.abs(exact_solution(A, b)).max()
    compliances = exact.diagonal()[: t.nf]
    known = [found is None or np.abs(found - compliances).max() <= 1e-10 * np.abs(compliances).max()
             for found in (own, inverse_diagonal(band)[: t.nf])]  # fmt: skip
    assert known[0]
    return system.negative() is not None, negative > t.ne, known[1]


@pytest.mark.parametrize("spatial", [False, True])
@pytest.mark.parametrize(
    ("ratio", "rigid", "stress"),
    [(1.0, 0.0, 0.0), (1.0, 0.0, 3.0), (1e8, 0.0, 1.0), (1e8, 0.0, 300.0), (1e8, 0.3, 30.0), (1.0, 0.5, 10.0)],
)
def test_random_frames(spatial, ratio, rigid, stress):
    """Rigid members beside one another, and without them warping of the spatial ones."""
    told = [check(seed, spatial, ratio, rigid, stress, spatial and not rigid) for seed in range(3)]
    assert all(sign and known for sign, _, known in told)


@pytest.mark.slow
def test_signs_of_two_hundred_frames():
    """A good part of them behind their critical loads."""
    rng = np.random.default_rng(3)
    told = [
        check(seed, seed % 4 == 0, 10.0 ** rng.integers(0, 9), 0.3 * rng.integers(0, 2), 10.0 ** rng.uniform(0.0, 3.5))
        for seed in range(200)
    ]
    assert sum(sign for sign, _, _ in told) > 190
    assert sum(unstable for _, unstable, _ in told) > 40
    assert sum(known for _, _, known in told) > 198  # bands are not refined: 1.01e-10 once


@pytest.mark.parametrize("spatial", [False, True])
@pytest.mark.parametrize("stress", [0.0, 3.0])
def test_a_frame_free_in_space_leaves_the_count_to_the_mixed_matrix(spatial, stress):
    """Rigid motions: without stresses 3 or 6 zero eigenvalues, with them the translations at least."""
    t = tangent_of(frame(1, spatial, held=False), 1, stress)
    system, A, _ = condensed(t)
    spectrum = equilibrated_spectrum(A)
    zero = int(np.sum(np.abs(spectrum) < len(A) * 2.3e-16))
    assert zero >= (3 if spatial else 2)
    assert system.negative() is None
    count = Inertia(len(A), *t.pattern(NAMES))(t.entries(STATIC)[0])
    assert count == (int(np.sum(spectrum < -len(A) * 2.3e-16)), zero)


def test_constraints_in_a_large_group_have_springs(monkeypatch):
    """Rigid members, for which no basis is made: the same solutions, signs and compliances."""
    t = tangent_of(frame(2, True, rigid=0.4), 2, 3.0)
    _, A, size = condensed(t)
    for limit in ("LOCAL", "LARGEST"):
        monkeypatch.setattr(f"spacar.linear_systems.condensed.{limit}", 10)
    system = condensed(t)[0]
    assert len(system.weights) > 10
    b = np.zeros(len(A))
    b[: t.nf] = size
    exact = np.linalg.solve(A, b)
    assert np.abs(system.solve(b) - exact).max() <= 1e-10 * np.abs(exact).max()
    assert system.negative() == int(np.sum(equilibrated_spectrum(A) < 0.0))


def test_follower_forces_leave_no_signs_but_solutions():
    """An unsymmetric tangent: solutions, transposed ones and the sign of the determinant."""
    t = tangent_of(frame(4, True), 4, 1.0)
    n, (rows, columns) = t.nf + t.ne, t.pattern(NAMES)
    entries, _ = t.entries(STATIC)
    entries[: len(t.parts["geometric"].rows)] += 0.3 * np.random.default_rng(2).standard_normal(
        len(t.parts["geometric"].rows)
    )
    A = np.zeros((n, n))
    np.add.at(A, (rows, columns), entries)
    system = CondensedSystem(n, rows, columns, t.nf)
    system.factor(entries)
    b = np.random.default_rng(1).standard_normal(n)
    for z, exact in ((system.solve(b), np.linalg.solve(A, b)), (system.solve_transposed(b), np.linalg.solve(A.T, b))):
        assert np.abs(z - exact).max() <= 1e-11 * np.abs(exact).max()
    assert system.negative() is None
    assert system.inverse_diagonal() is None
    assert system.determinant_sign() == np.linalg.slogdet(A)[0]


def test_constraints_that_repeat_each_other_are_singular():
    """V has the same row twice."""
    rows, columns = np.array([0, 1, 2, 2, 3, 3, 0, 1, 0, 1]), np.array([0, 1, 0, 1, 0, 1, 2, 2, 3, 3])
    system = CondensedSystem(4, rows, columns, 2)
    with pytest.raises(SingularMatrixError):
        system.factor(np.array([1.0, 1.0, 3.0, 4.0, 3.0, 4.0, 3.0, 4.0, 3.0, 4.0]))


@pytest.mark.parametrize("n", [1, 30, 200])
def test_selected_inverse(n):
    """Against the dense inverse, at all places of the factors, with entries of L that are zero left out."""
    from scipy.sparse import csc_array

    rng = np.random.default_rng(n)
    A = np.diag(np.full(n, 4.0)) + np.diag(np.full(n - 1, -1.0), 1) + np.diag(np.full(n - 1, -1.0), -1)
    for i, j in rng.integers(0, n, (n // 3, 2)):
        if i != j:
            A[i, j] = A[j, i] = 0.3
    L = np.linalg.cholesky(A)
    d = L.diagonal() ** 2
    unit = csc_array(L / L.diagonal())
    rows, columns = np.nonzero(A)
    found = selected_inverse(unit, d, rows, columns)
    np.testing.assert_allclose(found, np.linalg.inv(A)[rows, columns], rtol=1e-10, atol=1e-14)


def test_selected_inverse_where_entries_cancel():
    """Column 4 of L lacks rows 5 and 6, where pairs of the columns before cancel; the inverse has them."""
    from scipy.sparse import csc_array

    L = np.eye(8)
    L[4, :4] = 0.5
    L[5, :4], L[6, :3:2], L[7, 1:4:2] = [0.5, 0.5, -0.5, -0.5], [0.5, -0.5], [0.5, -0.5]
    L[7, [4, 6]] = 0.5
    A = L @ L.T
    rows, columns = np.nonzero(A)
    found = selected_inverse(csc_array(L), np.ones(8), rows, columns)
    np.testing.assert_allclose(found, np.linalg.inv(A)[rows, columns], atol=1e-14)


@pytest.mark.parametrize("held", [True, False])
def test_repeated_frequencies_are_complete(held, monkeypatch):
    """A tower of square section has its bending modes twice, a free one its rigid motions six times."""
    deck = frame(0, True, cells=(4, 1, 1), held=held, noise=0.0)
    dense = spacar.run(7, deck).frames[0].matrices["eigval"][:, 1]
    monkeypatch.setattr(form, "LARGE", 0)
    few = spacar.run(7, deck, modes=12).frames[0].matrices["eigval"][:, 1]
    all_of_them, found = np.sort(np.abs(dense))[:24], np.sort(np.abs(few))
    np.testing.assert_allclose(found**2, all_of_them**2, rtol=1e-8, atol=1e-8 * found[-1] ** 2)
    if held:
        assert np.sum(np.diff(found[::2]) < 1e-6 * found[1::2][1:]) >= 3  # pairs
