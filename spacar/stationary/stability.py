"""Is a stationary state stable, and which motion is it that loses its stiffness?

The mixed matrix has one negative eigenvalue for every stress of a stable state (a multiplier, or -C), and one more for
every negative eigenvalue of the tangent stiffness K0 + G0 (+ N0) on the motions that the constraints leave: inertia is
a matter of congruence, independent of the choice of degrees of freedom. Unsymmetric matrices (steady motion, follower
loads, user functions, slips) have no inertia: there only the sign of the determinant is known, that is whether the
number of negative eigenvalues is odd.

The critical motion is the eigenvector of the tangent stiffness with the eigenvalue nearest to zero (a negative one,
if asked for), in scaled coordinates, by inverse iteration with a block of vectors; of small symmetric matrices the
inverse itself is decomposed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from spacar.arrays import EPS, Array
from spacar.linear_systems import SingularMatrixError
from spacar.stationary.newton import correction
from spacar.stationary.resting_tangent import RestingTangent
from spacar.stationary.stationary_equations import Iterate, StationaryEquations, Tangent

CRITICAL = sqrt(EPS)  # of the model: rounding takes half of the digits of the position
BLOCK = 6  # vectors
ITERATIONS = 8
ALIKE = 1.0 - 1e-6  # of the largest motion
DIRECT = 30  # coordinates up to which all unit vectors at once, a whole inverse, are faster than the iteration


@dataclass(frozen=True)
class Stability:
    """Numbers of negative and zero eigenvalues of the tangent stiffness.

    exact      False: `negative` tells odd (1) from even (0) only
    critical   rounding decides about the signs, and all eigenvalues count as zero
    """

    negative: int
    zero: int
    exact: bool
    critical: bool = False

    def differs(self, before: Stability) -> bool:
        """Has an eigenvalue changed its sign? Zero ones (a motion that has only the stiffness of the loads, before
        they act) may take either."""
        if not (self.exact and before.exact):
            return self.negative != before.negative
        return self.negative > before.negative + before.zero or self.negative + self.zero < before.negative

    def __str__(self) -> str:
        if not self.exact:
            return f"an {'odd' if self.negative else 'even'} number of negative eigenvalues"
        return f"{self.negative} negative eigenvalue{'s' * (self.negative != 1)}"


STABLE = Stability(0, 0, True)


def stability(
    q: StationaryEquations, tangent: Tangent, p: Iterate, noise: float, regular: bool = False,
    before: Stability | None = None,
) -> Stability | None:  # fmt: skip
    """At the point where the sweep is, which is known up to `noise`; `regular`: the matrix is known to be so there;
    `before`: the stability of the state before.

    None when it cannot be told (slips, a cyclic coordinate in steady motion).
    """
    if not q.holonomic or not q.d.numbering.nddof:
        return None
    if isinstance(tangent, RestingTangent):
        if tangent.natural(p) and (regular or is_regular(q, tangent, p)):
            return STABLE
        if tangent.symmetric:
            critical = noise > CRITICAL
            hopeful = not critical and (before is None or before.negative == 0)
            if hopeful and tangent.is_definite(p) and (regular or is_regular(q, tangent, p)):
                return STABLE
            negative, zero = tangent.inertia(p)
            return Stability(max(negative - q.ne, 0), q.nf if critical else zero, True, critical)
    if not is_regular(q, tangent, p):
        return None
    return Stability(int(tangent.sign() < 0.0), 0, False)


def is_regular(q: StationaryEquations, tangent: Tangent, p: Iterate) -> bool:
    try:
        tangent.factor(p)
        correction(q, tangent, p, np.zeros_like(p.x))
    except SingularMatrixError:
        return False
    return True


def critical_motion(q: StationaryEquations, tangent: Tangent, p: Iterate, negative: bool) -> str:
    """'node 5 y' that moves most in the critical motion; '' if that cannot be told."""
    try:
        tangent.factor(p)
        x = _nearest_zero(q, tangent, negative)
    except SingularMatrixError:
        return ""
    if x is None:
        return ""
    size = np.abs(x)
    first = int(np.argmax(size >= ALIKE * size.max()))  # of several that move alike, whatever rounding does
    return q.d.numbering.x_name(int(q.F[first]))


def _nearest_zero(q: StationaryEquations, tangent: Tangent, negative: bool) -> Array | None:
    """Scaled eigenvector (nf,) of the critical motion; None when it cannot be told."""
    n, nf, scale = q.nf + q.ne, q.nf, q.free_scale
    if nf <= DIRECT and tangent.symmetric:
        X, iterations = np.eye(nf), 1
    else:
        X, iterations = np.random.default_rng(1).standard_normal((nf, min(BLOCK, nf))), ITERATIONS
    for _ in range(iterations):
        X = X if iterations == 1 else np.linalg.qr(X)[0]
        b = np.zeros((n, X.shape[1]))
        b[:nf] = X / scale[:, None]
        Y = tangent.solve(b)[:nf] / scale[:, None]  # inverse of the scaled tangent stiffness
        if not np.isfinite(Y).all():
            return None
        H, X = X.T @ Y, Y
    values, vectors = np.linalg.eigh((H + H.T) / 2.0)
    chosen = np.abs(values)
    if negative and (values < 0.0).any():
        chosen = -values
    first = int(np.argmax(chosen))
    shape = X @ vectors[:, first] / (values[first] or 1.0)
    return np.asarray(shape) if np.isfinite(shape).all() else None
