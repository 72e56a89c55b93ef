"""The angle measure of the spatial beam: deformations as functions of eight inner quantities (theory-beam-order4.md
section 2).

With the end orientations L_p = lam_p o r_p, L_q = lam_q o r_q (r_k: Euler parameters of the start frame at end k), the
chord d = x_q - x_p, l = |d|, and the orientation half way L_s = L_p + L_q, the inner quantities are

    y = (mu0, mu_1..3, w_1..3, l),   mu0 = L_p.L_q,  mu = p0 q - q0 p - p x q,   w = R(L_s)^T d,

and all deformations are functions of

    psi = G(mu0) mu,   t_y = 2 atan2(w_z, w_x),   t_z = -2 atan2(w_y, w_x),   l                            (2a)
    A_y = t_y - psi_x psi_z/12,   A_z = t_z + psi_x psi_y/12,   a_y = A_y/(1 + Phi_z),   a_z = A_z/(1 + Phi_y)
    M_x = psi_x + (a_y psi_z - a_z psi_y)/2,   B_y = psi_y + a_z psi_x/2,   B_z = psi_z - a_y psi_x/2
    P = (alpha psi_z b_y - beta psi_y b_z)/2,   D = 3 + (alpha psi_z^2 + beta psi_y^2)/4                   (2b)
    k = P/(D + sqrt(3 D)),   M_y = B_y - k psi_z/2,   M_z = B_z + k psi_y/2
    e1 = l - l0 + l0 [(psi_y^2 + psi_z^2)/24 + (a_y^2 + a_z^2)/40] + f1 M_x^2/(2 l0)
    e2 = l0 M_x,   e3, e4 = l0 (M_y -+ A_y)/2,   e5, e6 = l0 (M_z -+ A_z)/2

alpha, beta = EIy/GIt, EIz/GIt; b = B less its start value. Of the twist gradient A_x = P/D, eliminated, M contains the
part that leaves W = (EIy M_y^2 + EIz M_z^2)/(2 l0) the energy with A_x (section 2.2). LDEFORM: M = psi, A = t,
e1 = l - l0.

Everything is written once, for arrays and for power series (`taylor`): the latter give the second and third
derivatives, in `beam_angle_strain`. Order of the local coordinates: L_p (4), L_q (4), d (3).
"""

from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.rotations.rotation import _DIRECTOR, identity, relative_parameters
from spacar.elements.spatial.taylor import Taylor, angle, contracted, root, stacked, value_of

SERIES = 0.2  # of 1 - c: below it the power series of G, above it the closed form (relative error of both below 1e-13)


def _series_coefficients() -> Array:
    """(5, terms): G and its derivatives by c as power series in 1 - c, G = 2 sum k!/(2k+1)!! (1-c)^k."""
    terms = 18
    g = np.ones(terms + 4) * 2.0
    for k in range(1, terms + 4):
        g[k] = g[k - 1] * k / (2 * k + 1)
    rows = [g]
    for _ in range(4):
        last = rows[-1]
        rows.append(np.append(-last[1:] * np.arange(1, len(last)), 0.0))
    return np.array([row[:terms] for row in rows])


_G = _series_coefficients()


# (4, 4, 4): mu_a = L_p RELATIVE[a] L_q
RELATIVE = relative_parameters(identity(3), identity(3))[:, 0, ..., 0]


class AngleConstants(NamedTuple):
    """Constants of the beams of a group, element axis last.

    C       (2, 4, 4, n): L = C lam at p and q
    l0      (n,) undeformed length [m]
    second  (n,) 1, or 0 for LDEFORM
    f       (n,) torsion-elongation coupling f1 [m^2]
    shear   (2, n) 1/(1 + Phi_z), 1/(1 + Phi_y)
    ratio   (2, n) alpha, beta: EIy/GIt, EIz/GIt, or 0 without twist gradient
    start   (2, n) B_y, B_z at the start
    """

    C: Array
    l0: Array
    second: Array
    f: Array
    shear: Array
    ratio: Array
    start: Array


def rotation_factor(c: Array) -> Array:
    """G(c) = 2 acos(c)/sqrt(1 - c^2) and its first three derivatives, (4, n); nan for c <= -1 (a full turn)."""
    if np.iscomplexobj(c):  # the first order that a complex step needs
        G = _factor_derivatives(c.real, 5)
        return G[:4] + 1j * c.imag * G[1:]
    return _factor_derivatives(c, 4)


