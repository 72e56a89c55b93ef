"""The dominant invariant subspace of a linear operator by orthogonal (block power) iteration.

X <- qr(op(X)), Ritz values from X^T op(X). A block finds repeated eigenvalues, which a single Krylov vector may miss; the
block has more columns than are wanted, so that the last wanted value theta_k converges with |theta_p / theta_k| per step.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spacar.errors import AnalysisError
from spacar.mechanism.mechanism import Array

Operator = Callable[[Array], Array]
CONVERGED = 1e-10  # |op(v) - theta v| / |theta| of the wanted Ritz vectors v of norm 1
SUFFICIENT = 1e-8  # accepted when it does not get better
MAX_ITERATIONS = 100
PATIENCE = 8  # iterations without improvement
SPARE = 28  # additional columns


def dominant_subspace(operator: Operator, start: Array, wanted: int) -> Array:
    """Orthonormal X (n, p) that contains the `wanted` eigenvectors of largest modulus; start (n, p).

    Raises AnalysisError 'eigen.no-convergence'.
    """
    X = np.linalg.qr(operator(start))[0]
    best, since = np.inf, 0
    for _ in range(MAX_ITERATIONS):
        Y = operator(X)
        theta, c = np.linalg.eig(X.T @ Y)
        chosen = np.argsort(-np.abs(theta), kind="stable")[:wanted]
        theta, c = theta[chosen], c[:, chosen]
        error = np.linalg.norm(Y @ c - X @ (c * theta), axis=0)
        residual = float(np.max(error / np.maximum(np.abs(theta), 1e-13 * np.abs(theta[0]))))
        if residual <= CONVERGED:
            return X
        since = 0 if residual < 0.5 * best else since + 1
        best = min(best, residual)
        if since >= PATIENCE and best <= SUFFICIENT:
            return X
        X = np.linalg.qr(Y)[0]
    raise AnalysisError(
        f"the lowest {wanted} modes did not converge in {MAX_ITERATIONS} subspace iterations (residual {best:.3g});"
        " ask for all modes with OUTLEVEL 0 1",
        "eigen.no-convergence",
    )
