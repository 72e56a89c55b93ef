"""Fluid-conveying spatial tube, keyword TUBE (theory-spatial.md section 10).

Deformations, stiffness and damping are those of the spatial beam; with ORTUBE the ends have frames of their
own and e is counted from its start value. The fluid (mass m_f per length, mass flow Q from p to q, shape
factor a) adds on the cubic centre line y of `beam_inertia`

    D dy/dt + A y,   D = Q (B* - B*^T),   A = -(a Q^2/(m_f l0)) A*
    jet at q: D[xq, xq] += Q, A[xq, tq] += a Q^2/(m_f l0);   jet at p: the same at p with the opposite sign

B* = integral of N_i N_j', A* = integral of N_i' N_j': the momentum balance of an open control volume. End
condition: 0 spherical flow at both ends, 1 jet at p, 2 jet at q, 3 jets at both.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, GeometryError
from spacar.elements.fluid import flow_parameters
from spacar.elements.rotations.local_frames import chord_frame, stack, supplemented, unit
from spacar.elements.rotations.rotation import expand
from spacar.elements.spatial.beam import SpatialBeam, SpatialBeamConfiguration, statement_values
from spacar.elements.spatial.beam_inertia import LineConstants

FLOW = np.array([[-30.0, 6, 30, -6], [-6, 0, 6, -1], [-30, -6, 30, 6], [6, 1, -6, 0]]) / 60.0
TENSION = np.array([[36.0, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]) / 30.0
JET_AT_P, JET_AT_Q = (1, 3), (2, 3)


class SpatialTube(SpatialBeam):
    """All TUBE elements of a model.

    Raises GeometryError for impossible frames, a mass flow without fluid mass and an unknown end condition.
    """

    definition = "tube"

    def __init__(self, group: ElementGroup) -> None:
        n = self._chords(group)
        direction, f1 = statement_values(group)
        frames = [_frames(group.directions[k], n[:, k], direction[k], k) for k in range(group.n)]
        frame_p, frame_q = stack([p for p, _ in frames]), stack([q for _, q in frames])
        self._build(group, frame_p, frame_q, f1)
        tube, fluid, flow, shape, end = group.em[:, :5].T
        self.fluid, self.flow, self.shape_factor = fluid, flow, shape
        self.jet_p, self.jet_q = np.isin(end, JET_AT_P), np.isin(end, JET_AT_Q)
        if flow.any():
            _check_fluid(fluid, flow, end)
        self._set_mass(tube + fluid, group.em[:, 5:9])
        self.start: Array | None = None
        if any(given is not None for given in group.directions):
            kind = group.x0.dtype
            start, V = np.zeros((6, group.n), kind), np.zeros((6, 14, group.n), kind)
            super().strain(group.x0, start, start, V)
            self.start = start

    def parameters(self) -> Array:
        return np.vstack((super().parameters(), flow_parameters(self)))

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> SpatialBeamConfiguration:
        c = super().strain(x, branch, e, V)
        if self.start is not None:
            e -= expand((self.start,), x.ndim)[0]
        return c

    @cached_property
    def line(self) -> LineConstants:
        line = super().line
        if not self.flow.any():
            return line
        D, A = self._fluid_matrices()
        return line._replace(D=D, A=A)

    def _fluid_matrices(self) -> tuple[Array, Array]:
        """D [kg/s] and A [kg/s^2], (4, 4, n) each."""
        flow = self.flow
        thrust = self.shape_factor * flow**2 / (np.where(flow == 0.0, 1.0, self.fluid) * self.length)
        D = (FLOW - FLOW.T)[..., None] * flow
        A = -TENSION[..., None] * thrust
        D[0, 0] -= self.jet_p * flow
        A[0, 1] -= self.jet_p * thrust
        D[2, 2] += self.jet_q * flow
        A[2, 3] += self.jet_q * thrust
        return D, A


def _frames(
    given: tuple[float, ...] | None, chord: Array, direction: tuple[float, ...] | None, k: int
) -> tuple[Array, Array]:
    """Frames (3, 3) at p and q: ORTUBE gives the tangent at p, the tangent at q and the y' direction at q."""
    if given is None:
        frame = chord_frame(chord, direction, k)
        return frame, frame
    if len(given) != 9:
        raise GeometryError(k, f"ORTUBE needs 9 values, {len(given)} are given")
    at_p = chord_frame(unit(given[:3], k, "tangent at p"), direction, k)
    at_q = supplemented(unit(given[3:6], k, "tangent at q"), np.asarray(given[6:]), k, "y' direction at q")
    return at_p, at_q


def _check_fluid(fluid: Array, flow: Array, end: Array) -> None:
    for k in range(len(flow)):
        if flow[k] != 0.0 and not fluid[k] > 0.0:
            raise GeometryError(k, f"the mass flow {flow[k]:g} kg/s needs a positive fluid mass per length")
        if end[k] not in (0, 1, 2, 3):
            raise GeometryError(k, f"the end condition of the flow is 0, 1, 2 or 3, not {end[k]:g}")
