"""Is a position that solves D(x) = e to rounding a single root, or are two of them nearer than rounding tells apart?

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

from spacar.arrays import Array, Index
from spacar.kinematics.element_sweep import ElementSweep
from spacar.linear_systems import LinearSystem
from spacar.linear_systems.reciprocal_condition import smallest

EPS = float(np.finfo(float).eps)


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
