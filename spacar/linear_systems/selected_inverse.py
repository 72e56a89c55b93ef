"""Entries of the inverse of a matrix where its factors may have entries.

Banded, near its diagonal, at linear cost: LAPACK's gbtrf writes the matrix as P_1 L_1 P_2 L_2 ... U, one exchange of
rows and one column of multipliers l a step. Let Z be the inverse of the matrix that is left after step j, u the row of
U beyond its diagonal d. Then

    [ d  u ]                     [ (1 + u Z l)/d   -u Z/d ]
    inverse before step j   =    [ -Z l             Z     ]  P_j

where P_j exchanges two columns (N. J. Higham, Accuracy and Stability of Numerical Algorithms, SIAM 2002, section 14.3:
the recursion of an inverse from its factors). It needs entries of Z in a window of lower + upper + lower rows and
columns only, since l has `lower` and u `lower + upper` entries, and exchanges stay inside. K. Takahashi, J. Fagan and
M.-S. Chin (1973) use the same for sparse symmetric matrices, see A. M. Erisman, W. F. Tinney, Comm. ACM 18 (1975)
177-179: with L D L^T = A, Z = A^-1, a supernode J (columns of L with the same rows I below them) and Y = L_IJ L_JJ^-1

    Z_IJ = -Z_II Y,      Z_JJ = L_JJ^-T D_J^-1 L_JJ^-1 - Y^T Z_IJ

from the last supernode to the first: the rows and columns I of Z are there by then, since the pattern of the factors is
closed. It costs about as much as the factorization.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.sparse import coo_array

from spacar.arrays import Array, Index
from spacar.linear_systems.banded import BandedSystem
from spacar.linear_systems.linear_system import rows_of


def inverse_diagonal(system: BandedSystem, by: Callable[[BandedSystem], Array] | None = None) -> Array:
    """(n,) of the inverse of the factored matrix, whose rows and columns are in the same order, as they are with a
    symmetric pattern.

    by   what finds it in the order of the band, in the place of the loop below (the same in C)
    """
    return (by or _by_window)(system)[system.row_rank]


def _by_window(system: BandedSystem) -> Array:
    n, lower, top = system.n, system.lower, system.lower + system.upper
    lu, pivots = np.ascontiguousarray(system.lu.T), system.pivots  # column j of the band as row j
    width = min(top + lower, n - 1)
    size = 8 * max(width, 1)  # the window moves up in a larger array, which is shifted when it arrives at its edge
    store = np.zeros((size, size))
    at = size  # place of row and column j + 1 of the matrix
    diagonal = np.zeros(n)
    # U by rows: U[j, j + k] sits in row top - k of column j + k
    upper = np.zeros((n, top))
    for k in range(1, min(top, n - 1) + 1):
        upper[: n - k, k - 1] = lu[k:, top - k]
    for j in range(n - 1, -1, -1):
        rest = min(width, n - 1 - j)
        if at == 0:
            store[size - width :, size - width :] = store[:width, :width]
            at = size - width
        Z = store[at : at + rest, at : at + rest]
        below, beside = min(lower, n - 1 - j), min(top, n - 1 - j)
        factors, row, d = lu[j, top + 1 : top + 1 + below], upper[j, :beside], lu[j, top]
        column = -(Z[:, :below] @ factors)
        line = -(row @ Z[:beside]) / d
        at -= 1
        store[at, at] = (1.0 - row @ column[:beside]) / d
        store[at + 1 : at + 1 + rest, at] = column
        store[at, at + 1 : at + 1 + rest] = line
        exchange = int(pivots[j]) - j
        if exchange:
            part = store[at : at + 1 + rest]
            part[:, [at, at + exchange]] = part[:, [at + exchange, at]]
        leaves = j + width
        if leaves < n:  # no exchange reaches it any more
            diagonal[leaves] = store[at + width, at + width]
    for i in range(min(width, n)):
        diagonal[i] = store[at + i, at + i]
    return diagonal


def selected_inverse(L: Any, d: Array, rows: Index, columns: Index) -> Array:
    """Z at (rows, columns), places of A or of its factors: L (n, n) in compressed columns with a unit diagonal, d (n,).

    The pattern of A must be that of L or lie in (rows, columns), and repeated places do no harm.
    """
    n = len(d)
    low, high = np.maximum(rows, columns), np.minimum(rows, columns)
    structure = _structure(n, L, low, high)
    first, below = _supernodes(structure)
    owner = np.repeat(np.arange(len(below)), np.diff(first))
    order = np.argsort(high, kind="stable")
    asked = np.searchsorted(high[order], first)
    found, place = np.zeros(len(rows)), np.zeros(n, np.int64)
    panels: list[Array] = [np.zeros(0)] * len(below)
    for s in range(len(below) - 1, -1, -1):
        a, b, I = first[s], first[s + 1], below[s]
        w = b - a
        place[a:b], place[I] = np.arange(w), w + np.arange(len(I))
        panel = np.zeros((w + len(I), w))
        part = slice(L.indptr[a], L.indptr[b])
        panel[place[L.indices[part]], np.repeat(np.arange(w), np.diff(L.indptr[a : b + 1]))] = L.data[part]
        inverse = np.linalg.inv(panel[:w])
        Y = panel[w:] @ inverse
        panel[w:] = -_gathered(I, owner, first, below, panels) @ Y
        panel[:w] = (inverse.T / d[a:b]) @ inverse - Y.T @ panel[w:]
        panels[s] = panel
        pairs = order[asked[s] : asked[s + 1]]
        found[pairs] = panel[place[low[pairs]], high[pairs] - a]
    return found


def _structure(n: int, L: Any, low: Index, high: Index) -> list[Index]:
    """Rows below the diagonal of every column of the factors: those of the matrix and, of each child in the elimination
    tree (whose first row is the column), the others. L may lack entries that happen to be zero."""
    row = np.concatenate((L.indices, low))
    column = np.concatenate((rows_of(L), high))
    off = row > column
    pattern = coo_array((np.ones(np.count_nonzero(off), np.int8), (row[off], column[off])), (n, n)).tocsc()
    row, ends = pattern.indices, pattern.indptr  # every place once, in order
    children: list[list[int]] = [[] for _ in range(n)]
    structure: list[Index] = []
    mark = np.full(n, -1)
    for j in range(n):
        rows = row[ends[j] : ends[j + 1]]
        for child in children[j]:
            others = structure[child][1:]
            mark[others] = j
            more = rows[mark[rows] != j]
            mark[others] = -1
            rows = np.sort(np.concatenate((others, more))) if len(more) else others
        structure.append(rows)
        if len(rows):
            children[rows[0]].append(j)
    return structure


def _supernodes(structure: list[Index]) -> tuple[Index, list[Index]]:
    """The first column of every supernode, and behind the last; the rows below each."""
    n = len(structure)
    size = np.array([len(rows) for rows in structure] or [0])
    parent = np.array([rows[0] if len(rows) else -1 for rows in structure] or [0])
    joined = (parent[:-1] == np.arange(1, n)) & (size[:-1] == size[1:] + 1) if n else np.zeros(0, bool)
    first = np.concatenate(([0], 1 + np.flatnonzero(~joined), [n])) if n else np.zeros(1, np.int64)
    return first, [structure[b - 1] for b in first[1:]]


def _gathered(I: Index, owner: Index, first: Index, below: list[Index], panels: list[Array]) -> Array:
    """Z_II from the panels of the supernodes that own the columns I."""
    Z = np.empty((len(I), len(I)))
    owners = owner[I]
    starts = np.concatenate(([0], 1 + np.flatnonzero(np.diff(owners)), [len(I)])) if len(I) else [0]
    for a, b in pairwise(starts):
        s = owners[a]
        w = first[s + 1] - first[s]
        own, rest = I[a:b] - first[s], w + np.searchsorted(below[s], I[b:])
        block = panels[s][np.concatenate((own, rest))[:, None], own]
        Z[a:, a:b] = block
        Z[a:b, b:] = block[b - a :].T
    return Z
