"""How good an eigenpair is: its normwise backward error, and the warning when rounding does not explain it.

A pair (lambda, z) of A z = lambda B z is exact for matrices A + dA, B + dB with (Higham and Higham 1998)

    |dA|/|A|, |dB|/|B| <= eta = |A z - lambda B z| / ((|A| + |lambda| |B|) |z|)

The unknowns of a mechanism have units (m, rad), and eta depends on them; it is taken after a diagonal scaling, D A D
and D^-1 z, which makes it independent of units. Algorithms that work with orthogonal transformations give n eps. The
reduction with the Cholesky factor of B may lose up to the condition of B (Davies, Higham, Tisseur 2001), which is that
of a mesh: LOST allows three digits, measured are one to two. A pair above that is not wrong, but has fewer digits than
its matrices: it is kept, with a warning.

How far an eigenvalue moves by eta is a question of conditioning, not of the solver: low eigenvalues of a stiff system
move by eta |A| |B^-1|, whatever they are worth.
"""

import numpy as np
from numpy.linalg import norm  # of matrices that of Frobenius: at most sqrt(n) above the spectral one, and cheap

from spacar.arrays import EPS, Array, Complex
from spacar.errors import Report

LOST = 1e3  # digits that a reduction may lose, as a factor of n eps


def rounding(n: int) -> float:
    """Backward error of n unknowns that needs no word."""
    return LOST * EPS * max(n, 1)


def of_pencil(A: Array, B: Array, values: Array, vectors: Array, d: Array) -> Array:
    """eta of pairs A z = lambda B z (real), A and B scaled with d from both sides."""
    scale = d[:, None] * d
    return of_scaled_pencil(A * scale, B * scale, values, vectors / d[:, None])


def of_scaled_pencil(A: Array, B: Array, values: Array, vectors: Array) -> Array:
    """The same of matrices and vectors that have been scaled: D A D, D B D, D^-1 z."""
    residual = A @ vectors - (B @ vectors) * values
    return _relative(residual, norm(A) + np.abs(values) * norm(B), vectors)


def of_matrix(A: Array, values: Complex, vectors: Complex) -> Array:
    """eta of pairs A z = lambda z, the smaller one of A as it is and A balanced: algorithms do one or the other."""
    from scipy.linalg import matrix_balance

    residual = A @ vectors - vectors * values
    plain = _relative(residual, norm(A) + np.abs(values), vectors)
    if not len(A) or not np.all(np.isfinite(A)):
        return plain
    balanced, (d, _) = matrix_balance(A, permute=False, separate=True)
    scaled = _relative(residual / d[:, None], norm(balanced) + np.abs(values), vectors / d[:, None])
    return np.minimum(plain, scaled)


def warn(
    report: Report, error: Array, values: Array | Complex, what: str, limit: float | None = None,
    advice: str = "the system is badly conditioned",
) -> None:  # fmt: skip
    """A warning about the worst pair when its error, eta or another relative residual, is above the limit.

    Without `limit`: what rounding explains.
    """
    limit = rounding(len(error)) if limit is None else limit
    usual = error <= limit
    if not usual.all():
        worst = int(np.argmax(np.where(np.isnan(error), np.inf, error)))
        report.add(
            f"warning: {int((~usual).sum())} of {len(error)} {what} have fewer digits than usual; the worst one,"
            f" {values[worst]:.6g}, has a relative residual of {error[worst]:.2g} (limit {limit:.1g}); {advice}"
        )


def _relative(residual: Array | Complex, size: Array, vectors: Array | Complex) -> Array:
    bound = size * norm(vectors, axis=0)
    return np.asarray(norm(residual, axis=0) / np.where(bound > 0.0, bound, 1.0))
