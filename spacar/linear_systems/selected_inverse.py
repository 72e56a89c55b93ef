"""Entries of the inverse of a banded matrix near its diagonal, at linear cost.

LAPACK's gbtrf writes the matrix as P_1 L_1 P_2 L_2 ... U, one exchange of rows and one column of multipliers l a step.
Let Z be the inverse of the matrix that is left after step j, u the row of U beyond its diagonal d. Then

    [ d  u ]                     [ (1 + u Z l)/d   -u Z/d ]
    inverse before step j   =    [ -Z l             Z     ]  P_j

where P_j exchanges two columns (N. J. Higham, Accuracy and Stability of Numerical Algorithms, SIAM 2002, section 14.3:
the recursion of an inverse from its factors). It needs entries of Z in a window of lower + upper + lower rows and
columns only, since l has `lower` and u `lower + upper` entries, and exchanges stay inside. K. Takahashi, J. Fagan and
M.-S. Chin (1973) use the same for sparse symmetric matrices, see A. M. Erisman, W. F. Tinney, Comm. ACM 18 (1975)
177-179.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.linear_systems.banded import BandedSystem


def inverse_diagonal(system: BandedSystem) -> Array:
    """(n,) of the inverse of the factored matrix: the row of an unknown and the column of the equation of equal number.

    Raises ValueError when rows and columns are not in the same order, as they are with a symmetric pattern.
    """
    if not np.array_equal(system.row_rank, system.column_rank):
        raise ValueError("rows and columns are not in the same order")
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
    return diagonal[system.row_rank]
