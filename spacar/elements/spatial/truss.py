"""Spatial truss, keyword TRUSS: e1 = l - l0 [m] (theory-spatial.md sections 3.3 and 4).

Coordinates x_p (3), x_q (3) [m]. Inertia of a straight bar with mass m per length: M = (m l0/6) [2I I; I 2I].
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, Trouble
from spacar.elements.rotations.local_frames import chords

COLLAPSED = 1e-6  # smallest fraction of the undeformed length


class TrussState(NamedTuple):
    """Length (n,) [m] and direction (3, n)."""

    l: Array
    n: Array


class SpatialTruss(Family):
    """All TRUSS elements of a model. Raises GeometryError for zero length."""

    definition = "truss"
    n_coordinates = 6
    n_deformations = 1
    position_rows = (0, 1, 2, 3, 4, 5)
    constant_mass = True

    def __init__(self, group: ElementGroup) -> None:
        self.keyword, self.numbers = group.keyword, group.numbers
        self.length, _ = chords(group.x0[3:] - group.x0[:3], group.x0)
        self.has_mass = bool(np.any(group.em[:, 0] != 0.0))
        self._mass = rod_mass(group.em[:, 0] * self.length)
        self._rigidity = group.estiff[:, 0], group.edamp[:, 0]

    def parameters(self) -> Array:
        return self.length[None, :]

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> TrussState:
        d = x[3:] - x[:3]
        l = np.sqrt(np.einsum("i...,i...->...", d, d))
        n = d / l
        e[0] = l - self.length.reshape(self.length.shape + (1,) * (x.ndim - 2))
        _put(n, V)
        return TrussState(l, n)

    def convective_strain(self, c: TrussState, v: Array, out: Array) -> None:
        d, n1 = _rates(c, v)
        out[0] = np.einsum("i...,i...->...", d, n1)

    def gradient_rate(self, c: TrussState, v: Array, out: Array) -> None:
        _put(_rates(c, v)[1], out)

    def rate_gradient(self, c: TrussState, v: Array, out: Array) -> None:
        d, n1 = _rates(c, v)
        nu = np.einsum("i...,i...->...", c.n, d)
        kappa = np.einsum("i...,i...->...", d, n1)
        _put(-(2.0 * nu * n1 + kappa * c.n) / c.l, out)

    def geometric_stiffness(self, c: TrussState, sigma: Array, out: Array) -> None:
        P = -(sigma[0] / c.l) * c.n[:, None] * c.n
        for i in range(3):
            P[i, i] += sigma[0] / c.l
        out[:3, :3] = out[3:, 3:] = P
        out[:3, 3:] = out[3:, :3] = -P

    def stiffness(self) -> tuple[Array, Array]:
        """EA/l0 [N/m] and EdA/l0 [N s/m]."""
        S, S_d = (k / self.length for k in self._rigidity)
        return S.reshape(1, 1, -1), S_d.reshape(1, 1, -1)

    def mass(self, c: TrussState, out: Array) -> None:
        out[...] = self._mass.reshape(self._mass.shape + (1,) * (out.ndim - 3))

    def inertia_force(self, c: TrussState, v: Array, a: Array | None) -> Array:
        if a is None:
            return np.zeros_like(v)
        M = self._mass.reshape(self._mass.shape + (1,) * (a.ndim - 2))
        return np.asarray(np.einsum("ij...,j...->i...", M, a))

    def troubles(self, c: TrussState, e: Array, sigma: Array) -> list[Trouble]:
        return [
            Trouble(
                int(k),
                f"has collapsed: its length is {c.l[k]:.3g} m, undeformed {self.length[k]:.3g} m",
                True,
            )
            for k in np.flatnonzero(~(c.l > COLLAPSED * self.length))
        ]


def rod_mass(mass: Array) -> Array:
    """(6, 6, n) mass matrix on x_p, x_q of straight uniform rods with total mass (n,) [kg]."""
    return np.kron(np.array([[2.0, 1.0], [1.0, 2.0]]), np.eye(3))[..., None] * mass / 6.0


def _rates(c: TrussState, v: Array) -> tuple[Array, Array]:
    """Rate of x_q - x_p and of its direction, (3, n) each."""
    d = v[3:] - v[:3]
    return d, (d - np.einsum("i...,i...->...", c.n, d) * c.n) / c.l


def _put(row: Array, out: Array) -> None:
    out[0, 3:] = row
    np.negative(row, out=out[0, :3])
