"""PLBELT: planar belt or gear. Coordinates x_p, phi_p, x_q, phi_q; deformation e1 elongation of the belt [m].

Formulas: theory-planar.md section 7. Signed base radii r_p, r_q (positive: belt on the left when looking from p to q),
rho = r_p - r_q, d = x_q - x_p, |d| > |rho|. The straight span has the length l = sqrt(d.d - rho^2), the direction

    u = (l d - rho d turned by +90 degrees)/d.d,   n = u turned by +90 degrees

and theta, the angle from its start direction to u (chord angle plus delta, sin delta = -rho/|d|):

    e1 = l - l0 + r_p phi_p - r_q phi_q - rho theta                                      (15)
    D = u.dd + r_p dphi_p - r_q dphi_q;  D theta = n.dd/l;  D l = (u + rho n/l).dd
    H = k^2/l,  H1 = (k/l) n,  T = -[2 l' k n + k^2 u + (rho/l) k^2 n]/l^2,  l' = u.w, k = n.w

Coordinates give theta within whole turns only. `strain` takes the turn that is closest to theta at the last accepted
state (x, e1), which (15) gives; e1 itself tells nothing where rho is small, as its values differ by 2 pi rho. Where rho
is so small that rounding hides the turn in (15), that turn is below the rounding of e1.

Inertia (16): mass m per length on the start length of the span, velocity linear between v_i = x_i' - r_i phi_i' u,
i = p, q; h is Lagrange's. The wound angles w_i add the constants m |r_i| w_i at the centre and m |r_i|^3 w_i at the
angle.
"""

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, GeometryError, Trouble, arc_tangent
from spacar.elements.planar import chord

LINEAR_MASS = np.array([[2.0, 1.0], [1.0, 2.0]])  # integral of N N^T for N = (1 - xi, xi), times 6
LINEAR_MASS.setflags(write=False)


class BeltConfiguration(NamedTuple):
    l: Array
    u: Array
    n: Array  # u turned by +90 degrees


