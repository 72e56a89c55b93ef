"""The contract of a linear system, and dense storage for small ones.

NumPy only: importing SciPy's LAPACK wrappers costs more than many small runs.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from spacar.arrays import Array, Index


class SingularMatrixError(ArithmeticError):
    """The matrix cannot be factored; `position` is the unknown (original numbering) where it broke down, if known."""

    def __init__(self, text: str, position: int | None = None) -> None:
        super().__init__(text)
        self.position = position


class LinearSystem(Protocol):
    """Factor once, solve often. All arrays are in the caller's numbering, whatever the storage does inside."""

    n: int
    kind: str

    def factor(self, entries: Array) -> None:
        """Assemble the entries (in the order of the pattern) and factor. Raises SingularMatrixError."""

    def solve(self, b: Array) -> Array:
        """x with A x = b; b is (n,) or (n, k)."""

    def solve_transposed(self, b: Array) -> Array:
        """x with A^T x = b; b is (n,) or (n, k)."""

    def determinant_sign(self) -> float:
        """+1 or -1, of the determinant of the factored matrix in the caller's numbering."""


def parity(permutation: Index) -> float:
    """+1 for an even permutation, -1 for an odd one."""
    rest, sign = permutation.tolist(), 1.0
    for i in range(len(rest)):
        while rest[i] != i:
            j = rest[i]
            rest[i], rest[j] = rest[j], j
            sign = -sign
    return sign


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

    def determinant_sign(self) -> float:
        return float(np.linalg.slogdet(self.A)[0])

    def _solve(self, A: Array, b: Array) -> Array:
        try:
            return np.linalg.solve(A, b)
        except np.linalg.LinAlgError:
            raise SingularMatrixError(f"matrix of order {self.n} is singular") from None
