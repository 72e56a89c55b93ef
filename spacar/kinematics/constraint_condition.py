"""Condition number of the part of the difference matrix that is inverted: how well the degrees of freedom are chosen.

s_1/s_n by a singular value decomposition. For more than 150 unknowns, where it costs more than a factorization many
times over, s_1 and 1/s_n are the largest singular values of D and of D^-1 by Golub-Kahan
bidiagonalization (G. Golub, W. Kahan, SIAM J. Numer. Anal. 2 (1965) 205-224) with the factorization that is there
anyway: linear cost, and values that are too small by two thousandths at most where it was tried. Rows and columns are
scaled to be dimensionless.
"""

from collections.abc import Callable

import numpy as np

from spacar.arrays import Array
from spacar.kinematics.constraint_matrices import Entries, entries_of, scaled_difference_matrix
from spacar.kinematics.kinematics import Kinematics
from spacar.mechanism.mechanism import Mechanism

ESTIMATED_FROM = 150
STEPS = 40  # of the bidiagonalization, at most
STEADY = 1e-4  # relative change of the largest singular value in two steps that ends it


def condition_number(k: Kinematics) -> float:
    """At the placed configuration; infinite when singular, 1 without unknowns."""
    if len(k.E) > ESTIMATED_FROM:
        return _estimate(k)
    return of_entries(k.mechanism, entries_of(k.sweep))


def of_entries(mechanism: Mechanism, entries: Entries) -> float:
    """The same from the entries of V, for some hundred unknowns at most."""
    n = mechanism.numbering
    return of_scaled(scaled_difference_matrix(mechanism, entries, n.velocity_equations, n.velocity_unknowns))


def of_scaled(D: Array) -> float:
    """s_1/s_n of D (n, n)."""
    if not len(D):
        return 1.0
    s = np.linalg.svd(D, compute_uv=False)
    return float(s[0] / s[-1]) if s[-1] > 0.0 else float("inf")


def _estimate(k: Kinematics) -> float:
    part, system, n = k.of_velocity, k.velocity_system, len(k.E)
    i, j, r, c = part.i, part.j, k.mechanism.deformation_scale[k.E], k.mechanism.scale[k.U]
    D = k.sweep.v_entries[part.take] * c[j] / r[i]
    size = _largest(lambda x: np.bincount(i, D * x[j], n), lambda y: np.bincount(j, D * y[i], n), n)
    inverse = _largest(lambda y: system.solve(y * r) / c, lambda x: system.solve_transposed(x / c) * r, n)
    return size * inverse


def _largest(times: Callable[[Array], Array], transposed: Callable[[Array], Array], n: int) -> float:
    """The largest singular value of an operator (n, n), from below."""
    right = np.zeros((STEPS + 1, n))  # orthonormal
    right[0] = np.random.default_rng(1).standard_normal(n)
    right[0] /= np.linalg.norm(right[0])
    B = np.zeros((STEPS + 1, STEPS + 1))
    left, found = np.zeros(n), 0.0
    for step in range(STEPS):
        left = times(right[step]) - (B[step - 1, step] * left if step else 0.0)
        B[step, step] = norm = float(np.linalg.norm(left))
        if not 0.0 < norm < np.inf:
            return max(found, norm)
        left = left / norm
        following = transposed(left)
        following = following - right[: step + 1].T @ (right[: step + 1] @ following)  # exact orthogonality
        B[step, step + 1] = norm = float(np.linalg.norm(following))
        if step % 2:
            before, found = found, float(np.linalg.norm(B[: step + 1, : step + 2], 2))
            if found - before <= STEADY * found or norm == 0.0:
                break
        right[step + 1] = following / norm if norm else 0.0
    return found
