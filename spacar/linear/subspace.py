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
CONVERGED = 1e-12  # relative change of the wanted Ritz values
MAX_ITERATIONS = 200
SPARE = 28  # additional columns


def dominant_subspace(operator: Operator, start: Array, wanted: int) -> Array:
    """Orthonormal X (n, p) that contains the `wanted` eigenvectors of largest modulus; start (n, p).

    Raises AnalysisError 'eigen.no-convergence'.
    """
    X = np.linalg.qr(operator(start))[0]
    before = np.zeros(wanted)
    change = np.inf
    for _ in range(MAX_ITERATIONS):
        Y = operator(X)
        theta = -np.sort(-np.abs(np.linalg.eigvals(X.T @ Y)))[:wanted]
        X = np.linalg.qr(Y)[0]
        change = float(np.max(np.abs(theta - before) / np.maximum(theta, 1e-13 * theta[0])))
        if change <= CONVERGED:
            return X
        before = theta
    raise AnalysisError(
        f"the lowest {wanted} modes did not converge in {MAX_ITERATIONS} subspace iterations (last change {change:.3g});"
        " ask for all modes with OUTLEVEL 0 1",
        "eigen.no-convergence",
    )
