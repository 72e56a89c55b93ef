"""PLTRUSS: planar bar. Coordinates x_p, x_q; deformation e1 = l - l0 [m], tension positive.

Formulas: theory-planar.md section 2: sigma1 = (EA/l0) e1 + (EdA/l0) de1/dt; linear interpolation of the
mass m per length, M = (m l0/6) [2I I; I 2I], h = 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, Trouble
from spacar.elements.planar import chord


class TrussConfiguration(NamedTuple):
    l: Array
    u: Array


class PlanarTruss(Family):
    definition = "pltruss"
    n_coordinates = 4
    n_deformations = 1
    position_rows = (0, 1, 2, 3)
    constant_mass = True

    def __init__(self, group: ElementGroup) -> None:
        """Raises GeometryError where the end nodes coincide."""
        self.keyword, self.numbers = group.keyword, group.numbers
        self.length, u0 = chord.start_chord(group.x0[0:2], group.x0[2:4], group.keyword)
        self.frame_p = chord.frame(u0)
        self.EA, self.EdA = group.estiff[:, 0], group.edamp[:, 0]
        self.has_mass = bool(np.any(group.em[:, 0] != 0))
        pattern = np.kron([[2.0, 1.0], [1.0, 2.0]], np.eye(2))
        self.M = pattern[:, :, None] * (group.em[:, 0] * self.length / 6.0)

    def parameters(self) -> Array:
        return self.length[None, :]

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> TrussConfiguration:
        d = x[2:4] - x[0:2]
        d0, d1 = d
        l = np.sqrt(d0 * d0 + d1 * d1)
        u = V[0, 2:4] = d / l
        np.negative(u, out=V[0, 0:2])
        np.subtract(l, self.length, out=e[0])
        return TrussConfiguration(l, u)

    def convective_strain(self, c: TrussConfiguration, v: Array, out: Array) -> None:
        _, beta_rate = chord.rates(c.l, c.u, v[2:4] - v[0:2])
        out[0] = c.l * beta_rate * beta_rate

    def gradient_rate(self, c: TrussConfiguration, v: Array, out: Array) -> None:
        _, beta_rate = chord.rates(c.l, c.u, v[2:4] - v[0:2])
        out[0] = chord.row(chord.length_gradient_rate(c.u, beta_rate), 4)

    def rate_gradient(self, c: TrussConfiguration, v: Array, out: Array) -> None:
        l_rate, beta_rate = chord.rates(c.l, c.u, v[2:4] - v[0:2])
        out[0] = chord.row(chord.length_rate_gradient(c.l, c.u, l_rate, beta_rate), 4)

    def geometric_stiffness(self, c: TrussConfiguration, sigma: Array, out: Array) -> None:
        g = chord.row(chord.normal(c.u), 4)
        out[...] = (sigma[0] / c.l * g)[:, None] * g

    def stiffness(self) -> tuple[Array, Array]:
        """[N/m], [N s/m]."""
        return (self.EA / self.length)[None, None], (self.EdA / self.length)[None, None]

    def mass(self, c: TrussConfiguration, out: Array) -> None:
        out[...] = self.M

    def inertia_force(self, c: TrussConfiguration, v: Array, a: Array | None) -> Array:
        return chord.constant_mass_force(self.M, v, a)

    def troubles(self, c: TrussConfiguration, e: Array, sigma: Array) -> list[Trouble]:
        """Vanishing length."""
        return chord.short_troubles(c.l, self.length)
