"""PLBEAM: planar flexible beam. Coordinates x_p, phi_p, x_q, phi_q; e1 elongation, e2, e3 bending [m].

Formulas: theory-planar.md section 3. With a_k = phi_k + beta_k - beta the rotation of end k relative to the
chord (beta_k its start direction), signed lengths L = (l0, -l0), s, c = sin, cos of a_k:

    b_k = L_k s_k,  k = p, q      e2 = b_p, e3 = b_q                                     (3)
    e1 = l - l0 + Q(b)            Q = A (b_p^2 + b_q^2) + B b_p b_q                      (4), (5)

Q is the shortening of the chord by bending (0 with LDEFORM); with shear flexibility Phi = 12 EI/(GAk l0^2)

    A = (4 + 5 Phi + 2.5 Phi^2)/(60 l0 (1 + Phi)^2),  B = (2 + 10 Phi + 5 Phi^2)/(60 l0 (1 + Phi)^2),

that is 2 A, B = (5 +- 3/(1 + Phi)^2)/(60 l0).

Derivatives (6), (7): with the row alpha_k = (1 at phi_k) - D beta and b1, b2, b3 = db/da, ..., both ends at once

    D b = b1 alpha                             H_b = b2 alpha_v^2 - b1 H_beta
    H1_b = b2 alpha_v alpha - b1 H1_beta
    T_b = b3 alpha_v^2 alpha - b2 (H_beta alpha + 2 alpha_v H1_beta) - b1 T_beta

Here b1 = L_k c_k, b2 = -b, b3 = -b1; `plbeam_angle` has another b(a).

Inertia (9)-(12): cubic interpolation of the elastic line, y = (x_p, l0 t_p, x_q, l0 t_q) with the unit end
tangents t; rotary inertia J per length is lumped, J l0/2 at each end.

Arrays over both ends have the end axis first: t (end, component, n), b (end, n).
"""

from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, Trouble, arc_tangent
from spacar.elements.planar import chord

