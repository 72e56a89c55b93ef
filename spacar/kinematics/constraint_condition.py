"""Condition number of the part of the difference matrix that is inverted: how well the degrees of freedom are chosen.

s_1/s_n by a singular value decomposition; for more than 400 unknowns the 1-norm condition |D| |D^-1|, with |D^-1|
estimated (Higham and Tisseur) from a few solutions with the factorization that is there anyway: linear cost, and within
a factor n of s_1/s_n. Rows and columns are scaled to be dimensionless.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.kinematics.difference_matrix import scaled_difference_matrix
from spacar.kinematics.kinematics import Kinematics
from spacar.mechanism.mechanism import Mechanism

ESTIMATED_FROM = 400  # unknowns


def condition_number(k: Kinematics) -> float:
    """At the placed configuration; infinite when singular, 1 without unknowns."""
    if len(k.E) > ESTIMATED_FROM:
        return _estimate(k)
    return of_gradient(k.mechanism, k.sweep.gradient())


def of_gradient(mechanism: Mechanism, V: Array) -> float:
    """The same from V, (ne, nx), for some hundred unknowns at most."""
    E, U = mechanism.numbering.velocity_equations, mechanism.numbering.velocity_unknowns
    if not len(E):
        return 1.0
    D = scaled_difference_matrix(mechanism, V)[E[:, None], U]
    s = np.linalg.svd(D, compute_uv=False)
    return float(s[0] / s[-1]) if s[-1] > 0.0 else float("inf")


def _estimate(k: Kinematics) -> float:
    from scipy.sparse.linalg import LinearOperator, onenormest

    sweep, n = k.sweep, len(k.E)
    rows, columns = k.mechanism.deformation_scale, k.mechanism.scale
    chosen_row, chosen_column = np.zeros(sweep.ne, bool), np.zeros(sweep.nx, bool)
    chosen_row[k.E], chosen_column[k.U] = True, True
    part = chosen_row[sweep.v_rows] & chosen_column[sweep.v_columns]
    i, j = sweep.v_rows[part], sweep.v_columns[part]
    size = float(np.max(np.bincount(j, np.abs(sweep.v_entries[part]) * columns[j] / rows[i])))
    r, c = rows[k.E], columns[k.U]

    def inverse(b: Array) -> Array:
        return np.asarray(k.velocity_system.solve(b.ravel() * r) / c)

    def inverse_transposed(b: Array) -> Array:
        return np.asarray(k.velocity_system.solve_transposed(b.ravel() / c) * r)

    operator = LinearOperator((n, n), matvec=inverse, rmatvec=inverse_transposed, dtype=float)
    return size * float(onenormest(operator))
