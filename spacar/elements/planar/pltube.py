"""PLTUBE: planar beam that may be curved at the start and carries a flowing fluid. Coordinates as PLBEAM.

Formulas: theory-planar.md section 8. The end tangents start at the angles alpha_p, alpha_q to the line p-q; e is the
change of the beam's b_p, b_q and l + Q (17); stiffness as the beam; mass per length m (tube) + mu (fluid).

Flow with the rate G = mu U [kg/s], velocity U, shape factor kappa, in the notation y of the beam's inertia (18):

    F = G (S - S^T) y' - (kappa G U/l0) (integral of N' N'^T) y + jets,   S = integral of N N'^T
    jet at q (end condition 2, 3): + G (x_q' + kappa U t_q);  at p (1, 3): - G (x_p' + kappa U t_p)

that is F = A y' + C y with constant 4 x 4 matrices A, C per element. These forces are part of M a + h, so h
is not zero at rest. Changes of G in time are taken as slow.
"""

from __future__ import annotations

import copy

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, GeometryError, arc_tangent
from spacar.elements.fluid import flow_parameters
from spacar.elements.planar import chord
from spacar.elements.planar.plbeam import PlanarBeam, PlanarBeamConfiguration

# integrals over the element (10): N'N'^T times 30, and NN'^T times 60
STRETCH = np.array([[36.0, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]])
TRANSPORT = np.array([[-30.0, 6, 30, -6], [-6, 0, 6, -1], [-30, -6, 30, 6], [6, 1, -6, 0]])
STRETCH.setflags(write=False)
TRANSPORT.setflags(write=False)


class PlanarTube(PlanarBeam):
    definition = "pltube"

    def __init__(self, group: ElementGroup) -> None:
        """Geometry: alpha_p, alpha_q (0 where not given).

        GeometryError where the nodes coincide, a flow has no fluid mass, or the end condition is not 0 to 3.
        """
        l0, u0 = chord.start_chord(group.x0[0:2], group.x0[3:5], group.keyword)
        alpha = np.zeros((2, group.n), group.x0.dtype)
        for k, values in enumerate(group.geometry):
            alpha[: len(values[0:2]), k] = values[0:2]
        tube, fluid, flow, self.shape_factor, condition, J = group.em[:, 0:6].T
        self.fluid, self.flow = fluid, flow
        for j in np.flatnonzero(~np.isin(condition, (0, 1, 2, 3))):
            raise GeometryError(int(j), f"PLTUBE: end condition {condition[j]:g} (EM) is not 0, 1, 2 or 3")
        self.jet_p, self.jet_q = np.isin(condition, (1, 3)), np.isin(condition, (2, 3))
        length, b0 = self._start(l0, alpha)
        self._set(group, length, arc_tangent(u0[1], u0[0]) + alpha, tube + fluid, J)
        b0 = self.signed * b0
        Q0 = 0.5 * ((self.A2 * b0 + self.B * b0[::-1]) * b0).sum(0)
        self.start = np.stack((l0 - length + Q0, *b0))
        self._set_flow()

    def parameters(self) -> Array:
        return np.vstack((super().parameters(), flow_parameters(self)))

    def _start(self, chord_length: Array, alpha: Array) -> tuple[Array, Array]:
        """Undeformed length (n,) [m] and b/L at the start (end, n) of tubes with the start angles alpha (end, n)."""
        return chord_length, np.sin(alpha)

    def _set_flow(self) -> None:
        """A and C (4, 4, n) of F = A y' + C y."""
        G, l0 = self.flow, self.length
        for k in np.flatnonzero((G != 0) & (self.fluid <= 0)):
            raise GeometryError(int(k), f"PLTUBE: mass flow {G[k]:g} kg/s without fluid mass per length (EM)")
        U = np.divide(G, self.fluid, out=np.zeros(self.n, np.result_type(G, self.fluid)), where=G != 0)
        momentum = self.shape_factor * G * U / l0
        self._A = ((TRANSPORT - TRANSPORT.T) / 60.0)[:, :, None] * G
        self._C = (STRETCH / -30.0)[:, :, None] * momentum
        self._A[0, 0] -= G * self.jet_p
        self._A[2, 2] += G * self.jet_q
        self._C[0, 1] -= momentum * self.jet_p
        self._C[2, 3] += momentum * self.jet_q
        self.flows = bool(np.any(G != 0))
        self.constant_mass = self.constant_mass and not self.flows

    def with_flow(self, flow: Array) -> PlanarTube:
        """The same tubes with the mass flow rates `flow` (n,) [kg/s] (DELOMF adds to `self.flow`)."""
        other = copy.copy(self)
        other.flow = np.asarray(flow)
        other._set_flow()
        return other

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> PlanarBeamConfiguration:
        c = super().strain(x, branch, e, V)
        e -= self.start
        return c

    def _line_force(self, c: PlanarBeamConfiguration, v: Array, a: Array | None) -> Array:
        F = super()._line_force(c, v, a)
        if not self.flows:
            return F
        assert c.normals is not None
        y, rate = np.zeros_like(F), np.empty_like(F)
        y[1::2] = c.t * self.length
        y[2] = c.u * c.l  # positions relative to x_p: C has no part in a common translation
        rate[0], rate[2] = v[0:2], v[3:5]
        rate[1::2] = c.normals * (self.length * v[2::3])[:, None]
        return F + (self._A[:, :, None] * rate + self._C[:, :, None] * y).sum(1)

    def inertia_gradient(self, c: PlanarBeamConfiguration, v: Array, a: Array) -> tuple[Array, Array]:
        by_x, by_v = super().inertia_gradient(c, v, a)
        if self.flows:
            assert c.normals is not None
            swing = self.length * c.normals
            by_x += self._flow_columns(c, self._C, swing)
            by_x += self._flow_columns(c, self._A, -self.length * c.t * v[2::3, None], positions=False)
            by_v += self._flow_columns(c, self._A, swing)
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