# integral of N N^T over the element, times 420 (10)
CUBIC_MASS = np.array([[156.0, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
CUBIC_MASS.setflags(write=False)

WARN_ANGLE = 60.0  # [deg] of an end to the chord


class Bend(NamedTuple):
    """The bending deformations b(a) of both ends and their derivatives by a, (end, n) each."""

    b: Array
    b1: Array
    b2: Array
    b3: Array


class PlanarBeamConfiguration(NamedTuple):
    """What is known at one x: end tangents `t` (end, component, n), the same turned by +90 degrees."""

    l: Array
    u: Array
    t: Array
    normals: Array
    bend: Bend
    Q_b: Array  # dQ/db

    def rates(self, v: Array) -> tuple[Array, Array]:
        """l' [m/s] and beta' [rad/s]."""
        u, w = self.u, v[3:5] - v[0:2]
        along = u * w
        return along[0] + along[1], (u[0] * w[1] - u[1] * w[0]) / self.l

    def beta_gradient_rate(self, l_rate: Array, beta_rate: Array) -> Array:
        """The row H1_beta."""
        return chord.row(-(l_rate / self.l * chord.normal(self.u) + beta_rate * self.u) / self.l)

    def beta_rate_gradient(self, l_rate: Array, beta_rate: Array) -> Array:
        """The row T_beta."""
        rho = l_rate / self.l
        square = (rho * rho - beta_rate * beta_rate) * chord.normal(self.u)
        return chord.row(2.0 * (square + 2.0 * rho * beta_rate * self.u) / self.l)


class PlanarBeam(Family):
    n_coordinates = 6
    n_deformations = 3
    position_rows = (0, 1, 3, 4)
    definition = "plbeam"
    start: Array | float = 0.0  # deformations of tubes at the start
    fatal_angle: ClassVar[float] = 85.0  # [deg] of an end to the chord; e2, e3 are stationary at 90

    def __init__(self, group: ElementGroup) -> None:
        """Raises GeometryError where the end nodes coincide."""
        l0, u0 = chord.start_chord(group.x0[0:2], group.x0[3:5], group.keyword)
        beta0 = arc_tangent(u0[1], u0[0])
        self._set(group, l0, np.array((beta0, beta0)), group.em[:, 0], group.em[:, 1])

    def _set(self, group: ElementGroup, l0: Array, angle: Array, m: Array, J: Array) -> None:
        """What beams and tubes have in common: start directions `angle` (end, n), mass m and J per length."""
        self.keyword, self.numbers, self.length = group.keyword, group.numbers, l0
        self.angle, self.signed = angle, np.array((l0, -l0))  # signed: L (end, n)
        self.frame_p, self.frame_q = map(chord.frame, np.array((np.cos(angle), np.sin(angle))).swapaxes(0, 1))
        EA, EI, shear = group.estiff[:, 0:3].T
        self.rigidity, self.viscosity = (EA, EI), (group.edamp[:, 0], group.edamp[:, 1])
        self.Phi, rest = shear, 3.0
        if np.count_nonzero(shear):
            self.Phi = 12.0 * shear / (l0 * l0)
            sheared = 1.0 + self.Phi
            rest = 3.0 / (sheared * sheared)
        scale = group.nonlinear / (60.0 * l0)
        self.A2, self.B = (5.0 + rest) * scale, (5.0 - rest) * scale
        self._set_mass(m, J)

    def _set_mass(self, m: Array, J: Array) -> None:
        self.constant_mass = not np.count_nonzero(m)
        self.has_mass = not self.constant_mass or bool(np.count_nonzero(J))
        self.unit = m * self.length / 420.0  # factor of CUBIC_MASS
        self.lumped = 0.5 * J * self.length

    def parameters(self) -> Array:
        own = self.length, self.angle, 0.5 * self.A2, self.B, self.start, self.unit, self.lumped
        rows = np.empty((10, self.n), np.result_type(*own))
        rows[0], rows[1:3], rows[3], rows[4], rows[5:8], rows[8], rows[9] = own
        return rows

    @cached_property
    def mass_parts(self) -> tuple[Array, Array, Array]:
        """Of the mass matrix: what does not turn (6, 6, n); positions by angles (position block, component, end, n);
        both angles (n,)."""
        l0 = self.length
        constant = np.zeros((6, 6, self.n), self.unit.dtype)
        for k in (0, 1):
            constant[[k, 3 + k], [k, 3 + k]] = 156.0 * self.unit
            constant[[k, 3 + k], [3 + k, k]] = 54.0 * self.unit
        constant[[2, 5], [2, 5]] = 4.0 * l0**2 * self.unit + self.lumped
        coupling = CUBIC_MASS[0::2, 1::2, None][:, None] * (self.unit * l0)
        return constant, coupling, -3.0 * l0**2 * self.unit

    # -- deformations --------------------------------------------------------------------------------------
    def _bend(self, cosine: Array, sine: Array) -> Bend:
        """b of the angles between end tangents and chord, from their cosines and sines (end, n)."""
        b, b_prime = sine * self.signed, cosine * self.signed
        return Bend(b, b_prime, -b, -b_prime)

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> PlanarBeamConfiguration:
        d = x[3:5] - x[0:2]
        l = np.sqrt(d[0] * d[0] + d[1] * d[1])
        u = u0, u1 = d / l
        theta = x[2::3] + self.angle
        t0, t1 = np.cos(theta), np.sin(theta)
        bend = self._bend(t0 * u0 + t1 * u1, t1 * u0 - t0 * u1)
        b, b_prime = bend.b, bend.b1
        Q_b = self.A2 * b + self.B * b[::-1]

        twice_Q = Q_b * b
        e[0] = l - self.length + 0.5 * (twice_Q[0] + twice_Q[1])
        e[1:] = b

        K = b_prime / l
        QK = Q_b * K
        K = np.array((QK[0] + QK[1], *K))  # -d(e)/d(beta)/l apart from the elongation of the chord
        V[:, 3], V[:, 4] = K * u1, -K * u0
        V[0, 3:5] += u
        V[:, 0:2] = -V[:, 3:5]
        V[0, 2::3] = Q_b * b_prime
        V[1, 2], V[2, 5] = b_prime
        t, normals = np.array((t0, t1)).swapaxes(0, 1), np.array((-t1, t0)).swapaxes(0, 1)
        return PlanarBeamConfiguration(l, u, t, normals, bend, Q_b)

    def _rates(self, c: PlanarBeamConfiguration, v: Array) -> tuple[Array, Array, Array, Array, Array]:
        """l', beta', H_beta(v,v) and, per end, alpha_v and H_b(v,v)."""
        l_rate, beta_rate = c.rates(v)
        H_beta = (-2.0 * l_rate) * beta_rate / c.l
        alpha_v = v[2::3] - beta_rate
        return l_rate, beta_rate, H_beta, alpha_v, c.bend.b2 * (alpha_v * alpha_v) - c.bend.b1 * H_beta

    def convective_strain(self, c: PlanarBeamConfiguration, v: Array, out: Array) -> None:
        _, beta_rate, _, alpha_v, H_b = self._rates(c, v)
        b_rate = c.bend.b1 * alpha_v
        bend = c.Q_b * H_b + b_rate * (self.A2 * b_rate + self.B * b_rate[::-1])
        out[0] = c.l * (beta_rate * beta_rate) + bend[0] + bend[1]
        out[1:] = H_b

    def _alpha(self, c: PlanarBeamConfiguration) -> Array:
        """Rows alpha, (end, 6, n)."""
        g = chord.row(chord.normal(c.u) / c.l)
        alpha = np.empty((2, *g.shape), g.dtype)
        np.negative(g, out=alpha[0])
        alpha[1] = alpha[0]
        alpha[0, 2] += 1.0
        alpha[1, 5] += 1.0
        return alpha

    def _b_rows(self, c: PlanarBeamConfiguration, v: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Rows alpha (end, 6, n), H1_beta (6, n), D b and H1_b (end, 6, n); Q_b' (end, n)."""
        l_rate, beta_rate, _, alpha_v, _ = self._rates(c, v)
        alpha = self._alpha(c)
        H1_beta = c.beta_gradient_rate(l_rate, beta_rate)
        H1_b = (c.bend.b2 * alpha_v)[:, None] * alpha - c.bend.b1[:, None] * H1_beta
        b_rate = c.bend.b1 * alpha_v
        return alpha, H1_beta, c.bend.b1[:, None] * alpha, H1_b, self.A2 * b_rate + self.B * b_rate[::-1]

    def gradient_rate(self, c: PlanarBeamConfiguration, v: Array, out: Array) -> None:
        _, _, D_b, H1_b, Q_b_rate = self._b_rows(c, v)
        _, beta_rate = c.rates(v)
        out[0] = (c.Q_b[:, None] * H1_b + Q_b_rate[:, None] * D_b).sum(0)
        out[0] += chord.row(beta_rate * chord.normal(c.u))
        out[1:] = H1_b

    def rate_gradient(self, c: PlanarBeamConfiguration, v: Array, out: Array) -> None:
        l_rate, beta_rate, H_beta, alpha_v, H_b = self._rates(c, v)
        alpha, H1_beta, D_b, H1_b, Q_b_rate = self._b_rows(c, v)
        T_beta = c.beta_rate_gradient(l_rate, beta_rate)
        _, b1, b2, b3 = c.bend
        T_b = (b3 * alpha_v * alpha_v - b2 * H_beta)[:, None] * alpha
        T_b -= 2.0 * (b2 * alpha_v)[:, None] * H1_beta + b1[:, None] * T_beta
        Q_H = self.A2 * H_b + self.B * H_b[::-1]
        out[0] = (c.Q_b[:, None] * T_b + Q_H[:, None] * D_b + 2.0 * Q_b_rate[:, None] * H1_b).sum(0)
        T_l = -(2.0 * l_rate * beta_rate / c.l) * chord.normal(c.u) - beta_rate * beta_rate * c.u
        out[0] += chord.row(T_l)
        out[1:] = T_b

    def geometric_stiffness(self, c: PlanarBeamConfiguration, sigma: Array, out: Array) -> None:
        g_u, g_n = chord.row(c.u), chord.row(chord.normal(c.u))
        alpha = self._alpha(c)
        s = sigma[1:] + c.Q_b * sigma[0]
        mixed = ((s * c.bend.b1).sum(0) / c.l**2 * g_u)[:, None] * g_n
        np.multiply((sigma[0] / c.l * g_n)[:, None], g_n, out=out)
        out += mixed + mixed.swapaxes(0, 1)
        D_b = c.bend.b1[:, None] * alpha
        # sum over the ends of (weights)^T rows; the second derivative of Q joins both ends
        weighted = sigma[0] * (self.A2 * D_b + self.B * D_b[::-1])
        turned = (s * c.bend.b2)[:, None] * alpha
        out += (weighted[:, :, None] * D_b[:, None] + turned[:, :, None] * alpha[:, None]).sum(0)

    # -- stresses ------------------------------------------------------------------------------------------
    def stiffness(self) -> tuple[Array, Array]:
        """(8): [N/m], [N s/m]."""
        return self._stiffness(*self.rigidity), self._stiffness(*self.viscosity)

    def _stiffness(self, EA: Array, EI: Array) -> Array:
        S = np.zeros((3, 3, self.n), EI.dtype)
        if not (np.count_nonzero(EA) or np.count_nonzero(EI)):  # rigid beams, or no damping
            return S
        S[0, 0] = EA / self.length
        bend = EI / (self.length * self.length * self.length * (1.0 + self.Phi))
        S[1, 1] = S[2, 2] = (4.0 + self.Phi) * bend
        S[1, 2] = S[2, 1] = (-2.0 + self.Phi) * bend
        return S

    # -- inertia -------------------------------------------------------------------------------------------
    def mass(self, c: PlanarBeamConfiguration, out: Array) -> None:
        constant, coupling, cross = self.mass_parts
        out[...] = constant
        N = c.normals
        blocks = out.reshape(2, 3, 2, 3, *out.shape[2:])
        side = coupling * N.swapaxes(0, 1)  # position block, component, end of the angle
        blocks[:, 0:2, :, 2] = side
        blocks[:, 2, :, 0:2] = side.transpose(2, 0, 1, 3)
        dot = N[0] * N[1]
        out[2, 5] = out[5, 2] = (dot[0] + dot[1]) * cross

    def _line_force(self, c: PlanarBeamConfiguration, v: Array, a: Array | None) -> Array:
        """Force (4, 2, n) dual to y, of the accelerations of x_p, l0 t_p, x_q, l0 t_q."""
        y = np.zeros((4, 2, *v.shape[1:]), c.t.dtype)
        omega = v[2::3]
        turn = c.t * (omega * -omega)[:, None]
        if a is not None:
            y[0], y[2] = a[0:2], a[3:5]
            turn += c.normals * a[2::3, None]
        y[1::2] = turn * self.length
        return np.asarray((CUBIC_MASS @ (y * self.unit).reshape(4, -1)).reshape(y.shape))

    def _project(self, c: PlanarBeamConfiguration, F: Array) -> Array:
        """Force dual to x, (6, n), of a force F (4, 2, n) dual to y."""
        out = np.empty((6, *F.shape[2:]), F.dtype)
        out[0:2], out[3:5] = F[0], F[2]
        moment = c.normals * F[1::2]
        np.multiply(moment[:, 0] + moment[:, 1], self.length, out=out[2::3])
        return out

    def inertia_force(self, c: PlanarBeamConfiguration, v: Array, a: Array | None) -> Array:
        out = self._project(c, self._line_force(c, v, a))
        if a is not None:
            out[2::3] += self.lumped * a[2::3]
        return out

    def inertia_gradient(self, c: PlanarBeamConfiguration, v: Array, a: Array) -> tuple[Array, Array]:
        omega, spin = v[2::3, None], a[2::3, None]
        turned = -self.length * (c.t * spin + c.normals * omega**2)
        by_x = self._angle_columns(c, self._mass_columns(turned))
        # where Y turns with the ends: -l0 t.F on the diagonal of the angles
        by_x[[2, 5], [2, 5]] -= self.length * (c.t * self._line_force(c, v, a)[1::2]).sum(1)
        by_v = self._angle_columns(c, self._mass_columns(-2.0 * self.length * c.t * omega))
        return by_x, by_v

    def _mass_columns(self, z: Array) -> Array:
        """Force (4, 2, end, n) of the accelerations z (end, 2, n) of one tangent at a time."""
        return CUBIC_MASS[:, 1::2, None][:, None] * (self.unit * z.swapaxes(0, 1))

    def _angle_columns(self, c: PlanarBeamConfiguration, F: Array) -> Array:
        """(6, 6, n): columns phi_p, phi_q of the forces F (4, 2, end of the angle, n), zero elsewhere."""
        out = np.zeros((6, 6, *F.shape[3:]), F.dtype)
        blocks = out.reshape(2, 3, 2, 3, *F.shape[3:])
        blocks[:, 0:2, :, 2] = F[0::2]
        blocks[:, 2, :, 2] = self.length * (c.normals[:, :, None] * F[1::2]).sum(1)
        return out

    # -- limits --------------------------------------------------------------------------------------------
    def troubles(self, c: PlanarBeamConfiguration, e: Array, sigma: Array) -> list[Trouble]:
        """End rotations to the chord beyond 60 degrees (warning) and `fatal_angle`; vanishing length."""
        found = chord.short_troubles(c.l, self.length)
        cosine, sine = (c.t * c.u).sum(1), c.t[:, 1] * c.u[0] - c.t[:, 0] * c.u[1]
        for k in np.flatnonzero((cosine < np.cos(np.radians(WARN_ANGLE))).any(0)):
            angles = np.degrees(np.abs(np.arctan2(sine[:, k], cosine[:, k])))
            end, worst = int(np.argmax(angles)), float(np.max(angles))
            fatal = worst > self.fatal_angle
            found.append(
                Trouble(
                    int(k),
                    f"end {'pq'[end]} is rotated by {worst:.1f} degrees to the line between its nodes "
                    f"(limit {self.fatal_angle if fatal else WARN_ANGLE:.0f}): use more elements",
                    fatal,
                )
            )
        return found
