"""Square linear systems with a fixed pattern, assembled from element entries and solved many times.

The pattern is a list of (row, column) pairs, repeated pairs add up. The storage is chosen once per model:
dense when the system is small, banded (reverse Cuthill-McKee ordering, LAPACK gbsv) where that takes less time than
the other form: condensed where the matrix has the mixed form of structures (`condensed`), else sparse (SuperLU).
Measured in benchmarks/linear_systems.py; theory-system.md section 2.3 gives the rule.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from spacar.linear_systems.linear_system import DenseSystem, LinearSystem, SingularMatrixError

__all__ = ["DENSE_LIMIT", "LinearSystem", "SingularMatrixError", "assemble"]

DENSE_LIMIT = 60  # unknowns; below, NumPy's dense solver is faster than any ordering
# Nanoseconds of a factorization and fifty solutions: n h (BAND[0] + BAND[1] h) of n unknowns with a band of h
# diagonals; of the other forms these and those of every unknown
BAND, SPARSE, CONDENSED = (43.0, 8e-3), (0.0, 4380.0), (8e6, 7500.0)


def widest_band(n: int, mixed: bool) -> float:
    """Diagonals, with those of exchanges, from which band storage of n unknowns takes longer than the other form."""
    least, each = CONDENSED if mixed else SPARSE
    linear, square = BAND
    return (sqrt(linear**2 + 4.0 * square * (least / max(n, 1) + each)) - linear) / (2.0 * square)


def assemble(
    n: int, rows: NDArray[np.int64], columns: NDArray[np.int64], kind: str | None = None, nf: int | None = None
) -> LinearSystem:
    """System of n unknowns with this pattern. `kind` 'dense', 'banded', 'sparse' or 'condensed' forces the storage.

    nf   the matrix has the mixed form of `spacar.linear_systems.condensed`, and so many unknowns x
    """
    if kind == "dense" or (kind is None and n <= DENSE_LIMIT):
        return DenseSystem(n, rows, columns)
    from spacar.linear_systems.banded import BandedSystem
    from spacar.linear_systems.sparse import SparseSystem

    if kind in (None, "banded"):
        banded = BandedSystem(n, rows, columns)
        if kind == "banded" or banded.height < widest_band(n, nf is not None):
            return banded
    if kind == "sparse" or nf is None:
        return SparseSystem(n, rows, columns)
    from spacar.linear_systems.condensed import CondensedSystem

    return CondensedSystem(n, rows, columns, nf)
