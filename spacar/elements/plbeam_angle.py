"""PLBEAM and PLTUBE in the angle measure (ADEFORM): bending by the angle between end and chord, not by its sine.

Formulas: theory-beam-order4.md section 1. All of `plbeam` holds with another b(a),

    b_k = L_k a_k,   a = atan2(sin a, cos a),   b1 = L,   b2 = b3 = 0,

that is e2 = l0 a_p, e3 = -l0 a_q [m]. The mean curvature a_q - a_p is then exact, and the element of fourth order.

A tube that is curved at the start is counted from its start values, with the length of its arc (section 1.2)
l0 = chord/(1 - (2 alpha_p^2 - alpha_p alpha_q + 2 alpha_q^2)/30) in the place of the chord.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array

from .angles import arc_tangent
from .plbeam import Bend, PlanarBeam
from .pltube import PlanarTube


class PlanarAngleBeam(PlanarBeam):
    measure = "angle"
    fatal_angle = 170.0  # [deg] of an end to the chord; the angle jumps at 180

    def _bend(self, cosine: Array, sine: Array) -> Bend:
        b = arc_tangent(sine, cosine) * self.signed
        zero = np.zeros_like(b)
        return Bend(b, zero + self.signed, zero, zero)


class PlanarAngleTube(PlanarAngleBeam, PlanarTube):
    """Geometry and errors as `PlanarTube`."""

    def _start(self, chord_length: Array, alpha: Array) -> tuple[Array, Array]:
        p, q = alpha
        return chord_length / (1.0 - (2.0 * p * p - p * q + 2.0 * q * q) / 30.0), alpha
