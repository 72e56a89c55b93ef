"""PLWHEEL: upright wheel in the plane. Coordinates x_p (centre), phi_p (yaw), phi_q (spin); two slips, no deformations.

Formulas: theory-planar.md section 6. With the heading t = t(phi_p + beta_0) and the spin axis n = t turned
by +90 degrees (n points along the given direction at the start), radius r:

    e1' = t.v_p - r psi'  (longitudinal),   e2' = n.v_p  (lateral)                       (14)
    H[1, x, phi] = n, H[2, x, phi] = -t, all others zero: not symmetric, H[e, phi, x] = 0

Positive spin rolls forward. Slips have no value, so stiffness has no meaning; damping of a released slip is
a viscous force. No mass: spin and yaw inertia are lumped masses of the nodes.
"""

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, GeometryError, arc_tangent
from spacar.elements.planar import chord


class PlanarWheel(Family):
    definition = "plwheel"
    n_coordinates = 4
    n_deformations = 2
    slips = (0, 1)
    position_rows = (0, 1)

    def __init__(self, group: ElementGroup) -> None:
        """Geometry: radius, direction of the spin axis (2). GeometryError if that is zero or missing."""
        self._take(group)
        for k, values in enumerate(group.geometry):
            if len(values) < 3 or not np.any(values[1:3]):
                raise GeometryError(k, "PLWHEEL needs a radius and a direction of the spin axis, not zero")
        axis = np.array([values[1:3] for values in group.geometry]).reshape(-1, 2).T
        self.radius = np.array([values[0] for values in group.geometry])
        self.data = self.radius[:, None]
        self.coefficients = 0.0 * self.coefficients[1], self.coefficients[1]
        self.angle = arc_tangent(-axis[0], axis[1])  # of the heading: the axis turned by -90 degrees
        self.frame_p = chord.frame(np.stack((np.cos(self.angle), np.sin(self.angle))))

    def parameters(self) -> Array:
        return np.stack([self.radius, self.angle])

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> Array:
        theta = x[2] + self.angle
        t = np.stack((np.cos(theta), np.sin(theta)))
        V[0, 0:2] = t
        V[0, 3] = -self.radius
        np.negative(t[1], out=V[1, 0])
        V[1, 1] = t[0]
        return t

    def convective_strain(self, c: Array, v: Array, out: Array) -> None:
        along, across = _components(c, v)
        out[0] = v[2] * across
        out[1] = -v[2] * along

    def gradient_rate(self, c: Array, v: Array, out: Array) -> None:
        along, across = _components(c, v)
        out[0, 2] = across
        out[1, 2] = -along

    def gradient_transport(self, c: Array, v: Array, out: Array) -> None:
        t0, t1 = c
        out[0, 0], out[0, 1] = -t1 * v[2], t0 * v[2]
        out[1, 0], out[1, 1] = -t0 * v[2], -t1 * v[2]

    def rate_gradient(self, c: Array, v: Array, out: Array) -> None:
        along, across = _components(c, v)
        out[0, 2] = -v[2] * along
        out[1, 2] = -v[2] * across

    def geometric_stiffness(self, c: Array, sigma: Array, out: Array) -> None:
        t0, t1 = c
        out[0, 2] = -sigma[0] * t1 - sigma[1] * t0
        out[1, 2] = sigma[0] * t0 - sigma[1] * t1


def _components(t: Array, v: Array) -> tuple[Array, Array]:
    """Velocity of the centre along the heading and across it."""
    return t[0] * v[0] + t[1] * v[1], t[0] * v[1] - t[1] * v[0]
