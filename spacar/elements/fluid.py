"""A fluid in tubes, in the plane and in space: forces on the cubic centre line y = (x_p, l0 t_p, x_q, l0 t_q).

With the mass m_f per length, the mass flow Q from p to q, the shape factor a and cubic shape functions N

    F = D dy/dt + A y,   D = Q (B - B^T),   A = -(a Q^2/(m_f l0)) A*,   B = int N N'^T,   A* = int N' N'^T
    jet at q: D[x_q, x_q] += Q, A[x_q, t_q] += a Q^2/(m_f l0);   jet at p: the same at p with the opposite sign

which is the momentum balance of an open control volume. End condition: 0 spherical flow at both ends, 1 jet at p, 2 jet
at q, 3 jets at both. Changes of Q in time are taken as slow (theory-planar.md section 8, theory-spatial.md section 10).
"""

import copy
from typing import NamedTuple, TypeVar

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import GeometryError

TRANSPORT = np.array([[-30.0, 6, 30, -6], [-6, 0, 6, -1], [-30, -6, 30, 6], [6, 1, -6, 0]]) / 60.0
STRETCH = np.array([[36.0, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]) / 30.0
for _matrix in (TRANSPORT, STRETCH):
    _matrix.setflags(write=False)


class Fluid(NamedTuple):
    """Of the tubes of a group: values of EM, (n,) each; `flow` [kg/s]."""

    mass: Array
    flow: Array
    shape_factor: Array
    end: Array

    def check(self, keyword: str) -> None:
        """Raises GeometryError for a flow without fluid mass and an end condition that is not 0 to 3."""
        for k in np.flatnonzero((self.flow != 0) & ~(self.mass > 0)):
            text = f"{keyword}: mass flow {self.flow[k]:g} kg/s without fluid mass per length (EM)"
            raise GeometryError(int(k), text)
        for k in np.flatnonzero(~np.isin(self.end, (0, 1, 2, 3))):
            raise GeometryError(int(k), f"{keyword}: end condition {self.end[k]:g} (EM) is not 0, 1, 2 or 3")

    def parameters(self, l0: Array) -> Array:
        """Mass flow and thrust a Q^2/(m_f l0); both again where there is a jet at p, at q: (6, n)."""
        flow = self.flow
        thrust = self.shape_factor * flow**2 / (np.where(flow == 0.0, 1.0, self.mass) * l0)
        jets = np.isin(self.end, (1, 3)), np.isin(self.end, (2, 3))
        return np.stack([flow, *(flow * jet for jet in jets), thrust, *(thrust * jet for jet in jets)])

    def matrices(self, l0: Array) -> tuple[Array, Array]:
        """D [kg/s] and A [kg/s^2], (4, 4, n) each."""
        flow, flow_p, flow_q, thrust, thrust_p, thrust_q = self.parameters(l0)
        D = (TRANSPORT - TRANSPORT.T)[..., None] * flow
        A = -STRETCH[..., None] * thrust
        D[0, 0] -= flow_p
        D[2, 2] += flow_q
        A[0, 1] -= thrust_p
        A[2, 3] += thrust_q
        return D, A


Tubes = TypeVar("Tubes", bound="CarriesFlow")


class CarriesFlow:
    """What families of tubes have in common."""

    fluid: Fluid

    def with_flow(self: Tubes, flow: Array) -> Tubes:
        """The same tubes with the mass flow rates `flow` (n,) [kg/s] (DELOMF adds to those of EM)."""
        other = copy.copy(self)
        other.fluid = self.fluid._replace(flow=np.asarray(flow))
        other._set_flow()
        return other

    def _set_flow(self) -> None:
        """What follows from the mass flow."""
        raise NotImplementedError
