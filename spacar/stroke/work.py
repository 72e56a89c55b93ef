"""Work of the drive and of the other loads along the stroke (docs/flexures.md section 4).

    drive   integral of F ds by Hermite's rule, h (F_0 + F_1)/2 + h^2 (k_0 - k_1)/12 in a step of length h, k = dF/ds;
            its error is of fourth order in the step
    others  sum of (f_0 + f_1).(x_1 - x_0)/2: exact for constant forces, second order for gravity on beams
    moments sum of M.theta, theta the rotation vector from one state to the next: exact for turns about one axis

Both are counted from the undeflected state. Their sum is the strain energy that the mechanism has gained; what is
missing is the error of the integrals.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from spacar.arrays import Array
from spacar.stroke.error_motions import rotation_vector


def drive_work(stroke: Array, force: Array, slope: Array, zero: int) -> Array:
    """(k,) work of the drive [J]; without a finite slope the trapezoidal rule."""
    h = np.diff(stroke)
    correction = h**2 * (slope[:-1] - slope[1:]) / 12.0
    parts = 0.5 * h * (force[:-1] + force[1:]) + np.where(np.isfinite(correction), correction, 0.0)
    return _from_zero(parts, zero)


def load_work(forces: Array, x: Array, zero: int) -> Array:
    """(k,) work of the forces (k, nx) on the coordinates x (k, nx) [J]."""
    parts = 0.5 * np.sum((forces[:-1] + forces[1:]) * np.diff(x, axis=0), axis=1)
    return _from_zero(parts, zero)


def moment_work(moments: Array, turns: Array, zero: int) -> Array:
    """(k,) work of constant global moments (n, 3) on nodes with the Euler parameters turns (k, n, 4) [J]."""
    parts = [
        sum(float(M @ rotation_vector(b, a)) for M, a, b in zip(moments, before, after, strict=True))
        for before, after in pairwise(turns)
    ]
    return _from_zero(np.array(parts, float), zero)


def _from_zero(parts: Array, zero: int) -> Array:
    total = np.concatenate(([0.0], np.cumsum(parts)))
    return np.asarray(total - total[zero])
