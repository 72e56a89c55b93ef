"""The difference matrix dD/dx made comparable: lengths and rotations without dimension (theory-system.md 1.1).

`is_single_root`: is a position that solves D(x) = e to rounding a single root, or are two of them nearer than rounding
tells apart?

With the smallest singular value s of the scaled matrix D' (of the position, or of the velocities), D' w = s u, a change
a of the position along w changes the residual along u by

    s a + c a^2/2,    c = u^T H(w, w)                                       (H: second derivative of the deformations)

The second root is at a = -2 s/c. The residual is known to delta only, so that both roots cannot be told apart when

    s^2 <= 2 |c| delta

(the condition of Kantorovich, along the one direction that matters). There the position has the error s/c, and the
velocities, which go with 1/s, are wrong by half of their size. At a dead point c is of order one and s is zero; in a
long chain s is small, n^-2, but c nearly vanishes, and every position is determined. Rank-deficient to rounding is
s <= n eps |D'|.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.kinematics.element_sweep import ElementSweep
from spacar.linear_systems import LinearSystem
from spacar.linear_systems.reciprocal_condition import smallest
from spacar.mechanism.mechanism import Mechanism

ZERO = float(np.sqrt(np.finfo(float).eps))  # singular values below this part of the largest count as zero
Entries = tuple[Index | NDArray[np.int32], Index | NDArray[np.int32], Array]
EPS = float(np.finfo(float).eps)


def entries_of(sweep: ElementSweep) -> Entries:
    """Rows, columns and values of V where the sweep is."""
    return sweep.v_rows, sweep.v_columns, sweep.v_entries


def scaled_difference_matrix(mechanism: Mechanism, entries: Entries, E: Index, U: Index) -> Array:
    """The rows E and columns U of V without dimension, dense; `entries` are those of the whole V, repeated ones add
    up. No array is larger than that."""
    rows, columns, values = entries
    row, column = np.full(mechanism.numbering.ne, -1), np.full(mechanism.numbering.nx, -1)
    row[E], column[U] = np.arange(len(E)), np.arange(len(U))
    part = np.flatnonzero((row[rows] >= 0) & (column[columns] >= 0))
    i, j = rows[part], columns[part]
    scaled = values[part] * mechanism.scale[j] / mechanism.deformation_scale[i]
    D = np.bincount(row[i] * len(U) + column[j], scaled, len(E) * len(U))
    return np.asarray(D.reshape(len(E), len(U)))


def is_single_root(
    sweep: ElementSweep, system: LinearSystem, rows: Index, columns: Index, row_scale: Array, column_scale: Array,
    norm: float, rounding: float,
) -> bool:  # fmt: skip
    """At the configuration of the sweep. `system` is D' with these rows of e and columns of x, factored; `norm` the
    size of its scaled matrix, `rounding` delta of the scaled residual.
    """
    s, _, _, bend = fold(sweep, system, rows, columns, row_scale, column_scale)
    return bool(s > len(rows) * EPS * norm and s * s > 2.0 * abs(bend) * rounding)


def fold(
    sweep: ElementSweep, system: LinearSystem, rows: Index, columns: Index, row_scale: Array, column_scale: Array
) -> tuple[float, Array, Array, float]:
    """s, u, w, c at the configuration of the sweep."""
    s, u, w = smallest(system, row_scale, column_scale)
    v = np.zeros(sweep.nx)
    v[columns] = w * column_scale
    return s, u, w, float(u @ (sweep.convective(v)[rows] * row_scale))
