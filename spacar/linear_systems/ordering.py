"""Orderings that make the matrices of chains narrow: reverse Cuthill-McKee on the bipartite pattern.

Rows and columns of a square, possibly unsymmetric matrix A are the two node sets of the graph of [0 A; A^T 0]; its
reverse Cuthill-McKee order gives one order of the rows and one of the columns, so that A becomes banded. A matrix
with a symmetric pattern and a zero-free diagonal is ordered symmetrically by its own graph.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from spacar.arrays import Index


def order(n: int, rows: Index, columns: Index) -> tuple[Index, Index]:
    """Rank (new position) of every row and of every column, each (n,)."""
    places = _distinct(rows * n + columns)
    if np.array_equal(places, _distinct(columns * n + rows)):
        rank = _rank(_permutation(n, places))
        return rank, rank
    i, j = np.divmod(places, n)
    both = np.concatenate((i * 2 * n + j + n, (j + n) * 2 * n + i))
    permutation = _permutation(2 * n, np.sort(both))
    return _rank(permutation[permutation < n]), _rank(permutation[permutation >= n] - n)


def _distinct(places: Index) -> Index:
    """Every place once, ascending."""
    places = np.sort(places)
    return places[np.concatenate(([True], places[1:] != places[:-1]))] if len(places) else places


def _permutation(n: int, places: Index) -> Index:
    """The reverse Cuthill-McKee order of a symmetric pattern, given as row n + column ascending.

    The arrays of compressed rows are made here, as SciPy takes several times as long.
    """
    row, column = np.divmod(places, n)
    start = np.concatenate(([0], np.cumsum(np.bincount(row, minlength=n))))
    pattern = csr_matrix((np.ones(len(places)), column.astype(np.int32), start.astype(np.int32)), (n, n))
    return np.asarray(reverse_cuthill_mckee(pattern, symmetric_mode=True))


def bandwidths(rows: Index, columns: Index) -> tuple[int, int]:
    """Number of diagonals below and above the main one."""
    offset = rows - columns
    return int(max(offset.max(), 0)), int(max(-offset.min(), 0))


def _rank(permutation: Index) -> Index:
    rank = np.empty(len(permutation), np.int64)
    rank[permutation] = np.arange(len(permutation))
    return rank