def _factor_derivatives(c: Array, count: int) -> Array:
    """G and its derivatives, (count, n)."""
    x = 1.0 - c
    out = np.zeros((count, *c.shape)) + _G[:count, -1].reshape(count, *(1,) * c.ndim)
    for k in range(_G.shape[1] - 2, -1, -1):
        out *= x
        out += _G[:count, k].reshape(count, *(1,) * c.ndim)
    far = np.abs(x) > SERIES
    if far.any():
        out[:, far] = _closed_factor(c[far], count)
    return out


def _closed_factor(c: Array, count: int) -> Array:
    """The derivatives of G from the closed form, continued beyond c = 1 by 2 acosh(c)/sqrt(c^2 - 1):
    (1 - c^2) G' = c G - 2, and (1 - c^2) G^(n+1) = (2n + 1) c G^(n) + n^2 G^(n-1)."""
    q = np.where(c > -1.0, 1.0 - c * c, np.nan)
    with np.errstate(invalid="ignore"):
        value = np.where(c < 1.0, np.arccos(np.clip(c, -1.0, 1.0)), np.arccosh(np.maximum(c, 1.0)))
        G = [2.0 * value / np.sqrt(np.abs(q))]
    G.append((c * G[0] - 2.0) / q)
    for n in range(1, count - 1):
        G.append(((2 * n + 1) * c * G[n] + n * n * G[n - 1]) / q)
    return np.stack(G)


class Inner(NamedTuple):
    """The inner quantities and what their gradients are made of (arrays or series)."""

    y: Any  # (8, n)
    mu_p: Any  # (4, 4, n) dmu/dL_p
    mu_q: Any  # (4, 4, n)
    w_s: Any  # (3, 4, n) dw/dL_s
    w_d: Any  # (3, 3, n)
    n: Any  # (3, n) d/l


def inner(L: Any, d: Any) -> Inner:
    """The inner quantities at L (2, 4, n) and d (3, n)."""
    p, q = L[0], L[1]
    mu_p, mu_q = contracted("aij,j...->ai...", RELATIVE, q), contracted("aij,i...->aj...", RELATIVE, p)
    mu = contracted("ai...,i...->a...", mu_p, p)
    s = p + q
    Ks = contracted("mjki,k...->mji...", _DIRECTOR, s)
    w_s = contracted("mji...,m...->ij...", Ks, d)
    w_d = contracted("mji...,j...->im...", Ks, 0.5 * s)
    w = contracted("im...,m...->i...", w_d, d)
    l = root(contracted("i...,i...->...", d, d))
    return Inner(stacked([*(mu[a] for a in range(4)), *(w[a] for a in range(3)), l]), mu_p, mu_q, w_s, w_d, d / l)


def inner_rows(c: Inner) -> Any:
    """dy by the local coordinates, (8, 11, n)."""
    if not isinstance(c.y, Taylor):
        out = np.zeros((8, 11, *c.y.shape[1:]), c.w_s.dtype)
        out[0:4, 0:4], out[0:4, 4:8] = c.mu_p, c.mu_q
        out[4:7, 0:4] = out[4:7, 4:8] = c.w_s
        out[4:7, 8:] = c.w_d
        out[7, 8:] = c.n
        return out
    parts = zip(*(part.c for part in c), strict=True)
    return Taylor([inner_rows(Inner(*part)) for part in parts])


class Outer(NamedTuple):
    """Functions of y (arrays or series), by the names of the formulas above."""

    psi: Any  # (3, n)
    Ay: Any
    Az: Any
    ay: Any
    az: Any
    Mx: Any
    By: Any
    Bz: Any
    P: Any
    D: Any

    @property
    def bent(self) -> Any:
        """Shortening by bending, by the length."""
        psi, ay, az = self.psi, self.ay, self.az
        return (psi[1] * psi[1] + psi[2] * psi[2]) / 24.0 + (ay * ay + az * az) / 40.0


def outer(p: AngleConstants, y: Any, G: Any) -> Outer:
    """The quantities (2a), (2b) at y (8, n) and G (n,)."""
    psi = y[1:4] * G
    x, yy, z = psi[0], psi[1], psi[2]
    Ay = 2.0 * angle(y[6], y[4]) - x * z * (p.second / 12.0)
    Az = -2.0 * angle(y[5], y[4]) + x * yy * (p.second / 12.0)
    ay, az = Ay * p.shear[0], Az * p.shear[1]
    half = 0.5 * p.second
    Mx = x + (ay * z - az * yy) * half
    By, Bz = yy + az * x * half, z - ay * x * half
    P = z * (By - p.start[0]) * (0.5 * p.ratio[0]) - yy * (Bz - p.start[1]) * (0.5 * p.ratio[1])
    D = 3.0 + z * z * (0.25 * p.ratio[0]) + yy * yy * (0.25 * p.ratio[1])
    return Outer(psi, Ay, Az, ay, az, Mx, By, Bz, P, D)


