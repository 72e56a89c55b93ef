"""Elements at their reference configuration that move as rigid bodies: V, and their inertia forces as a matrix.

The inertia forces of a rigid motion, in axes that coincide with those of the body, are linear in

    z = (a, alpha, squares and products of omega: xx yy zz xy xz yz; planar: one square)

a: acceleration of the master point, alpha, omega: angular acceleration and velocity. There x_i has the acceleration
a + alpha x r + omega x (omega x r); Euler parameters (1, 0) have the rates (0, omega/2) and (-omega^2/4, alpha/2).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from spacar.arrays import EPS, Array, Index
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism.mechanism import Mechanism

# Relative difference from the inertia forces of one rigid body: above the rounding of the thousands of terms of a long
# body, far below a difference of formulas.
ALIKE = 1e-9
PAIRS = (0, 1), (0, 2), (1, 2)
UPPER = np.triu_indices(3)


class NotRigid(Exception):
    """A part of a mechanism that one rigid body cannot replace."""


class Mass(NamedTuple):
    """Of one body: mass [kg], centre of mass (d,) [m], tensor about it as XM states it (1 or 6 values) [kg m^2]."""

    mass: float
    centre: Array
    tensor: Array


class BodyInertia:
    """A mechanism at its reference configuration.

    body_of (1 + highest node,): body of every node;  origin (bodies, d): master points
    """

    def __init__(self, mechanism: Mechanism, body_of: Index, origin: Array) -> None:
        n = self.numbering = mechanism.numbering
        self.origin = origin
        self.d, self.turns = (2, 1) if n.planar else (3, 3)
        self.sweep = ElementSweep.at(mechanism)
        self.sweep.constant_mass()
        self.sweep.mass()
        nodes = np.flatnonzero(n.roles)
        bodies = body_of[nodes]
        points = n.roles[nodes] == 1
        self.p, self.q = n.x_places[nodes[points], : self.d], n.x_places[nodes[~points], : 1 if n.planar else 4]
        self.p_body, self.q_body = bodies[points], bodies[~points]
        self.place = mechanism.x0[self.p]
        self.column_body = np.zeros(n.nx, np.int64)
        self.column_body[self.p], self.column_body[self.q] = self.p_body[:, None], self.q_body[:, None]

    def forces(self, origin: Array | None = None) -> Array:
        """(nx, z) inertia forces; `origin`: in the place of the master points."""
        r = self.place - (self.origin if origin is None else origin)[self.p_body]
        return _basis(self.d, self.turns, lambda a, alpha, omega: self._force(r, a, alpha, omega))

    def _force(self, r: Array, translation: Array, alpha: Array, omega: Array) -> Array:
        v, a = np.zeros((2, self.numbering.nx))
        v[self.p] = _cross(omega, r)
        a[self.p] = translation + _cross(alpha, r) + _cross(omega, _cross(omega, r))
        if self.d == 2:
            v[self.q], a[self.q] = omega, alpha
        else:
            v[self.q[:, 1:]], a[self.q[:, 1:]] = 0.5 * omega, 0.5 * alpha
            a[self.q[:, 0]] = -0.25 * omega @ omega
        return self.sweep.mass_times(a) + self.sweep.inertia_force(v, None)

    def masses(self, n: int) -> list[Mass]:
        """Those of the first n bodies. Raises NotRigid where the inertia forces are not those of rigid bodies."""
        d = self.d
        force, moment, extent = self._resultants(self.origin, n)
        mass = np.einsum("bii->b", force[:, :, :d]) / d
        first = (moment[:, 0, 1], -moment[:, 0, 0]) if d == 2 else (moment[:, 2, 1], moment[:, 0, 2], moment[:, 1, 0])
        whole = np.where(mass == 0.0, 1.0, mass)
        centre = self.origin.copy()
        centre[:n] += np.stack(first, 1) / whole[:, None]
        force, moment, _ = self._resultants(centre, n)
        found = []
        for k in range(n):
            m, J = mass[k], moment[k][:, d : d + self.turns]
            largest = np.abs(J).max() + m * extent[k] ** 2
            J = np.where(np.abs(J) > 64.0 * EPS * largest, 0.5 * (J + J.T), 0.0)
            of_force, of_moment = _of_rigid_body(d, self.turns, m, J)
            if not (
                np.all(np.abs(force[k] - of_force) <= ALIKE * m * max(extent[k], 1.0))
                and np.all(np.abs(moment[k] - of_moment) <= ALIKE * (largest + m * extent[k]))
            ):
                raise NotRigid
            found.append(Mass(float(m), centre[k], J[0] if d == 2 else J[UPPER]))
        return found

    def _resultants(self, origin: Array, n: int) -> tuple[Array, Array, Array]:
        """Forces (n, d, z) and moments about the origins (n, turns, z) of n bodies, and their extents (n,)."""
        C = self.forces(origin)
        r = self.place - origin[self.p_body]
        f = C[self.p]
        if self.d == 2:
            of_points = (r[:, :1] * f[:, 1] - r[:, 1:] * f[:, 0])[:, None]
        else:
            of_points = np.cross(r[:, :, None], f, axis=1)
        of_turns = C[self.q] if self.d == 2 else 0.5 * C[self.q[:, 1:]]
        force, moment = (np.zeros((len(origin), size, C.shape[1])) for size in (self.d, self.turns))
        extent = np.zeros(len(origin))
        np.add.at(force, self.p_body, f)
        np.add.at(moment, self.p_body, of_points)
        np.add.at(moment, self.q_body, of_turns)
        np.maximum.at(extent, self.p_body, np.sqrt((r * r).sum(1)))
        return force[:n], moment[:n], extent


def _basis(d: int, turns: int, of: Callable[[Array, Array, Array], Array]) -> Array:
    """The vectors of(a, alpha, omega) for the unit vectors of z, as columns."""
    none, still, units = np.zeros(d), np.zeros(turns), np.eye(turns)
    squares = [of(none, still, unit) for unit in units]
    found = [of(unit, still, still) for unit in np.eye(d)] + [of(none, unit, still) for unit in units]
    products = [of(none, still, units[i] + units[j]) - squares[i] - squares[j] for i, j in PAIRS if turns == 3]
    return np.array([*found, *squares, *products]).T


def _of_rigid_body(d: int, turns: int, m: float, J: Array) -> tuple[Array, Array]:
    """Force (d, z) and moment (turns, z) of a body about its centre of mass."""

    def moment(_: Array, alpha: Array, omega: Array) -> Array:
        return J @ alpha + (np.cross(omega, J @ omega) if turns == 3 else 0.0)

    return _basis(d, turns, lambda a, alpha, omega: m * a), _basis(d, turns, moment)


def _cross(omega: Array, r: Array) -> Array:
    """omega x r (n, d); planar: omega (1,)."""
    return np.cross(omega, r) if r.shape[1] == 3 else omega * np.stack((-r[:, 1], r[:, 0]), 1)
