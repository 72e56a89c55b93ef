"""Spatial orientation nodes: normalization, rigid bodies and gyrostats (theory-spatial.md section 1).

Coordinates lambda (4). Body components of a tensor are its global components in the start configuration,
where R = I. With w' = Lambda dlam/dt (half the angular velocity) and Lambda(a)^T w = K(w) a:

    M = 4 Lambda^T J Lambda,     h = 8 Lambda1^T J Lambda dlam/dt,     Lambda1 = Lambda(dlam/dt)
    gyrostat: h = 4 K(h') dlam/dt with the constant h' = J_axial Omega in body components
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.elements.family import Family
from spacar.elements.rotations.rotation import body_dual, body_matrix

_einsum = np.einsum


class Normalization(Family):
    """One row for each spatial orientation node; `nodes` (n,) are the user's node numbers."""

    n_coordinates = 4
    n_deformations = 1
    definition = keyword = "normalization"

    def __init__(self, nodes: NDArray[np.int64]) -> None:
        self.numbers = nodes

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> None:
        e[0] = np.einsum("i...,i...->...", x, x) - 1.0
        np.multiply(x, 2.0, out=V[0])

    def convective_strain(self, c: None, v: Array, out: Array) -> None:
        out[0] = 2.0 * np.einsum("i...,i...->...", v, v)

    def gradient_rate(self, c: None, v: Array, out: Array) -> None:
        np.multiply(v, 2.0, out=out[0])

    def rate_gradient(self, c: None, v: Array, out: Array) -> None:
        out[...] = 0.0

    def geometric_stiffness(self, c: None, sigma: Array, out: Array) -> None:
        for i in range(4):
            out[i, i] = 2.0 * sigma[0]


class BodyState(NamedTuple):
    """Tensor (3, 3, n) and Lambda (3, 4, n)."""

    J: Array
    L: Array


class RigidBodyNode(Family):
    """Orientation nodes `nodes` (n,) with inertia tensors J (n, 3, 3) [kg m^2], all contributions summed."""

    n_coordinates = 4
    has_mass = True
    definition = "body"
    keyword = "rigid body"

    def __init__(self, nodes: NDArray[np.int64], J: Array) -> None:
        self.numbers = nodes
        self.J = np.ascontiguousarray(np.moveaxis(np.asarray(J), 0, -1))

    def parameters(self) -> Array:
        J = self.J
        return np.stack([J[0, 0], J[0, 1], J[0, 2], J[1, 1], J[1, 2], J[2, 2]])

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> BodyState:
        return BodyState(self.J, body_matrix(x))

    def mass(self, c: BodyState, out: Array) -> None:
        out[...] = _einsum("ai...,aj...->ij...", 4.0 * c.L, _einsum("ab...,bj...->aj...", c.J, c.L))

    def inertia_force(self, c: BodyState, v: Array, a: Array | None) -> Array:
        f = _force(body_matrix(v), c, v, 8.0)
        return f if a is None else f + _force(c.L, c, a, 4.0)

    def inertia_gradient(self, c: BodyState, v: Array, a: Array) -> tuple[Array, Array]:
        L1, L2 = body_matrix(v), body_matrix(a)
        m, m1 = (_einsum("ab...,bi...,i...->a...", c.J, c.L, y) for y in (a, v))
        fx = 4.0 * body_dual(m) - 4.0 * _product(c.L, c.J, L2) - 8.0 * _product(L1, c.J, L1)
        return fx, 8.0 * body_dual(m1) + 8.0 * _product(L1, c.J, c.L)


class GyrostatNode(Family):
    """Rotors whose axis is fixed in an orientation node: body components h (n, 3) of J_axial Omega [kg m^2/s].

    The axial tensor of a rotor with prescribed relative rate (`prescribed_rotor_tensor`) belongs to the RigidBodyNode.
    """

    n_coordinates = 4
    has_mass = True  # forces that depend on the velocity; M is zero
    keyword = "gyrostat"

    def __init__(self, nodes: NDArray[np.int64], h: Array) -> None:
        self.numbers = nodes
        self.K = 4.0 * body_dual(np.ascontiguousarray(np.asarray(h).T))

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> Array:
        return self.K

    def inertia_force(self, c: Array, v: Array, a: Array | None) -> Array:
        return np.asarray(_einsum("ij...,j...->i...", c, v))

    def inertia_gradient(self, c: Array, v: Array, a: Array) -> tuple[Array, Array]:
        shape = (4, 4, *v.shape[1:])
        return np.zeros(shape), np.broadcast_to(c, shape)


def prescribed_rotor_tensor(omega: Array, J: Array) -> Array:
    """J a a^T (n, 3, 3) with a = omega/|omega|: axial inertia that a rotor of type 1 adds to its node.

    omega (n, 3) [rad/s], J (n,) [kg m^2]. A rotor at rest has no axis and adds nothing.
    """
    size = np.sqrt((omega * omega).sum(1))
    a = np.divide(omega, size[:, None], out=np.zeros_like(omega), where=size[:, None] > 0.0)
    return np.asarray(J[:, None, None] * a[:, :, None] * a[:, None, :])


def _force(left: Array, c: BodyState, y: Array, factor: float) -> Array:
    """factor left^T J Lambda y (4, n)."""
    w = _einsum("ai...,i...->a...", c.L, factor * y)
    return np.asarray(_einsum("ai...,a...->i...", left, _einsum("ab...,b...->a...", c.J, w)))


def _product(a: Array, J: Array, b: Array) -> Array:
    """a^T J b (4, 4, n)."""
    return np.asarray(_einsum("ai...,aj...->ij...", a, _einsum("ab...,bj...->aj...", J, b)))
