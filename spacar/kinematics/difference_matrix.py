"""The difference matrix dD/dx made comparable: lengths and rotations without dimension (theory-system.md 1.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism.mechanism import Mechanism

ZERO = float(np.sqrt(np.finfo(float).eps))  # singular values below this part of the largest count as zero
Entries = tuple[Index | NDArray[np.int32], Index | NDArray[np.int32], Array]


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
