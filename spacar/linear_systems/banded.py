"""Band storage, LAPACK gbtrf/gbtrs: linear cost for chains."""

from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg.lapack import dgbtrf, dgbtrs

from spacar.arrays import Array, Index
from spacar.linear_systems.linear_system import LinearSystem, SingularMatrixError, compressed, parity
from spacar.linear_systems.ordering import bandwidths, order


class BandedSystem(LinearSystem):
    """Entry (i, j) in ranked order sits in row lower + upper + i - j, column j of the band array."""

    kind = "banded"

    def __init__(self, n: int, rows: Index, columns: Index) -> None:
        self.n, self.rows, self.columns, self.entries = n, rows, columns, np.zeros(0)
        self._A: Any = None  # of the last entries, when it is asked for
        self.row_rank, self.column_rank = order(n, rows, columns)
        self.lower, self.upper = bandwidths(self.row_rank[rows], self.column_rank[columns])
        self.height = 2 * self.lower + self.upper + 1

    # What only a system that is factored needs: `assemble` looks at the height of others.
    @cached_property
    def flat(self) -> Index:
        """Places of the entries in the Fortran order of the (height, n) band array."""
        j = self.column_rank[self.columns]
        return j * self.height + (self.lower + self.upper + self.row_rank[self.rows] - j)

    @cached_property
    def row_order(self) -> Index:
        return np.argsort(self.row_rank)

    @cached_property
    def column_order(self) -> Index:
        return np.argsort(self.column_rank)

    @cached_property
    def _parity(self) -> float:
        return parity(self.row_rank) * parity(self.column_rank)

    def factor(self, entries: Array) -> None:
        self.entries, self._A = entries, None
        band = np.bincount(self.flat, entries, self.height * self.n).reshape(self.n, self.height).T
        self.lu, self.pivots, info = dgbtrf(band, self.lower, self.upper, overwrite_ab=True)
        if info != 0:
            at = int(self.column_order[info - 1]) if info > 0 else None
            raise SingularMatrixError(f"matrix of order {self.n} is singular at unknown {at}", at)

    def solve(self, b: Array) -> Array:
        x, _ = dgbtrs(self.lu, self.lower, self.upper, b[self.row_order], self.pivots)
        return x[self.column_rank]

    def refined(self, b: Array) -> Array:
        """`solve` with one step of refinement, b (n, k): errors of the factors, which grow with the square of the
        number of beams in a chain, become rounding of the entries (N. J. Higham, Accuracy and Stability of Numerical
        Algorithms, SIAM 2002, theorem 12.3)."""
        if self._A is None:
            self._A = compressed(self.rows, self.columns, self.entries, (self.n, self.n))
        z = self.solve(b)
        return np.asarray(z + self.solve(b - self._A @ z))

    @property
    def storage(self) -> str:
        return f"band of {self.height} diagonals"

    def solve_transposed(self, b: Array) -> Array:
        x, _ = dgbtrs(self.lu, self.lower, self.upper, b[self.column_order], self.pivots, trans=1)
        return x[self.row_rank]

    def determinant_sign(self) -> float:
        swaps = int(np.sum(self.pivots != np.arange(self.n)))
        negative = int(np.sum(self.lu[self.lower + self.upper] < 0.0))
        return -self._parity if (swaps + negative) % 2 else self._parity
