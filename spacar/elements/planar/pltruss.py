"""PLTRUSS: bar. Coordinates x_p, x_q; deformation e1 = l - l0 [m], tension positive.

Formulas: theory-planar.md section 2: sigma1 = (EA/l0) e1 + (EdA/l0) de1/dt; linear interpolation of the
mass m per length, M = (m l0/6) [2I I; I 2I], h = 0. They hold in space too (`spatial.truss`).
"""

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, Trouble
from spacar.elements.planar import chord


class TrussConfiguration(NamedTuple):
    l: Array  # (n,)
    u: Array  # (2, n), in space (3, n)


class PlanarTruss(Family):
    definition = "pltruss"
    n_coordinates = 4
    n_deformations = 1
    position_rows = (0, 1, 2, 3)
    constant_mass = True

    def __init__(self, group: ElementGroup) -> None:
        """Raises GeometryError where the end nodes coincide."""
        self.keyword, self.numbers = group.keyword, group.numbers
        self._chords(group)
        l0 = self.length[:, None]
        self.coefficients = group.estiff[:, :1] / l0, group.edamp[:, :1] / l0
        self.has_mass = bool(np.any(group.em[:, 0] != 0))
        self.M = rod_mass(group.em[:, 0] * self.length, self.n_coordinates // 2)

    def _chords(self, group: ElementGroup) -> None:
        """Set the lengths, and the frames that result files have."""
        self.length, u0 = chord.start_chord(group.x0[0:2], group.x0[2:4], group.keyword)
        self.frame_p = chord.frame(u0)

    def parameters(self) -> Array:
        return self.length[None, :]

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> TrussConfiguration:
        d = _from_p_to_q(x)
        l = np.sqrt((d * d).sum(0))
        u = d / l
        _put(u, V)
        np.subtract(l, self.length, out=e[0])
        return TrussConfiguration(l, u)

    def convective_strain(self, c: TrussConfiguration, v: Array, out: Array) -> None:
        w, _, u_rate = _rates(c, v)
        out[0] = (w * u_rate).sum(0)

    def gradient_rate(self, c: TrussConfiguration, v: Array, out: Array) -> None:
        _put(_rates(c, v)[2], out)

    def rate_gradient(self, c: TrussConfiguration, v: Array, out: Array) -> None:
        w, l_rate, u_rate = _rates(c, v)
        _put(-(2.0 * l_rate * u_rate + (w * u_rate).sum(0) * c.u) / c.l, out)

    def geometric_stiffness(self, c: TrussConfiguration, sigma: Array, out: Array) -> None:
        k = len(c.u)
        P = sigma[0] / c.l * (np.eye(k)[..., None] - c.u[:, None] * c.u)
        out[:k, :k] = out[k:, k:] = P
        out[:k, k:] = out[k:, :k] = -P

    def mass(self, c: TrussConfiguration, out: Array) -> None:
        out[...] = self.M

    def inertia_force(self, c: TrussConfiguration, v: Array, a: Array | None) -> Array:
        return chord.constant_mass_force(self.M, v, a)

    def troubles(self, c: TrussConfiguration, e: Array, sigma: Array) -> list[Trouble]:
        """Vanishing length."""
        return chord.short_troubles(c.l, self.length)


def rod_mass(mass: Array, dimensions: int) -> Array:
    """Mass matrix on x_p, x_q of straight uniform rods with total mass (n,) [kg]."""
    return np.kron(np.array([[2.0, 1.0], [1.0, 2.0]]), np.eye(dimensions))[..., None] * mass / 6.0


def _from_p_to_q(x: Array) -> Array:
    p, q = x.reshape(2, -1, x.shape[1])
    return np.asarray(q - p)


def _rates(c: TrussConfiguration, v: Array) -> tuple[Array, Array, Array]:
    """Rates of x_q - x_p, of its length and of its direction."""
    w = _from_p_to_q(v)
    l_rate = (c.u * w).sum(0)
    return w, l_rate, (w - l_rate * c.u) / c.l


def _put(row: Array, out: Array) -> None:
    k = len(row)
    out[0, k:] = row
    np.negative(row, out=out[0, :k])
