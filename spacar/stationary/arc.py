"""One step along the equilibrium path by arc length (Riks, updated normal plane).

The place on the load step is another unknown; the correction stays in the plane across the first tangent, in scaled
coordinates. One factorization serves two right-hand sides (bordering). The loads and the prescribed values are at most
quadratic in the place (rates and the flow in tubes enter as squares), so the central difference of the residual over
any distance is its derivative.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.kinematics.kinematics import largest
from spacar.stationary.contract import Tangent
from spacar.stationary.newton import Corrections, Demand, correction
from spacar.stationary.stationary_equations import Given, Iterate, StationaryEquations

At = Callable[[float], tuple[StationaryEquations, Tangent, Given]]  # puts the loads of a place on the evaluator
DISTANCE = 0.5  # of the two evaluations of the derivative


@dataclass(frozen=True)
class Arc:
    """The end of an arc: the state, its place on the load step (0 to 1), and the number of corrections."""

    point: Iterate
    place: float
    iterations: int


def arc(at: At, x: Array, sigma: Array, place: float, before: Array, s: float, limit: int) -> Arc:
    """The state at the arc length s [model lengths, rad] from x (nx,), sigma (ne,) at this place; `before` (nx,) points
    forward, `limit` is the largest number of corrections.

    Raises Astray, SingularMatrixError.
    """
    path: Corrections | None = None
    direction = np.zeros_like(x)
    while True:
        slope, given_slope = _slope(at, x, sigma, place)
        q, tangent, given = at(place)
        path = path or Corrections(Demand(limit), tangent.exact)
        p = q.point(x, sigma, given)
        if direction.any() and path.ended(p):
            return Arc(p, place, len(path.sizes))
        tangent.factor(p)
        size = q.flexibility.size
        z, noise = correction(q, tangent, p, np.zeros_like(x), slope - tangent.along(given_slope))
        r, u = np.zeros_like(x), given_slope.copy()
        r[q.F], u[q.F] = z[: q.nf, 0], z[: q.nf, 1]
        if not direction.any():
            step = s / largest(u / q.scale) * (1.0 if before @ (u / q.scale**2) >= 0.0 else -1.0)
            direction = step * u / q.scale**2
            dx, dp, ds = step * u, step, step * size * z[q.nf :, 1]
        else:
            dp = -float(direction @ r) / float(direction @ u)
            dx, ds = r + dp * u, size * (z[q.nf :, 0] + dp * z[q.nf :, 1])
            path.add(largest(dx / q.scale) if np.isfinite(ds).all() else np.inf, noise)
        q.d.sweep.near[:] = q.d.sweep.e
        x, sigma, place = x + dx, sigma + ds, place + dp


def _slope(at: At, x: Array, sigma: Array, place: float) -> tuple[Array, Array]:
    """Derivatives of the right-hand side (n,) and of the prescribed coordinates (nx,) with respect to the place."""
    q, _, ahead = at(place + DISTANCE)
    right = q.point(x, sigma, ahead).right
    q, _, behind = at(place - DISTANCE)
    right = (right - q.point(x, sigma, behind).right) / (2.0 * DISTANCE)
    given = np.zeros_like(x)
    given[q.P] = (ahead.x - behind.x)[q.P] / (2.0 * DISTANCE)
    return right, given
