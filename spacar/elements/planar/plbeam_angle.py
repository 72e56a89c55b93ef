"""PLBEAM and PLTUBE in the angle measure (ADEFORM): bending by the angle between end and chord, not by its sine.

Formulas: theory-beam-order4.md section 1. All of `plbeam` holds with another b(a),

    b_k = L_k a_k,   a = atan2(sin a, cos a),   b1 = L,   b2 = b3 = 0,

that is e2 = l0 a_p, e3 = -l0 a_q [m]. The mean curvature a_q - a_p is then exact, and the element of fourth order.

Rotary inertia J per length is consistent (section 1.3), as lumped at the ends it limits frequencies to order 2: the
slope of the cubic line turns with theta' = N q', N = (1 - 4 xi + 3 xi^2, 3 xi^2 - 2 xi, 6 xi - 6 xi^2), and

    T = 1/2 J l0 int theta'^2 = 1/2 J l0 q'^T C q',   q = (phi_p, phi_q, beta),   C = int N^T N

A tube that is curved at the start is counted from its start values, with the length of its arc (section 1.2)
l0 = chord/(1 - (2 alpha_p^2 - alpha_p alpha_q + 2 alpha_q^2)/30) in the place of the chord.
"""

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import arc_tangent
from spacar.elements.planar import chord
from spacar.elements.planar.plbeam import Bend, PlanarBeam, PlanarBeamConfiguration
from spacar.elements.planar.pltube import PlanarTube

# integral of N^T N: rotary inertia by the rates of phi_p, phi_q and of the direction beta of the chord
ROTARY = np.array([[4.0, -1.0, -3.0], [-1.0, 4.0, -3.0], [-3.0, -3.0, 36.0]]) / 30.0
ROTARY.setflags(write=False)


class PlanarAngleBeam(PlanarBeam):
    measure = "angle"
    definition = "plbeam_angle"
    fatal_angle = 170.0  # [deg] of an end to the chord; the angle jumps at 180

    def _bend(self, cosine: Array, sine: Array) -> Bend:
        b = arc_tangent(sine, cosine) * self.signed
        zero = np.zeros_like(b)
        return Bend(b, zero + self.signed, zero, zero)

    def _set_mass(self, m: Array, J: Array) -> None:
        super()._set_mass(m, J)
        self.rotary, self.lumped = J * self.length, 0.0 * self.lumped
        self._rotates = bool(np.count_nonzero(J))
        self.constant_mass = self.constant_mass and not self._rotates

    def parameters(self) -> Array:
        rows = super().parameters()
        rows[9] = self.rotary
        return rows

    # -- rotary inertia ------------------------------------------------------------------------------------
    def _turning(self, c: PlanarBeamConfiguration) -> Array:
        """Dq (3, 6, n)."""
        D = np.zeros((3, 6, *c.l.shape), c.l.dtype)
        D[0, 2] = D[1, 5] = 1.0
        D[2] = chord.row(chord.normal(c.u) / c.l)
        return D

    def _moments(self, c: PlanarBeamConfiguration, v: Array, a: Array | None) -> Array:
        """J l0 C q'' (3, n)."""
        l_rate, beta_rate = c.rates(v)
        q = np.zeros((3, *c.l.shape), np.result_type(c.l, v))
        q[2] = (-2.0 * l_rate) * beta_rate / c.l
        if a is not None:
            q[:2] += a[2::3]
            q[2] += c.rates(a)[1]
        return np.asarray(self.rotary * np.tensordot(ROTARY, q, 1))

    def mass(self, c: PlanarBeamConfiguration, out: Array) -> None:
        super().mass(c, out)
        if self._rotates:
            D = self._turning(c)
            out += np.einsum("ai...,aj...->ij...", D, self.rotary * np.einsum("ab,bj...->aj...", ROTARY, D))

    def inertia_force(self, c: PlanarBeamConfiguration, v: Array, a: Array | None) -> Array:
        out = super().inertia_force(c, v, a)
        if self._rotates:
            out = out + np.einsum("ai...,a...->i...", self._turning(c), self._moments(c, v, a))
        return out

    def inertia_gradient(self, c: PlanarBeamConfiguration, v: Array, a: Array) -> tuple[Array, Array]:
        by_x, by_v = super().inertia_gradient(c, v, a)
        if self._rotates:
            D = self._turning(c)
            rates = c.rates(v)
            of_x = c.beta_rate_gradient(*rates) + c.beta_gradient_rate(*c.rates(a))
            of_v = 2.0 * c.beta_gradient_rate(*rates)
            column = self.rotary * np.einsum("ai...,a->i...", D, ROTARY[:, 2])  # force of beta'' = 1
            by_x = by_x + column[:, None] * of_x
            by_v = by_v + column[:, None] * of_v
            u, nu = chord.row(c.u), chord.row(chord.normal(c.u))
            turned = self._moments(c, v, a)[2] / c.l**2
            by_x = by_x - turned * (u[:, None] * nu + nu[:, None] * u)
        return by_x, by_v


class PlanarAngleTube(PlanarAngleBeam, PlanarTube):
    """Geometry and errors as `PlanarTube`."""

    definition = "pltube_angle"

    def _start(self, chord_length: Array, alpha: Array) -> tuple[Array, Array]:
        p, q = alpha
        return chord_length / (1.0 - (2.0 * p * p - p * q + 2.0 * q * q) / 30.0), alpha
