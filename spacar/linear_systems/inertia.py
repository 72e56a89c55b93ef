"""Inertia of a symmetric sparse matrix: how many of its eigenvalues are negative, and how many are zero.

Sylvester: a congruence keeps the signs. In reverse Cuthill-McKee order the matrix is block tridiagonal; the blocks are
eliminated one after the other, A_k+1 - B^T S_k^-1 B, and the inertia is the sum over the Schur complements S_k. A
Schur complement may be singular although the matrix is not (a constraint that comes before its coordinates), so each
is diagonalized by an orthogonal transformation: directions with small eigenvalues are not eliminated but handed on to
the next block. Only what is left behind the last block is zero. Cost: linear in the number of unknowns.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array, Index

SINGLE = 150  # unknowns up to which one block is faster
SMALLEST_BLOCK = 48
DELAYED = 1e-4  # relative eigenvalue below which a direction waits for the next block: growth of at most 1e4 a block


def inertia(n: int, rows: Index, columns: Index, entries: Array) -> tuple[int, int]:
    """Negative and zero eigenvalues of the matrix of order n with these entries (repeated ones add up).

    It is scaled to rows of size one first; zero means below n eps then, which is what its rounding makes of zero.
    """
    if n == 0:
        return 0, 0
    size = np.zeros(n)
    np.maximum.at(size, rows, np.abs(entries))
    d = 1.0 / np.sqrt(np.where(size > 0.0, size, 1.0))
    values = entries * d[rows] * d[columns]
    zero = n * float(np.finfo(float).eps)
    if n <= SINGLE:
        A = np.bincount(rows * n + columns, values, n * n).reshape(n, n)
        spectrum = np.linalg.eigvalsh((A + A.T) / 2.0)
        return int(np.sum(spectrum < -zero)), int(np.sum(np.abs(spectrum) <= zero))
    return _by_blocks(n, rows, columns, values, zero)


def _by_blocks(n: int, rows: Index, columns: Index, values: Array, zero: float) -> tuple[int, int]:
    from scipy.sparse import coo_matrix

    from spacar.linear_systems.ordering import bandwidths, order

    rank, _ = order(n, rows, columns)
    i, j = rank[rows], rank[columns]
    width = max(SMALLEST_BLOCK, *bandwidths(i, j))
    A = coo_matrix((values, (i, j)), (n, n)).tocsr()
    A = (A + A.T).tocsr() / 2.0
    negative = 0
    waiting, waiting_coupling = np.zeros(0), np.zeros((0, min(width, n)))
    update = np.zeros((min(width, n), min(width, n)))
    for a in range(0, n, width):
        b, c = min(a + width, n), min(a + 2 * width, n)
        band = A[a:b, a:c].toarray()
        w, m = len(waiting), b - a
        S = np.empty((w + m, w + m))
        S[:w, :w] = np.diag(waiting)
        S[:w, w:], S[w:, :w] = waiting_coupling, waiting_coupling.T
        S[w:, w:] = band[:, :m] - update
        spectrum, Q = np.linalg.eigh(S)
        coupling = Q[w:].T @ band[:, m:]
        taken = np.abs(spectrum) > (DELAYED * np.max(np.abs(spectrum)) if c > b else zero)
        negative += int(np.sum(spectrum[taken] < 0.0))
        B = coupling[taken]
        update = B.T @ (B / spectrum[taken, None])
        waiting, waiting_coupling = spectrum[~taken], coupling[~taken]
    return negative, len(waiting)
