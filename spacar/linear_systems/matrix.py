"""Matrices that are only multiplied: sums of entries (row, column, value), dense when small, else compressed rows.

Both kinds understand `A @ B`, `A.T @ B` and `B @ A` with a dense B, `A + A` and `c * A`; a sum or a product with a
dense array is dense. SciPy is imported only where a matrix is large.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from spacar.arrays import Array, Index

DENSE_LIMIT = 150  # rows or columns up to which all products of a linearization are faster dense (docs/performance.md)

Matrix = Any  # NumPy array or csr_array of SciPy


def matrix(rows: Index, columns: Index, values: Array, shape: tuple[int, int]) -> Matrix:
    """(shape) with the sum of the values at every place."""
    if not values.any():
        return zero_matrix(shape)
    if max(shape) <= DENSE_LIMIT:
        return np.bincount(rows * shape[1] + columns, values, shape[0] * shape[1]).reshape(shape)
    from scipy.sparse import coo_array

    return coo_array((values, (rows, columns)), shape).tocsr()


def zero_matrix(shape: tuple[int, int]) -> Matrix:
    """All entries zero."""
    if max(shape) <= DENSE_LIMIT:
        return np.zeros(shape)
    from scipy.sparse import csr_array

    return csr_array(shape)


def diagonal_matrix(values: Array) -> Matrix:
    """(n, n) with these values on the diagonal."""
    places = np.arange(len(values))
    return matrix(places, places, values, (len(values), len(values)))


def is_zero_matrix(A: Matrix) -> bool:
    """Are all stored entries zero?"""
    return not (A if isinstance(A, np.ndarray) else A.data).any()


def dense(A: Matrix) -> Array:
    return A if isinstance(A, np.ndarray) else A.toarray()
