"""Null space of a large sparse matrix and its singular values at the lower end, at the cost of a few factorizations.

For A (m, n) with largest singular value s_1 the block iteration X <- (A^T A + mu)^-1 X, mu = eps s_1^2, magnifies a
direction with A x = 0 by 1/(eps s_1^2) and one with the singular value s by 1/(s^2 + mu). The solution comes from

    [ -1   A  ] [ y ]   [ 0 ]
    [ A^T  mu ] [ x ] = [ b ]

whose rounding is eps |A|, not eps |A|^2 as that of A^T A. The singular values of A X are then known to eps s_1, so that
those below sqrt(eps) s_1 are told from the others as in a full decomposition (Rayleigh-Ritz; G. H. Golub, C. F. Van
Loan, Matrix Computations, Johns Hopkins 2013, section 8.2.4). The block grows until one value is not zero.
"""

from typing import Any

import numpy as np

from spacar.arrays import EPS, Array

LARGEST_DECOMPOSED = 400  # rows or columns up to which a full singular value decomposition is cheap
BLOCK = 8  # vectors in the block beyond the least dimension of the null space
ITERATIONS = 6
PROJECTIONS = 4
NORM_ITERATIONS = 30  # the norm is then known to some percent
SHARE = 0.5  # of all columns: with more vectors than that in the block a full decomposition is cheaper


def norm_estimate(A: Any) -> float:
    """The largest singular value of A (m, n), by the power method from below."""
    x = np.random.default_rng(1).standard_normal(A.shape[1])
    size = 0.0
    for _ in range(NORM_ITERATIONS):
        y = A @ (x / (np.linalg.norm(x) or 1.0))
        size = float(np.linalg.norm(y))
        x = A.T @ y
    return size


def null_space(A: Any, size: float, zero: float) -> tuple[Array, Array]:
    """Orthonormal null space (n, k) of a sparse A (m, n) of norm `size`, and the singular values beside it, ascending.

    Singular values up to `zero` x `size` count as zero, and n - m more where A has fewer rows than columns.
    """
    m, n = A.shape
    least = max(n - m, 0)
    columns = least + BLOCK
    while columns <= SHARE * n:
        values, X = _smallest(A, size, columns)
        k = int(np.sum(values <= zero * size))
        if k < columns:
            return X[:, :k], values[k:]
        columns *= 2
    _, s, right = np.linalg.svd(A.toarray(), full_matrices=True)
    rank = int(np.sum(s > zero * size))
    return np.asarray(right[rank:].T), s[:rank][::-1]


def on_null_space(A: Any, size: float, z: Array) -> Array:
    """The columns of z (n, k) projected on the null space of A (m, n): the nearest v with A v = 0."""
    m, n = A.shape
    system = _bordered(A, EPS * size**2)
    b = np.zeros((n + m, z.shape[1]))
    for _ in range(PROJECTIONS):  # one leaves mu/(s^2 + mu) of a direction with the singular value s
        b[n:] = A @ z
        z = z - A.T @ system.solve(b)[n:]
    return np.asarray(z)


def _smallest(A: Any, size: float, columns: int) -> tuple[Array, Array]:
    """The smallest singular values (columns,), ascending, and their right vectors (n, columns)."""
    m, n = A.shape
    system = _bordered(A.T.tocsr(), EPS * size**2)
    X = np.linalg.qr(np.random.default_rng(1).standard_normal((n, columns)))[0]
    b = np.zeros((m + n, columns))
    for _ in range(ITERATIONS):
        b[m:] = X
        X = np.linalg.qr(system.solve(b)[m:])[0]
    _, values, right = np.linalg.svd(np.linalg.qr(A @ X, mode="r"), full_matrices=True)
    values = np.concatenate((values, np.zeros(columns - len(values))))
    return values[::-1], (X @ right.T)[:, ::-1]


def _bordered(A: Any, mu: float) -> Any:
    """Factors of [-1, A^T; A, mu]: the last rows of its solution with (0, b) are (A A^T + mu)^-1 b."""
    from scipy.sparse import bmat, identity

    from spacar.linear_systems.sparse_factors import SparseFactors

    m, n = A.shape
    return SparseFactors(bmat([[-identity(n), A.T], [A, mu * identity(m)]], format="csc"))
