"""Dense storage for small systems. NumPy only: importing SciPy's LAPACK wrappers costs more than many small runs."""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array, Index
from spacar.linear_systems.linear_system import SingularMatrixError


class DenseSystem:
    """Assembled by one bincount; each solve factors again, which is cheaper than a wrapper for n below about 60."""

    kind = "dense"

    def __init__(self, n: int, rows: Index, columns: Index) -> None:
        self.n = n
        self.flat = rows * n + columns
        # not np.unique, which would import numpy.ma
        self.unique = not len(self.flat) or int(np.bincount(self.flat).max()) == 1
        self.A = np.zeros((n, n))
        self._ravel = self.A.reshape(-1)

    def factor(self, entries: Array) -> None:
        if self.unique:
            self._ravel[self.flat] = entries
        else:
            self._ravel[:] = np.bincount(self.flat, entries, self.n * self.n)

    def solve(self, b: Array) -> Array:
        return self._solve(self.A, b)

    def solve_transposed(self, b: Array) -> Array:
        return self._solve(self.A.T, b)

    def negative(self) -> None:
        return None

    def determinant_sign(self) -> float:
        return float(np.linalg.slogdet(self.A)[0])

    def _solve(self, A: Array, b: Array) -> Array:
        try:
            return np.linalg.solve(A, b)
        except np.linalg.LinAlgError:
            raise SingularMatrixError(f"matrix of order {self.n} is singular") from None
