"""How nodes that are left out move with the masters of their bodies, and the gravity on them.

x_i = x_P + R r_i, with the angular velocity omega and acceleration alpha: x_i' = x_P' + omega x (R r_i),
x_i'' = x_P'' + alpha x (R r_i) + omega x (omega x (R r_i)). Of Euler parameters omega = 2 Lambda-bar lambda',
alpha = 2 Lambda-bar lambda''. The last body is what rests.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.body_inertia import PAIRS, BodyInertia, NotRigid
from spacar.elements.rotations.rotation import body_matrix, global_matrix, rotate
from spacar.mechanism.numbering import Numbering
from spacar.mechanism.rigid_parts import RigidParts

_einsum = np.einsum


class Masters:
    """Those of the bodies that move, in a reduced numbering m of n, and the nodes that are gone. Raises NotRigid where
    a master is not there."""

    def __init__(self, x0: Array, n: Numbering, m: Numbering, parts: RigidParts) -> None:
        self.planar, self.d = n.planar, 2 if n.planar else 3
        size = 1 if n.planar else 4
        given = np.array([(body.point, body.turn) for body in parts.moving], np.int64).reshape(-1, 2)
        self.has_point = given[:, 0] > 0
        if given.size and given.max() >= len(m.x_places):
            raise NotRigid
        self.p, self.q = m.x_places[given[:, 0], : self.d], m.x_places[given[:, 1], :size]
        if (self.p[self.has_point] < 0).any() or (self.q < 0).any():
            raise NotRigid
        body_of = {node: k for k, body in enumerate(parts.moving) for node in body.nodes if node in parts.gone}
        rest = n.x_places[sorted(parts.gone - body_of.keys())]
        self.rest_to = rest[rest >= 0]
        self.rest_x = x0[self.rest_to]
        nodes, body = np.array([*body_of.items()], np.int64).reshape(-1, 2).T
        point, places = n.roles[nodes] == 1, n.x_places[nodes]
        self.p_to, self.p_body = places[point, : self.d], body[point]
        self.q_to, self.q_body = places[~point, :size], body[~point]
        self.to = np.append(self.p_to, self.q_to)  # coordinates that move and are gone
        self.r = (x0[self.p_to] - x0[n.x_places[given[:, 0], : self.d]][self.p_body]).T

    def motion(self, x: Array) -> BodyMotion:
        """x (steps, 3 or more, nx): coordinates, velocities, accelerations of the reduced model."""
        of_p = x[:, :3, self.p].transpose(1, 3, 0, 2) * self.has_point  # (3, d, steps, bodies)
        of_q = x[:, :3, self.q].transpose(1, 3, 0, 2)
        return BodyMotion(self, of_p, of_q)


class BodyMotion:
    """Masters at some steps: points (3, d, steps, bodies), orientations (3, 1 or 4, steps, bodies)."""

    def __init__(self, masters: Masters, points: Array, orientations: Array) -> None:
        self.masters, self.points, self.orientations = masters, points, orientations
        q = orientations[0]
        if masters.planar:
            c, s = np.cos(q[0]), np.sin(q[0])
            self.R, self.rates = np.array([[c, -s], [s, c]]), np.ones((1, 1, *q.shape[1:]))
        else:
            self.R = np.stack([rotate(q, unit.reshape(3, 1, 1)) for unit in np.eye(3)], 1)
            self.rates = 2.0 * global_matrix(q)
        self.omega, self.alpha = (_einsum("ij...,j...->i...", self.rates, q1) for q1 in orientations[1:])

    def put(self, X: Array) -> None:
        """Write coordinates, velocities, accelerations of what is gone into X (steps, 6, nx)."""
        m = self.masters
        X[:, 0, m.rest_to] = m.rest_x
        arm = self._arms()
        k = m.p_body
        omega = self.omega[..., k]
        turned = _cross(omega, arm), _cross(self.alpha[..., k], arm) + _cross(omega, _cross(omega, arm))
        for i, more in enumerate((arm, *turned)):
            X[:, i, m.p_to] = (self.points[i][..., k] + more).transpose(1, 2, 0)
            X[:, i, m.q_to] = self.orientations[i][..., m.q_body].transpose(1, 2, 0)

    def put_transfer(self, out: Array, given: Array) -> None:
        """Write the rows of what is gone into transfer functions (nx, k), at a single step."""
        m = self.masters
        arm = self._arms()[:, 0]  # (d, n)
        of_q = given[m.q]  # (bodies, 1 or 4, k)
        angle = _einsum("ijb,bjk->ibk", self.rates[:, :, 0], of_q)[:, m.p_body]
        of_p = given[m.p][m.p_body].transpose(1, 0, 2)  # (d, n, k)
        out[m.p_to] = (of_p + _cross(angle, arm[:, :, None])).transpose(1, 0, 2)
        out[m.q_to] = of_q[m.q_body]

    def _arms(self) -> Array:
        """R r (d, steps, points)."""
        m = self.masters
        return np.asarray(_einsum("ijsn,jn->isn", self.R[..., m.p_body], m.r))

    def z(self, field: Array) -> Array:
        """(steps, bodies + 1, z) of the bodies and of what rests."""
        a = _einsum("jisb,jsb->isb", self.R, self.points[2] - field[:, None, None])
        omega, alpha = self._in_axes(self.omega), self._in_axes(self.alpha)
        products = [omega[i] * omega[j] for i, j in PAIRS] if len(omega) == 3 else []
        z = np.stack([*a, *alpha, *(omega * omega), *products], 2)
        rest = np.zeros((len(z), 1, z.shape[2]))
        rest[:, 0, : len(field)] = -field
        return np.concatenate((z, rest), 1)

    def _in_axes(self, v: Array) -> Array:
        return v if self.masters.planar else np.asarray(_einsum("jisb,jsb->isb", self.R, v))


@dataclass(frozen=True)
class Weight:
    """Gravity on what is left out: G (nx, d) in the axes of the bodies, as part of their inertia forces."""

    inertia: BodyInertia
    G: Array
    field: Array

    def forces(self, motion: BodyMotion) -> Array:
        """(steps, nx) of what is left out."""
        of, steps = self.inertia, motion.R.shape[2]
        d = of.d
        rest = np.broadcast_to(np.eye(d)[:, :, None, None], (d, d, steps, 1))
        R = np.concatenate((motion.R, rest), 3)
        field = _einsum("jisb,j->isb", R, self.field)
        out = np.zeros((steps, of.numbering.nx))
        own = _einsum("nij,jsn->isn", self.G[of.p], field[..., of.p_body])
        out[:, of.p] = _einsum("ijsn,jsn->sni", R[..., of.p_body], own)
        own = _einsum("nij,jsn->isn", self.G[of.q], field[..., of.q_body])
        if not motion.masters.planar:
            still = np.zeros((4, steps, 1))
            still[0] = 1.0
            q = np.concatenate((motion.orientations[0], still), 2)[..., of.q_body]
            own = q * own[0] + _einsum("ji...,j...->i...", body_matrix(q), own[1:])
        out[:, of.q] = own.transpose(1, 2, 0)
        return out


def _cross(omega: Array, v: Array) -> Array:
    """omega x v, component first; planar: omega (1, ...)."""
    if len(omega) == 1:
        return np.asarray(omega * np.stack((-v[1], v[0])))
    shape = np.broadcast_shapes(omega.shape, v.shape)
    return np.cross(np.broadcast_to(omega, shape), np.broadcast_to(v, shape), axis=0)