class PlanarBelt(Family):
    definition = "plbelt"
    n_coordinates = 6
    n_deformations = 1
    position_rows = (0, 1, 3, 4)
    has_own_branch = True

    def __init__(self, group: ElementGroup) -> None:
        """Geometry: radii r_p, r_q. GeometryError where the pulleys are too close for a straight span."""
        self.keyword, self.numbers = group.keyword, group.numbers
        self.radii = np.array([values[0:2] for values in group.geometry], group.x0.dtype).reshape(-1, 2).T
        self.data = self.radii.T.copy()
        self.rho = self.radii[0] - self.radii[1]
        d = group.x0[3:5] - group.x0[0:2]
        gap = (d * d).sum(0) - self.rho**2
        for k in np.flatnonzero(gap <= 1e-12 * self.rho**2):
            raise GeometryError(
                int(k),
                f"PLBELT has no straight span: the distance of its nodes is {np.hypot(*d[:, k]):.6g} m and "
                f"must be larger than |r_p - r_q| = {abs(self.rho[k]):.6g} m",
            )
        self.length, self.u0 = self._span(d)[0:2]
        self.frame_p = chord.frame(d / chord.distance(d))
        self.turn = 2.0 * np.pi * self.rho
        self.per_rho = np.divide(1.0, self.rho, out=np.zeros_like(self.rho), where=self.rho.real != 0.0)
        l0 = self.length[:, None]
        self.coefficients = group.estiff[:, :1] / l0, group.edamp[:, :1] / l0
        self._set_mass(group.em[:, 0], group.em[:, 1:3].T)

    def _set_mass(self, m: Array, wound: Array) -> None:
        self.has_mass = bool(np.any(m != 0))
        self.unit = unit = m * self.length / 6.0
        r = self.radii
        constant = np.zeros((6, 6, self.n), unit.dtype)
        for k in (0, 1):
            constant[[k, 3 + k], [k, 3 + k]] = 2.0 * unit
            constant[[k, 3 + k], [3 + k, k]] = unit
        constant[2, 2], constant[5, 5] = 2.0 * unit * r * r
        constant[2, 5] = constant[5, 2] = unit * r[0] * r[1]
        self.wound = np.zeros((6, self.n), unit.dtype)
        size = r * np.sign(r.real)  # |r|; np.abs would drop the direction of a complex step
        self.wound[2::3] = m * size**3 * wound
        self.wound[0::3] = self.wound[1::3] = m * size * wound
        constant[np.arange(6), np.arange(6)] += self.wound
        self._constant = constant
        # position block (2), component (1), pulley (2)
        self._coupling = -LINEAR_MASS[:, None, :, None] * (unit * r)

    def _span(self, d: Array) -> tuple[Array, Array, Array]:
        """l, u and n of the straight span."""
        square = d[0] * d[0] + d[1] * d[1]
        l = np.sqrt(square - self.rho * self.rho)
        u = (l * d - self.rho * chord.normal(d)) / square
        return l, u, chord.normal(u)

    # -- deformations --------------------------------------------------------------------------------------
    def parameters(self) -> Array:
        return np.stack([self.length, *self.radii, *self.u0, self.unit, *self.wound])

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> BeltConfiguration:
        l, u, n = self._span(x[3:5] - x[0:2])
        cosine, sine = self.u0 * u, self.u0 * n
        # u0 x u = -u0.n: the sine of the angle from u0 to u
        theta = arc_tangent(-(sine[0] + sine[1]), cosine[0] + cosine[1])
        turns = np.rint((theta.real - branch[0]) / (2.0 * np.pi))
        e[0] = self._without_turning(x, l) - self.rho * theta + self.turn * turns
        V[0, 3:5] = u
        np.negative(u, out=V[0, 0:2])
        V[0, 2] = self.radii[0]
        np.negative(self.radii[1], out=V[0, 5])
        return BeltConfiguration(l, u, n)

    def _without_turning(self, x: Array, l: Array) -> Array:
        """e1 + rho theta."""
        r_p, r_q = self.radii
        return l - self.length + r_p * x[2] - r_q * x[5]

    def branch(self, x: Array, e: Array) -> Array:
        """theta [rad]; zero where rho vanishes."""
        l = self._span(x[3:5] - x[0:2])[0]
        return np.asarray(((self._without_turning(x, l) - e) * self.per_rho).real)

    @staticmethod
    def _rates(c: BeltConfiguration, v: Array) -> tuple[Array, Array]:
        """u.w and n.w [m/s]."""
        w = v[3:5] - v[0:2]
        return (c.u * w).sum(0), (c.n * w).sum(0)

    def convective_strain(self, c: BeltConfiguration, v: Array, out: Array) -> None:
        _, k = self._rates(c, v)
        out[0] = k * k / c.l

    def gradient_rate(self, c: BeltConfiguration, v: Array, out: Array) -> None:
        _, k = self._rates(c, v)
        out[0] = chord.row(k / c.l * c.n)

    def rate_gradient(self, c: BeltConfiguration, v: Array, out: Array) -> None:
        along, k = self._rates(c, v)
        out[0] = chord.row(-((2.0 * along + self.rho * k / c.l) * k * c.n + k * k * c.u) / c.l**2)

    def geometric_stiffness(self, c: BeltConfiguration, sigma: Array, out: Array) -> None:
        g = chord.row(c.n)
        out[...] = (sigma[0] / c.l * g)[:, None] * g

    # -- inertia -------------------------------------------------------------------------------------------
    def mass(self, c: BeltConfiguration, out: Array) -> None:
        out[...] = self._constant
        blocks = out.reshape(2, 3, 2, 3, *out.shape[2:])
        side = self._coupling * c.u[:, None]  # position block, component, pulley
        blocks[:, 0:2, :, 2] = side
        blocks[:, 2, :, 0:2] = side.transpose(2, 0, 1, 3)

    def _momenta(self, y: Array) -> Array:
        """(2, 2, n): (m l0/6) (2 y_p + y_q, 2 y_q + y_p) of end values y (end, component, n)."""
        return self.unit * (y + (y[0] + y[1]))

    def _motion(self, c: BeltConfiguration, v: Array, a: Array | None) -> tuple[Array, Array, Array, Array]:
        """theta', r phi' (end, n), momenta P of the pulley ends and their rates P' (end, component, n)."""
        theta_rate = self._rates(c, v)[1] / c.l
        rim = self.radii * v[2::3]
        v_ends = v.reshape(2, 3, *v.shape[1:])[:, 0:2] - rim[:, None] * c.u
        a_ends = (rim * -theta_rate)[:, None] * c.n
        if a is not None:
            a_ends += a.reshape(2, 3, *a.shape[1:])[:, 0:2] - (self.radii * a[2::3])[:, None] * c.u
        return theta_rate, rim, self._momenta(v_ends), self._momenta(a_ends)

    def inertia_force(self, c: BeltConfiguration, v: Array, a: Array | None) -> Array:
        theta_rate, rim, P, P_rate = self._motion(c, v, a)
        P_n = P * c.n
        P_n = P_n[:, 0] + P_n[:, 1]
        P_u = P_rate * c.u
        turning = rim * P_n
        side = ((turning[0] + turning[1]) / c.l) * c.n  # -(dT/dtheta) D theta
        out = np.empty((6, *c.l.shape), P.dtype)
        np.subtract(P_rate[0], side, out=out[0:2])
        np.add(P_rate[1], side, out=out[3:5])
        np.multiply(-self.radii, P_u[:, 0] + P_u[:, 1] + theta_rate * P_n, out=out[2::3])
        if a is not None:
            out += self.wound * a
        return out

    def inertia_gradient(self, c: BeltConfiguration, v: Array, a: Array) -> tuple[Array, Array]:
        # M a + h = F(theta, theta', D theta; v, a) = (P', -r (u.P' + theta' n.P)) - (dT/dtheta) D theta
        theta_rate, rim, P, P_rate = self._motion(c, v, a)
        r, u, n = self.radii, c.u, c.n
        g = chord.row(n / c.l)
        g_u, g_n = chord.row(u), chord.row(n)
        cross = g_u[:, None] * g_n
        hessian = -(cross + cross.swapaxes(0, 1) + self.rho / c.l * g_n[:, None] * g_n) / c.l**2
        P_n, P_u = (P * n).sum(1), (P * u).sum(1)

        # with respect to theta, at fixed theta' and D theta
        dP = self._momenta(-rim[:, None] * n)
        dP_rate = self._momenta(-(r * a[2::3])[:, None] * n + (rim * theta_rate)[:, None] * u)
        by_theta = np.zeros((6, *c.l.shape), dP_rate.dtype)
        by_theta[0:2], by_theta[3:5] = dP_rate
        moment = (P_rate * n).sum(1) + (dP_rate * u).sum(1) + theta_rate * ((dP * n).sum(1) - P_u)
        by_theta[2::3] = -r * moment
        by_theta += (rim * ((dP * n).sum(1) - P_u)).sum(0) * g

        # with respect to theta'
        by_rate = np.zeros_like(by_theta)
        by_rate[0:2], by_rate[3:5] = dP
        by_rate[2::3] = -r * ((dP * u).sum(1) + P_n)

        by_x = by_theta[:, None] * g + by_rate[:, None] * (hessian * v).sum(1) + (rim * P_n).sum(0) * hessian
        by_v = by_rate[:, None] * g
        for j in range(6):
            rate = np.zeros((2, 2, *c.l.shape), u.dtype)  # of the pulley ends per unit of v_j
            pulley, place = divmod(j, 3)
            if place == 2:
                rate[pulley] = -r[pulley] * u
                end = np.zeros_like(rate)
                end[pulley] = -(r[pulley] * theta_rate) * n
                dP_rate = self._momenta(end)
                by_v[0:2, j] += dP_rate[0]
                by_v[3:5, j] += dP_rate[1]
                by_v[2::3, j] -= r * (dP_rate * u).sum(1)
                by_v[:, j] += r[pulley] * P_n[pulley] * g
            else:
                rate[pulley, place] = 1.0
            dP_n = (self._momenta(rate) * n).sum(1)
            by_v[2::3, j] -= r * theta_rate * dP_n
            by_v[:, j] += (rim * dP_n).sum(0) * g
        return by_x, by_v

    # -- limits --------------------------------------------------------------------------------------------
    def troubles(self, c: BeltConfiguration, e: Array, sigma: Array) -> list[Trouble]:
        """Pulleys that have come too close for a straight span."""
        return [
            Trouble(
                int(k),
                f"no straight span is left: the distance of the nodes has come down to |r_p - r_q| = "
                f"{abs(self.rho[k]):.6g} m; check the radii and their signs",
                True,
            )
            for k in np.flatnonzero(~(c.l > chord.SHORT * self.length))
        ]
