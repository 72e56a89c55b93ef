"""PLTUBE: planar beam that may be curved at the start and carries a flowing fluid. Coordinates as PLBEAM.

Formulas: theory-planar.md section 8. The end tangents start at the angles alpha_p, alpha_q to the line p-q; e is the
change of the beam's b_p, b_q and l + Q (17); stiffness as the beam; mass per length m (tube) + mu (fluid).

The forces of the fluid are in `fluid`; they are part of M a + h, so h is not zero at rest.
"""

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, arc_tangent
from spacar.elements.fluid import CarriesFlow, Fluid
from spacar.elements.planar import chord
from spacar.elements.planar.plbeam import PlanarBeam, PlanarBeamConfiguration


class PlanarTube(CarriesFlow, PlanarBeam):
    definition = "pltube"

    def __init__(self, group: ElementGroup) -> None:
        """Geometry: alpha_p, alpha_q (0 where not given).

        GeometryError where the nodes coincide, a flow has no fluid mass, or the end condition is not 0 to 3.
        """
        l0, u0 = chord.start_chord(group.x0[0:2], group.x0[3:5], group.keyword)
        alpha = np.zeros((2, group.n), group.x0.dtype)
        for k, values in enumerate(group.geometry):
            alpha[: len(values[0:2]), k] = values[0:2]
        tube, *fluid, J = group.em[:, 0:6].T
        self.fluid = Fluid(*fluid)
        length, b0 = self._start(l0, alpha)
        self._set(group, length, arc_tangent(u0[1], u0[0]) + alpha, tube + self.fluid.mass, J)
        b0 = self.signed * b0
        Q0 = 0.5 * ((self.A2 * b0 + self.B * b0[::-1]) * b0).sum(0)
        self.start = np.stack((l0 - length + Q0, *b0))
        self._set_flow()

    def parameters(self) -> Array:
        return np.vstack((super().parameters(), self.fluid.parameters(self.length)))

    def _start(self, chord_length: Array, alpha: Array) -> tuple[Array, Array]:
        """Undeformed length (n,) [m] and b/L at the start (end, n) of tubes with the start angles alpha (end, n)."""
        return chord_length, np.sin(alpha)

    def _set_flow(self) -> None:
        """D and A (4, 4, n) of the force D y' + A y."""
        self.fluid.check(self.keyword)
        self._D, self._A = self.fluid.matrices(self.length)
        self.flows = bool(np.any(self.fluid.flow != 0))
        self.constant_mass = self.constant_mass and not self.flows

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> PlanarBeamConfiguration:
        c = super().strain(x, branch, e, V)
        e -= self.start
        return c

    def _line_force(self, c: PlanarBeamConfiguration, v: Array, a: Array | None) -> Array:
        F = super()._line_force(c, v, a)
        if not self.flows:
            return F
        y, rate = np.zeros_like(F), np.empty_like(F)
        y[1::2] = c.t * self.length
        y[2] = c.u * c.l  # positions relative to x_p: A has no part in a common translation
        rate[0], rate[2] = v[0:2], v[3:5]
        rate[1::2] = c.normals * (self.length * v[2::3])[:, None]
        return F + (self._D[:, :, None] * rate + self._A[:, :, None] * y).sum(1)

    def inertia_gradient(self, c: PlanarBeamConfiguration, v: Array, a: Array) -> tuple[Array, Array]:
        by_x, by_v = super().inertia_gradient(c, v, a)
        if self.flows:
            swing = self.length * c.normals
            by_x += self._flow_columns(c, self._A, swing)
            by_x += self._flow_columns(c, self._D, -self.length * c.t * v[2::3, None], positions=False)
            by_v += self._flow_columns(c, self._D, swing)
        return by_x, by_v

    def _flow_columns(self, c: PlanarBeamConfiguration, K: Array, z: Array, positions: bool = True) -> Array:
        """Derivative of Y^T K y (6, 6, n): z (end, 2, n) is that of the tangents of y to their angles."""
        out = self._angle_columns(c, K[:, None, 1::2] * z.swapaxes(0, 1))
        if positions:
            for j in self.position_rows:
                F = np.zeros((4, 2, self.n), np.result_type(K, c.t))
                F[:, j % 3] = K[:, 2 * (j // 3)]
                out[:, j] = self._project(c, F)
        return out
