"""The dominant invariant subspace of a linear operator by orthogonal (block power) iteration.

X <- qr(op(X)), Ritz values from X^T op(X). A block finds repeated eigenvalues, which a single Krylov vector may miss;
the block has more columns than are wanted, so that the last wanted value theta_k converges with |theta_p / theta_k|
per step.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array

Complex = NDArray[np.complex128]
Operator = Callable[[Array], Array]
CONVERGED = 1e-10  # |op(v) - theta v| / |theta| of the wanted Ritz vectors v of norm 1
SUFFICIENT = 1e-8  # accepted when it does not get better
NOTHING = 1e-13  # theta below this fraction of the largest is zero
MAX_ITERATIONS = 100
PATIENCE = 8  # iterations without improvement
SPARE = 28  # additional columns
TRIALS = 12  # shifts that are tried, until one is right within a factor of ten


def dominant(operator: Operator, start: Array, wanted: int) -> tuple[Complex, Complex]:
    """The `wanted` eigenvalues theta of largest modulus and their vectors (n, wanted) of norm 1; start (n, p).

    After MAX_ITERATIONS the last ones are returned; who uses them checks them, and says which are doubtful.
    """
    X = np.linalg.qr(operator(start))[0]
    best, since = np.inf, 0
    for _ in range(MAX_ITERATIONS):
        Y = operator(X)
        theta, c = np.linalg.eig(X.T @ Y)
        chosen = np.lexsort((-theta.imag, -np.abs(theta)))[:wanted]
        theta, c = theta[chosen], c[:, chosen]
        error = np.linalg.norm(Y @ c - X @ (c * theta), axis=0)
        size = np.maximum(np.abs(theta), NOTHING * np.abs(theta[0]))
        residual = float(np.max(error / np.where(size > 0.0, size, 1.0)))
        since = 0 if residual < 0.5 * best else since + 1
        best = min(best, residual)
        if residual <= CONVERGED or (since >= PATIENCE and residual <= SUFFICIENT):
            return theta, X @ c  # not Y c: another step would amplify what is left of larger theta
        V, X = X, np.linalg.qr(Y)[0]
    return theta, V @ c


def trial(operator: Operator, start: Array) -> tuple[Complex, Array]:
    """Ritz values (p,) after two steps from the block start (n, p), the size of the spectrum for the choice of a shift,
    and the block after the third."""
    X = np.linalg.qr(operator(operator(start)))[0]
    Y = operator(X)
    return np.linalg.eigvals(X.T @ Y).astype(complex), Y


def ends_with_half_a_pair(theta: Complex) -> bool:
    """Would the conjugate of the last value of `dominant` be the next one?"""
    return bool(theta[-1].imag) and not np.any(np.isclose(theta[:-1], theta[-1].conj(), rtol=SUFFICIENT))


def real_vectors(theta: Complex, vectors: Complex) -> Array:
    """Real vectors of an operator with real eigenvalues: the two of a repeated value may come as a complex pair."""
    out = vectors.real.copy()
    second = np.flatnonzero(theta.imag < 0.0)
    out[:, second] = vectors[:, second].imag
    return out / np.linalg.norm(out, axis=0)
