"""The next position of a motion, as a start value for Newton's method: Hermite's polynomial through two states.

With h = t1 - t0, s = (t - t1)/h and the differences D, V, A of the earlier state from the Taylor polynomial of the
later one (positions, h times rates, h^2 times accelerations):

    x(s) = x1 + s h v1 + s^2 h^2 a1/2 + s^3 (c3 + c4 s + c5 s^2),
    c3 = -A/2 - 4V - 10D,   c4 = -A - 7V - 15D,   c5 = -A/2 - 3V - 6D.

For equal steps the error is h^6/90 times the sixth derivative, against h^3/6 times the third of Taylor's polynomial.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array

State = tuple[float, Array, Array, Array]  # t, x, xd, xdd
FARTHEST = 1.5  # steps h ahead
# Bounds of the difference between both polynomials. Below SMALL times the scale of the coordinates Newton's method
# takes two iterations from Taylor's polynomial already; above ROUGH times the motion of a step it is not smooth.
SMALL, ROUGH = 1e-6, 0.1


def extrapolated(t: float, last: State, before: State | None, scale: Array) -> Array:
    """x (nx,) at t; Taylor's polynomial where there is no earlier state, or the motion between both is not smooth."""
    t1, x1, v1, a1 = last
    step = t - t1
    taylor = x1 + step * (v1 + (0.5 * step) * a1)
    if before is None:
        return np.asarray(taylor)
    t0, x0, v0, a0 = before
    h = t1 - t0
    if h == 0.0 or not 0.0 < step / h <= FARTHEST:
        return np.asarray(taylor)
    s = step / h
    half = (0.5 * h * h) * a1
    D = x0 - x1 + h * v1 - half
    V = h * (v0 - v1) + 2.0 * half
    A = (h * h) * a0 - 2.0 * half
    c5 = -0.5 * A - 3.0 * V - 6.0 * D
    c4 = 2.0 * c5 - V - 3.0 * D
    correction = s**3 * (c4 - c5 - D + s * (c4 + s * c5))
    size = np.abs(correction / scale).max()
    if not SMALL < size < ROUGH * np.abs((taylor - x1) / scale).max():
        return np.asarray(taylor)
    return np.asarray(taylor + correction)
