"""Orderings that make the matrices of chains narrow: reverse Cuthill-McKee on the bipartite pattern.

Rows and columns of a square, possibly unsymmetric matrix A are the two node sets of the graph of [0 A; A^T 0]; its
reverse Cuthill-McKee order gives one order of the rows and one of the columns, so that A becomes banded. A matrix
with a symmetric pattern and a zero-free diagonal is ordered symmetrically by its own graph.
"""

from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from spacar.arrays import Index


def order(n: int, rows: Index, columns: Index) -> tuple[Index, Index]:
    """Rank (new position) of every row and of every column, each (n,)."""
    row, column = _distinct(n, rows, columns)
    if np.array_equal(np.sort(column * n + row), row * n + column):
        rank = _rank(_permutation(n, row, column))
        return rank, rank
    both = _distinct(2 * n, np.concatenate((row, column + n)), np.concatenate((column + n, row)))
    permutation = _permutation(2 * n, *both)
    return _rank(permutation[permutation < n]), _rank(permutation[permutation >= n] - n)


def _distinct(n: int, rows: Index, columns: Index) -> tuple[Index, Index]:
    """Every place once, in the order of rows, then columns. Small integers, as these are sorted in half of the time."""
    small: Any = np.int32 if n * n < 2**31 else np.int64
    places = np.sort(rows.astype(small, copy=False) * small(n) + columns.astype(small, copy=False))
    if len(places):
        places = places[np.concatenate(([True], places[1:] != places[:-1]))]
    row = places // small(n)
    return row, places - row * small(n)


def _permutation(n: int, row: Index, column: Index) -> Index:
    """The reverse Cuthill-McKee order of a symmetric pattern, by rows.

    The arrays of compressed rows are made here, as SciPy takes several times as long.
    """
    start = np.zeros(n + 1, np.int32)
    np.cumsum(np.bincount(row, minlength=n), out=start[1:])
    pattern = csr_matrix((np.ones(len(row)), column.astype(np.int32, copy=False), start), (n, n))
    return np.asarray(reverse_cuthill_mckee(pattern, symmetric_mode=True))


def bandwidths(rows: Index, columns: Index) -> tuple[int, int]:
    """Number of diagonals below and above the main one."""
    offset = rows - columns
    return int(max(offset.max(), 0)), int(max(-offset.min(), 0))


def _rank(permutation: Index) -> Index:
    rank = np.empty(len(permutation), np.int64)
    rank[permutation] = np.arange(len(permutation))
    return rank
