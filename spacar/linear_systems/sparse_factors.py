"""Factors of a large matrix without structure: short equations are substituted, the rest has a symmetric ordering.

A is scaled to entries of at most one (D. Ruiz, Rutherford Appleton Laboratory, RAL-TR-2001-034). Equations of one or
two terms, a y_i + c y_j = b, such as those of rates in linearized equations, are edges of a graph of the unknowns and
zero. In a forest of shortest paths every unknown follows from the one before it, y = S (B b + E z), z the roots.
What is left, A S E z = b - A S B b in the other rows, gets a diagonal without zeros (a matching) and is
factored in minimum degree order of its pattern plus its transpose, with rows exchanged where the diagonal is below
PIVOT of its column. Refinement gives the digits back (`refined`); where it does not, every pivot is the largest of its
column, in an order for such exchanges.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csc_matrix, csr_array, csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra, maximum_flow
from scipy.sparse.linalg import splu

from spacar.arrays import EPS, Array, Index
from spacar.linear_systems.linear_system import compressed, rows_of

EQUILIBRATIONS = 5  # passes
ALIKE = 0.01  # of the terms of an equation that is substituted, both scaled
DEPTH = 8  # unknowns that follow from one another
PIVOT = 1e-5
SYMMETRIC = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": PIVOT, "options": {"SymmetricMode": True}}
SAFE: dict[str, Any] = {}  # COLAMD and the largest pivot of every column
REFINEMENTS = 10
ROUNDING = 4.0 * EPS  # componentwise backward error of a solution that is as good as it can be
SUFFICIENT = 1e-10  # of one that does not get better


def refined(direct: Callable[[Array], Array], A: Any, sizes: Any, b: Array) -> tuple[Array, float]:
    """Solution of A z = b, refined until its residual is rounding (N. J. Higham, Accuracy and Stability of Numerical
    Algorithms, SIAM 2002, section 12.2), and its componentwise backward error; inf where b is finite and it is not.

    direct   approximate solution of a right-hand side;  sizes  |A|
    """
    z, error, before, idle = direct(b), np.inf, np.inf, 0
    best = z
    for _ in range(REFINEMENTS):
        rest = b - A @ z
        bound = sizes @ np.abs(z) + np.abs(b)
        if not np.isfinite(bound).all():
            return best, before if np.isfinite(b).all() else 0.0
        bound = np.maximum(bound, EPS * bound.max(axis=0))
        error = float(np.max(np.abs(rest) / np.where(bound > 0.0, bound, 1.0), initial=0.0))
        if error < before:
            best = z
        idle = 0 if error < 0.5 * before else idle + 1
        before = min(error, before)
        if error <= ROUNDING or idle > 1 or (idle and error <= SUFFICIENT):
            break
        z = z + direct(rest)
    return best, before


class SparseFactors:
    """Of A (n, n), real or complex, in any sparse format. Raises RuntimeError when A is singular."""

    def __init__(self, A: Any) -> None:
        A = csr_array(A)
        A.sum_duplicates()
        A.eliminate_zeros()
        n = A.shape[0]
        row_scale, column_scale = _equilibration(A)
        self._row_scale, self._column_scale = row_scale[:, None], column_scale[:, None]
        self._A = A = csr_array(diagonal(row_scale) @ A @ diagonal(column_scale))
        self._sizes = abs(A)
        rows, child, parent, pivot, other = _substitutions(A)
        follows = np.flatnonzero(parent < n)
        power = compressed(child[follows], parent[follows], -(other / pivot)[follows], A.shape)
        S = diagonal(np.ones(n)) + power
        power = power @ power
        while power.nnz:
            S = S + power @ S
            power = power @ power
        self._SB = S @ compressed(child, rows, 1.0 / pivot, A.shape)
        roots, kept = (np.setdiff1d(np.arange(n), found) for found in (child, rows))
        T, rest = csr_array(S[:, roots]), A[kept]
        R = csr_array(rest @ T)
        R.eliminate_zeros()
        row_scale, column_scale = _equilibration(R)
        order = _diagonal(R, kept, roots)
        left = diagonal(row_scale)
        self._kept, self._rest = kept[order], (left @ rest)[order]
        self._left, self._T = row_scale[order, None], T @ diagonal(column_scale)
        self._R = csc_matrix((left @ R @ diagonal(column_scale))[order])
        self._factor(SYMMETRIC)

    def solve(self, b: Array) -> Array:
        """y (n, k) of A y = b, nan where A turns out to be singular."""
        right = self._row_scale * b
        y, error = refined(self._direct, self._A, self._sizes, right)
        if error > SUFFICIENT and self._form is SYMMETRIC:
            try:
                self._factor(SAFE)
            except RuntimeError:
                return np.full_like(y, np.nan)
            y, _ = refined(self._direct, self._A, self._sizes, right)
        return np.asarray(self._column_scale * y)

    def _factor(self, form: dict[str, Any]) -> None:
        self._form = form
        self._lu = splu(narrow(csc_matrix, self._R), **form)

    def _direct(self, b: Array) -> Array:
        y = self._SB @ b
        return np.asarray(y + self._T @ self._lu.solve(self._left * b[self._kept] - self._rest @ y))


def diagonal(values: Array) -> Any:
    """The diagonal matrix (n, n), which SciPy 1.11 makes of another kind."""
    n = len(values)
    return csr_array((values, np.arange(n), np.arange(n + 1)), (n, n))


def narrow(kind: type, A: Any) -> Any:
    """A as csr_matrix or csc_matrix with indices of 32 bits: old versions of SciPy (1.11) factor matrices with such
    indices only, and ask for them in graphs."""
    return kind((A.data, A.indices.astype(np.int32), A.indptr.astype(np.int32)), A.shape)


def _graph(values: Array, tail: Index, head: Index, n: int) -> Any:
    return narrow(csr_matrix, compressed(tail, head, values, (n, n)))


def _diagonal(R: Any, rows: Index, columns: Index) -> Index:
    """The rows of R (m, m) in an order that leaves no zero on the diagonal: as many as possible stay where their number
    in `rows` is that of the column in `columns`. Raises RuntimeError where there is none."""
    m = R.shape[0]
    row = rows_of(R)
    own = rows[row] == columns[R.indices]
    order = np.full(m, -1)
    order[R.indices[own]] = row[own]
    while True:
        free, open_ = np.setdiff1d(np.arange(m), order), np.flatnonzero(order < 0)
        i, j = _matched(R[free][:, open_])
        if len(i) == len(free):
            order[open_[j]] = free[i]
            return order
        if len(free) == m:
            raise RuntimeError("Factor is structurally singular")
        met = np.unique(R[free].indices)
        order[met if (order[met] >= 0).any() and 2 * len(free) < m else slice(None)] = -1


def _matched(R: Any) -> tuple[Index, Index]:
    """Rows and columns of as many entries of R (m, m) as possible, one a row and one a column: a flow of ones from a
    source to the rows, along entries to columns, and to a sink. (maximum_bipartite_matching of SciPy may take ages.)"""
    m = R.shape[0]
    every = np.arange(m)
    tail = np.concatenate((np.full(m, 2 * m), rows_of(R), m + every))
    head = np.concatenate((every, m + R.indices, np.full(m, 2 * m + 1)))
    graph = _graph(np.ones(len(tail), np.int32), tail, head, 2 * m + 2)
    found = coo_array(maximum_flow(graph, 2 * m, 2 * m + 1).flow)
    taken = (found.data > 0) & (found.row < m)
    return found.row[taken], found.col[taken] - m


def _equilibration(A: Any) -> tuple[Array, Array]:
    """Factors of rows and columns, powers of two, so that what cancels still does."""
    n = A.shape[0]
    row, size = rows_of(A), np.abs(A.data)
    factors = np.ones(n), np.ones(n)
    for _ in range(EQUILIBRATIONS):
        now = size * factors[0][row] * factors[1][A.indices]
        for factor, places in zip(factors, (row, A.indices), strict=True):
            largest = np.zeros(n)
            np.maximum.at(largest, places, now)
            factor /= np.exp2(np.rint(0.5 * np.log2(np.where(largest > 0.0, largest, 1.0))))
    return factors


def _substitutions(A: Any) -> tuple[Index, Index, Index, Array, Array]:
    """Rows, the unknown that each of them gives, the one from which it follows (n: none); their two terms."""
    n, width = A.shape[0], np.diff(A.indptr)
    row = np.flatnonzero((width == 1) | (width == 2))
    a, last = A.indptr[row], A.indptr[row + 1] - 1
    i, j = A.indices[a].astype(np.int64), np.where(last > a, A.indices[last], n).astype(np.int64)
    terms = A.data[a], A.data[last]
    key = np.minimum(i, j) * (n + 1) + np.maximum(i, j)
    alike = np.flatnonzero(np.minimum(*map(np.abs, terms)) >= ALIKE)
    key, first = np.unique(key[alike], return_index=True)
    edge = alike[first]
    row, i, j, left, right = row[edge], i[edge], j[edge], terms[0][edge], terms[1][edge]

    def graph(more: Index) -> Any:
        tail, head = np.concatenate((i, np.full(len(more), n))), np.concatenate((j, more))
        return _graph(np.ones(len(tail)), tail, head, n + 1)

    label = connected_components(graph(np.zeros(0, np.int64)), directed=False)[1]
    short = np.zeros(n + 1)
    short[row] = 1.0
    order = np.argsort(short, kind="stable")
    begin = order[np.unique(label[order], return_index=True)[1]]
    begin = begin[label[begin] != label[n]]
    distance, before = dijkstra(graph(begin), directed=False, indices=n, unweighted=True, return_predecessors=True)
    child = np.flatnonzero(distance[:n] % DEPTH)
    parent = before[child].astype(np.int64)
    wanted = np.minimum(child, parent) * (n + 1) + np.maximum(child, parent)
    place = np.minimum(np.searchsorted(key, wanted), max(len(key) - 1, 0))
    there = key[place] == wanted if len(key) else np.zeros(len(child), bool)
    child, parent, place = child[there], parent[there], place[there]
    is_first = i[place] == child
    pivot, other = (np.where(is_first, x[place], y[place]) for x, y in ((left, right), (right, left)))
    return row[place], child, parent, pivot, other
