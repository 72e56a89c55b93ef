"""Orderings that make the matrices of chains narrow: reverse Cuthill-McKee on the bipartite pattern.

Rows and columns of a square, possibly unsymmetric matrix A are the two node sets of the graph of [0 A; A^T 0]; its
reverse Cuthill-McKee order gives one order of the rows and one of the columns, so that A becomes banded. A matrix
with a symmetric pattern and a zero-free diagonal is ordered symmetrically by its own graph.
"""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from spacar.arrays import Index


def order(n: int, rows: Index, columns: Index) -> tuple[Index, Index]:
    """Rank (new position) of every row and of every column, each (n,)."""
    A = csr_matrix((np.ones(len(rows)), (rows, columns)), (n, n))
    turned = A.T.tocsr()
    if np.array_equal(turned.indptr, A.indptr) and np.array_equal(turned.indices, A.indices):
        rank = _rank(reverse_cuthill_mckee(A, symmetric_mode=True))
        return rank, rank
    indices, starts = np.concatenate((A.indices + n, turned.indices)), np.append(A.indptr, A.nnz + turned.indptr[1:])
    both = csr_matrix((np.ones(len(indices)), indices, starts), (2 * n, 2 * n))
    permutation = reverse_cuthill_mckee(both, symmetric_mode=True)
    return _rank(permutation[permutation < n]), _rank(permutation[permutation >= n] - n)


def bandwidths(rows: Index, columns: Index) -> tuple[int, int]:
    """Number of diagonals below and above the main one."""
    offset = rows - columns
    return int(max(offset.max(), 0)), int(max(-offset.min(), 0))


def _rank(permutation: Index) -> Index:
    return np.argsort(permutation)