def deformations(p: AngleConstants, y: Any, G: Any) -> Any:
    """e (6, n) at y (8, n) and G (n,)."""
    o = outer(p, y, G)
    k = o.P / (o.D + root(3.0 * o.D))
    My, Mz = o.By - 0.5 * (k * o.psi[2]), o.Bz + 0.5 * (k * o.psi[1])
    e1 = y[7] - p.l0 + o.bent * (p.l0 * p.second) + o.Mx * o.Mx * (p.f * p.second / (2.0 * p.l0))
    return stacked([e1, o.Mx * p.l0, *of_ends(My, o.Ay, Mz, o.Az, 0.5 * p.l0)])


def of_ends(My: Any, Ay: Any, Mz: Any, Az: Any, half: Array) -> list[Any]:
    """Bending at p and q about y and z of its mean and its antisymmetric part, with half the length."""
    return [(My - Ay) * half, (My + Ay) * half, (Mz - Az) * half, (Mz + Az) * half]


def outer_rows(p: AngleConstants, o: Outer, size: int) -> tuple[list[Any], list[Array]]:
    """Derivatives of psi_y, psi_z and of A_y, A_z, a_y, a_z, M_x, B_y, B_z by psi, theta_y, theta_z, rows of this size;
    the unit rows behind the first five."""
    x, yy, z = o.psi[0], o.psi[1], o.psi[2]
    dx, dy, dz, dty, dtz, *rest = identity(size, value_of(x).ndim)
    twelfth, half = p.second / 12.0, 0.5 * p.second
    dAy, dAz = dty - (dx * z + dz * x) * twelfth, dtz + (dx * yy + dy * x) * twelfth
    day, daz = dAy * p.shear[0], dAz * p.shear[1]
    dMx = dx + (day * z + dz * o.ay - daz * yy - dy * o.az) * half
    dBy, dBz = dy + (daz * x + dx * o.az) * half, dz - (day * x + dx * o.ay) * half
    return [dy, dz, dAy, dAz, day, daz, dMx, dBy, dBz], rest


def outer_gradient(p: AngleConstants, y: Any, G: Any) -> Any:
    """de by psi, theta_y, theta_z, (6, 5, n), of y (8, n) and G (n,)."""
    o = outer(p, y, G)
    yy, z = o.psi[1], o.psi[2]
    (dy, dz, dAy, dAz, day, daz, dMx, dBy, dBz), _ = outer_rows(p, o, 5)
    a, b = 0.5 * p.ratio
    dP = (dBy * z + dz * (o.By - p.start[0])) * a - (dBz * yy + dy * (o.Bz - p.start[1])) * b
    dD = dz * (z * a) + dy * (yy * b)
    r = root(3.0 / o.D)
    h = 1.0 / (o.D * (1.0 + r))
    k = o.P * h
    dk = dP * h - dD * (k * h * (1.0 + 0.5 * r))
    dMy, dMz = dBy - (dk * z + dz * k) * 0.5, dBz + (dk * yy + dy * k) * 0.5
    by_l0 = p.l0 * p.second
    de1 = (dy * yy + dz * z) * (by_l0 / 12.0) + (day * o.ay + daz * o.az) * (by_l0 / 20.0)
    de1 = de1 + dMx * (o.Mx * (p.f * p.second / p.l0))
    return stacked([de1, dMx * p.l0, *of_ends(dMy, dAy, dMz, dAz, 0.5 * p.l0)])


def gradient(p: AngleConstants, y: Any, G: Any, G1: Any) -> Any:
    """de/dy transposed, (8, 6, n), of y (8, n), G and its derivative (n,)."""
    return stacked(by_local(outer_gradient(p, y, G), y, G, G1))


def by_local(E: Any, y: Any, G: Any, G1: Any) -> list[Any]:
    """The eight derivatives by y, (deformations, n) each, of what has the derivatives E (deformations, 5 or more, n) by
    psi, theta_y, theta_z; l is contained in the first deformation only."""
    mu, w = y[1:4], y[4:7]
    by_y, by_z = 2.0 / (w[0] * w[0] + w[2] * w[2]), 2.0 / (w[0] * w[0] + w[1] * w[1])
    turned_y, turned_z = E[:, 3] * by_y, E[:, 4] * by_z
    stretch = np.zeros((len(value_of(E)), *value_of(y)[7].shape))
    stretch[0] = 1.0
    return [
        contracted("ei...,i...->e...", E[:, 0:3], mu * G1),
        *(E[:, i] * G for i in range(3)),
        turned_z * w[1] - turned_y * w[2],
        -turned_z * w[0],
        turned_y * w[0],
        0.0 * turned_y + stretch,
    ]
