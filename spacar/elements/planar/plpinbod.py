"""PLPINBOD, PLRBEAM: node q rigidly fixed to the body p. Coordinates x_p, phi_p, x_q; e1, e2 [m].

Formulas: theory-planar.md section 5. Body-fixed directions a_k (k = 1, 2), r_k = R(phi_p) a_k, s_k = r_k
turned by +90 degrees, d = x_q - x_p:

    e_k = r_k.d - d_k                                                                              (13)
    D = (-r_k, s_k.d, r_k);   D^2: (d, phi): s_k,  (phi, phi): -r_k.d
    H(v,v) = 2 omega s_k.w - omega^2 r_k.d;   T: (d) -omega^2 r_k,  (phi) -2 omega r_k.w - omega^2 s_k.d

a = the global axes (PLPINBOD), or a_1 along p-q and a_2 turned by +90 degrees (PLRBEAM); ORPINBOD overrides
both. d_k = a_k.d at the start unless DRPINBOD gives it. Mass m per length: uniform rod p-q, (m l0/6) [2I I;
I 2I] on x_p, x_q, h = 0; J l0 on phi_p.
"""

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, GeometryError
from spacar.elements.planar import chord
from spacar.elements.planar.pltruss import rod_mass


class PinbodyConfiguration(NamedTuple):
    d: Array  # (2, n) x_q - x_p
    r: Array  # (direction, component, n)
    s: Array  # r turned by +90 degrees
    e_phi: Array  # (2, n) s.d


def body_directions(group: ElementGroup) -> Array:
    """a (direction, component, n); GeometryError: PLRBEAM without length, zero or parallel directions."""
    a = np.zeros((2, 2, group.n), group.x0.dtype)
    given = [k for k, values in enumerate(group.directions) if values is not None]
    for k in given:
        values = np.asarray(group.directions[k])
        if values.size == 2:
            size = chord.distance(values)
            if size == 0.0:
                raise GeometryError(k, "ORPINBOD: the direction has length zero")
            c, s = values / size
            values = np.array([c, s, -s, c])
        a[:, :, k] = values.reshape(2, 2)
        (a1, a2), (b1, b2) = a[:, :, k]
        if abs(a1 * b2 - a2 * b1) <= 1e-10 * np.hypot(abs(a1), abs(a2)) * np.hypot(abs(b1), abs(b2)):
            raise GeometryError(k, "ORPINBOD: the two directions are parallel")
    rest = np.setdiff1d(np.arange(group.n), given)
    if group.keyword == "PLRBEAM" and rest.size:
        try:
            _, u0 = chord.start_chord(group.x0[0:2, rest], group.x0[3:5, rest], group.keyword)
        except GeometryError as error:
            raise GeometryError(int(rest[error.index]), str(error)) from None
        a[0][:, rest], a[1][:, rest] = u0, chord.normal(u0)
    else:
        a[0, 0, rest] = a[1, 1, rest] = 1.0
    return a


class PlanarPinbody(Family):
    definition = "plpinbod"
    n_coordinates = 5
    n_deformations = 2
    position_rows = (0, 1, 3, 4)
    constant_mass = True

    def __init__(self, group: ElementGroup) -> None:
        """Raises GeometryError, see body_directions."""
        self._take(group)
        d0 = group.x0[3:5] - group.x0[0:2]
        self.length = chord.distance(d0)
        a = self.a = body_directions(group)
        self.turned = np.stack((-a[:, 1], a[:, 0]), axis=1)
        zero = np.zeros(group.n)
        self.frame_p = np.stack((*a[0], zero, *a[1], zero, zero, zero, zero + 1.0), axis=-1)
        self.d0 = (a * d0).sum(1)
        for k, values in enumerate(group.projections):
            if values is not None:
                self.d0[: len(values), k] = values
        self.data = self.d0.T.copy()
        m, J = group.em[:, 0] * self.length, group.em[:, 1] * self.length
        self.has_mass = bool(np.any(m != 0) or np.any(J != 0))
        self.M = np.zeros((5, 5, group.n), m.dtype)
        self.M[np.ix_(self.position_rows, self.position_rows)] = rod_mass(m, 2)
        self.M[2, 2] = J

    def parameters(self) -> Array:
        a, d = self.a, self.d0
        return np.stack([a[0, 0], a[0, 1], d[0], a[1, 0], a[1, 1], d[1]])

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> PinbodyConfiguration:
        d = x[3:5] - x[0:2]
        c, s = np.cos(x[2]), np.sin(x[2])
        r = self.a * c + self.turned * s
        r_turned = self.turned * c - self.a * s
        along, across = r * d, r_turned * d
        np.subtract(along[:, 0] + along[:, 1], self.d0, out=e)
        e_phi = V[:, 2] = across[:, 0] + across[:, 1]
        V[:, 3:5] = r
        np.negative(r, out=V[:, 0:2])
        return PinbodyConfiguration(d, r, r_turned, e_phi)

    def convective_strain(self, c: PinbodyConfiguration, v: Array, out: Array) -> None:
        omega = v[2]
        # 2 omega s.w - omega^2 r.d = omega (2 s.w - omega r.d): one product with both vectors
        terms = c.s * (2.0 * (v[3:5] - v[0:2])) - c.r * (omega * c.d)
        np.multiply(terms[:, 0] + terms[:, 1], omega, out=out)

    def gradient_rate(self, c: PinbodyConfiguration, v: Array, out: Array) -> None:
        omega, w = v[2], v[3:5] - v[0:2]
        out[:, 3:5] = c.s * omega
        out[:, 0:2] = -out[:, 3:5]
        out[:, 2] = (c.s * w - c.r * (omega * c.d)).sum(1)

    def rate_gradient(self, c: PinbodyConfiguration, v: Array, out: Array) -> None:
        omega, w = v[2], v[3:5] - v[0:2]
        out[:, 0:2] = omega * omega * c.r
        out[:, 3:5] = -out[:, 0:2]
        out[:, 2] = -2.0 * omega * (c.r * w).sum(1) - omega * omega * c.e_phi

    def geometric_stiffness(self, c: PinbodyConfiguration, sigma: Array, out: Array) -> None:
        force = (sigma[:, None] * c.s).sum(0)
        out[3:5, 2] = out[2, 3:5] = force
        out[0:2, 2] = out[2, 0:2] = -force
        out[2, 2] = -(sigma * (c.r * c.d).sum(1)).sum(0)

    def mass(self, c: PinbodyConfiguration, out: Array) -> None:
        out[...] = self.M

    def inertia_force(self, c: PinbodyConfiguration, v: Array, a: Array | None) -> Array:
        return chord.constant_mass_force(self.M, v, a)
