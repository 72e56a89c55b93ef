"""The contract of a linear system."""

from __future__ import annotations

from typing import Protocol

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

    def negative(self) -> int | None:
        """Negative eigenvalues of the symmetric matrix, of which none is zero; None where the factors do not tell."""


def parity(permutation: Index) -> float:
    """+1 for an even permutation, -1 for an odd one."""
    rest, sign = permutation.tolist(), 1.0
    for i in range(len(rest)):
        while rest[i] != i:
            j = rest[i]
            rest[i], rest[j] = rest[j], j
            sign = -sign
    return sign
