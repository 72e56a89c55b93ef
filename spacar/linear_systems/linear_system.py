"""The contract of a linear system, dense storage for small ones, and matrices that are only multiplied.

NumPy only: importing SciPy costs more than many small runs. A `Matrix` is a sum of entries (row, column, value), dense
when small, else compressed rows; both understand `A @ B`, `A.T @ B` and `B @ A` with a dense B, `A + A` and `c * A`; a
sum or a product with a dense array is dense.
"""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from spacar.arrays import Array, Index


class SingularMatrixError(ArithmeticError):
    """The matrix cannot be factored; `position` is the unknown (original numbering) where it broke down, if known."""

    def __init__(self, text: str, position: int | None = None) -> None:
        super().__init__(text)
        self.position = position


class LinearSystem(Protocol):
    """Factor once, solve often. All arrays are in the caller's numbering, whatever the storage does inside.

    What one kind of storage knows alone has a body here for the others.
    """

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

    def refined(self, b: Array) -> Array:
        """`solve` to all digits that the entries give; b is (n, k)."""
        return self.solve(b)

    def displacement(self, force: Array, refined: bool = False) -> Array:
        """The first unknowns for b = (force, 0), as many as force (nf,) or (nf, k) has."""
        b = np.zeros((self.n, *force.shape[1:]))
        b[: len(force)] = force
        return (self.refined if refined else self.solve)(b)[: len(force)]

    def forget(self) -> None:
        """What depends on the entries, where it is large."""
        return

    def inverse_diagonal(self) -> Array | None:
        """The part of the first unknowns, None where it takes solutions of all columns."""
        return None

    def negative(self) -> int | None:
        """Negative eigenvalues of the symmetric matrix, of which none is zero; None where the factors do not tell."""
        return None

    @property
    def storage(self) -> str:
        """How the matrix is stored and factored."""
        return f"{self.kind} matrix"


def parity(permutation: Index) -> float:
    """+1 for an even permutation, -1 for an odd one."""
    rest, sign = permutation.tolist(), 1.0
    for i in range(len(rest)):
        while rest[i] != i:
            j = rest[i]
            rest[i], rest[j] = rest[j], j
            sign = -sign
    return sign


class DenseSystem(LinearSystem):
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

    def solve(self, b: Array, transposed: bool = False) -> Array:
        try:
            return np.linalg.solve(self.A.T if transposed else self.A, b)
        except np.linalg.LinAlgError:
            raise SingularMatrixError(f"matrix of order {self.n} is singular") from None

    def solve_transposed(self, b: Array) -> Array:
        return self.solve(b, True)

    def determinant_sign(self) -> float:
        return float(np.linalg.slogdet(self.A)[0])


DENSE_LIMIT = 150  # rows or columns up to which all products of a linearization are faster dense (docs/performance.md)

Matrix = Any  # NumPy array or csr_array of SciPy


def matrix(rows: Index, columns: Index, values: Array, shape: tuple[int, int]) -> Matrix:
    """(shape) with the sum of the values at every place."""
    if not values.any():
        return zero_matrix(shape)
    if max(shape) <= DENSE_LIMIT:
        return np.bincount(rows * shape[1] + columns, values, shape[0] * shape[1]).reshape(shape)
    return compressed(rows, columns, values, shape)


def compressed(rows: Index, columns: Index, values: Array, shape: tuple[int, int]) -> Any:
    """The same in compressed rows, whatever the size."""
    from scipy.sparse import coo_array

    return coo_array((values, (rows, columns)), shape).tocsr()


def compressed_sum(parts: Sequence[tuple[Index, Index, Array]], shape: tuple[int, int]) -> Any:
    """The same of several parts: rows, columns, values."""
    if not parts:
        parts = [(*np.zeros((2, 0), np.int64), np.zeros(0))]
    rows, columns, values = (np.concatenate(part) for part in zip(*parts, strict=True))
    return compressed(rows, columns, values, shape)


def rows_of(A: Any) -> Index:
    """The row of every entry of A in compressed rows, the column in compressed columns."""
    return np.repeat(np.arange(len(A.indptr) - 1), np.diff(A.indptr))


def zero_matrix(shape: tuple[int, int]) -> Matrix:
    if max(shape) <= DENSE_LIMIT:
        return np.zeros(shape)
    from scipy.sparse import csr_array

    return csr_array(shape)


def diagonal_matrix(values: Array) -> Matrix:
    places = np.arange(len(values))
    return matrix(places, places, values, (len(values), len(values)))


def is_zero_matrix(A: Matrix) -> bool:
    return not (A if isinstance(A, np.ndarray) else A.data).any()


def dense(A: Matrix) -> Array:
    return A if isinstance(A, np.ndarray) else A.toarray()
