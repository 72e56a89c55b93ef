"""Deformations of the spatial beam with warping in the angle measure by its sixteen coordinates, and derivatives.

What belongs to the beam comes from `beam_angle_strain`. Coordinates
x_p (3), lambda_p (4), w_p, x_q (3), lambda_q (4), w_q.

The angle measure (theory-beam-order4.md section 2.8): the twist rate is the parabola through its nodal values w_p, w_q
with the mean M_x/l0. So the gradient of the twist and its curvature are coordinates, and nothing inside the element is
unknown. With A, B, M_x, a of `angle_measure` (2a, 2b)

    A_x = l0 (w_q - w_p)/6,   c = l0 (w_p + w_q)/2 - M_x
    M_y = B_y - A_x psi_z/2 - c a_z/10,   M_z = B_z + A_x psi_y/2 + c a_y/10
    A'_y = A_y - 3 A_x a_z/10 - c psi_z/30,   A'_z = A_z + 3 A_x a_y/10 + c psi_y/30
    e1 = l - l0 + l0 [(psi_y^2 + psi_z^2)/24 + (a_y^2 + a_z^2)/40] + f1 (M_x^2 + 3 A_x^2 + c^2/5)/(2 l0)
    e2 = l0 M_x,   e3, e4 = l0 (M_y -+ A'_y)/2,   e5, e6 = l0 (M_z -+ A'_z)/2
    e7 = e2 - l0^2 w_p,   e8 = l0^2 w_q - e2

To second order in the rotations these are the formulas of theory-warping.md section 3. LDEFORM: M = psi, A' = t,
e1 = l - l0.
"""

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.rotations.rotation import identity
from spacar.elements.spatial import beam_angle_strain as beam_of
from spacar.elements.spatial.angle_measure import (
    AngleConstants,
    Outer,
    by_local,
    inner_rows,
    of_ends,
    outer,
    outer_rows,
)
from spacar.elements.spatial.taylor import Taylor, composed, contracted, stacked
from spacar.elements.spatial.warping_strain import BEAM, RATES


def _warped(p: AngleConstants, y: Any, G: Any, w: Any) -> tuple[Outer, Any, Any]:
    """Quantities of the beam, A_x and c."""
    o = outer(p, y, G)
    return o, (w[1] - w[0]) * (p.l0 / 6.0), (w[0] + w[1]) * (p.l0 / 2.0) - o.Mx


def deformations(p: AngleConstants, y: Any, G: Any, w: Any) -> Any:
    """e (8, n) at y (8, n), G (n,) and w (2, n)."""
    o, A, c = _warped(p, y, G, w)
    k, square = p.second, p.l0**2
    My, Mz = o.By - (A * o.psi[2] * 0.5 + c * o.az * 0.1) * k, o.Bz + (A * o.psi[1] * 0.5 + c * o.ay * 0.1) * k
    Ay, Az = o.Ay - (A * o.az * 0.3 + c * o.psi[2] / 30.0) * k, o.Az + (A * o.ay * 0.3 + c * o.psi[1] / 30.0) * k
    twisted = o.Mx * o.Mx + A * A * 3.0 + c * c * 0.2
    e1 = y[7] - p.l0 + o.bent * (p.l0 * k) + twisted * (p.f * k / (2.0 * p.l0))
    e2 = o.Mx * p.l0
    bending = of_ends(My, Ay, Mz, Az, 0.5 * p.l0)
    return stacked([e1, e2, *bending, e2 - w[0] * square, w[1] * square - e2])


def gradient(p: AngleConstants, y: Any, G: Any, G1: Any, w: Any) -> Any:
    """de/d(y, w) transposed, (10, 8, n), of y (8, n), G and its derivative (n,), w (2, n)."""
    o, A, c = _warped(p, y, G, w)
    yy, z, k, square = o.psi[1], o.psi[2], p.second, p.l0**2
    (dy, dz, dAy, dAz, day, daz, dMx, dBy, dBz), (dwp, dwq) = outer_rows(p, o, 7)
    dA, dc = (dwq - dwp) * (p.l0 / 6.0), -dMx + (dwp + dwq) * (p.l0 / 2.0)
    dMy = dBy - ((dA * z + A * dz) * 0.5 + (dc * o.az + c * daz) * 0.1) * k
    dMz = dBz + ((dA * yy + A * dy) * 0.5 + (dc * o.ay + c * day) * 0.1) * k
    dAy = dAy - ((dA * o.az + A * daz) * 0.3 + (dc * z + c * dz) / 30.0) * k
    dAz = dAz + ((dA * o.ay + A * day) * 0.3 + (dc * yy + c * dy) / 30.0) * k
    de1 = ((dy * yy + dz * z) / 12.0 + (day * o.ay + daz * o.az) / 20.0) * (p.l0 * k)
    de1 = de1 + (dMx * o.Mx + dA * A * 3.0 + dc * c * 0.2) * (p.f * k / p.l0)
    de2 = dMx * p.l0
    bending = of_ends(dMy, dAy, dMz, dAz, 0.5 * p.l0)
    E = stacked([de1, de2, *bending, de2 - dwp * square, -de2 + dwq * square])
    return stacked([*by_local(E, y, G, G1), E[:, 5], E[:, 6]])


class WarpingAngleState(NamedTuple):
    """What later calls at the same x reuse; `beam.E` (10, 8, n) holds the derivatives of all deformations."""

    beam: beam_of.AngleState
    w: Array  # (2, n)


def state(p: AngleConstants, x: Array) -> WarpingAngleState:
    """The state at x (16, n)."""
    w = x[RATES]
    return WarpingAngleState(beam_of.state(p, x[BEAM], partial(gradient, w=w)), w)


def values(c: WarpingAngleState) -> Array:
    """e (8, n)."""
    b = c.beam
    return np.asarray(deformations(b.p, b.inner.y, b.G[0], c.w))


def _put(c: WarpingAngleState, of_beam: Array, of_w: Array, out: Array) -> None:
    """Write rows by the local coordinates, (8, 11, n), and by w, (2, 8, n), as rows by x to out (8, 16, n)."""
    V = np.empty((8, 14, *of_beam.shape[2:]), of_beam.dtype)
    beam_of.rows(c.beam, of_beam, V)
    out[:, BEAM] = V
    out[:, RATES] = of_w.swapaxes(0, 1)


def first(c: WarpingAngleState, out: Array) -> None:
    """V (8, 16, n)."""
    E = c.beam.E
    _put(c, np.einsum("ye...,yj...->ej...", E[:8], inner_rows(c.beam.inner)), E[8:], out)


def _rates(c: WarpingAngleState, v: Array, terms: int) -> Any:
    """w as a series along v (16, n)."""
    return Taylor([c.w, v[RATES], *[np.zeros_like(c.w)] * (terms - 2)])


def second_rate(c: WarpingAngleState, v: Array) -> Array:
    """H(v, v) (8, n)."""
    along, G, _ = beam_of.along_line(c.beam, v[BEAM], 3)
    return np.asarray(2.0 * deformations(c.beam.p, along.y, G, _rates(c, v, 3)).c[2])


def derivative_of_rows(c: WarpingAngleState, v: Array, order: int, out: Array) -> None:
    """d^order V/ds^order along v, order 1 (H1) or 2 (T), (8, 16, n)."""
    along, G, G1 = beam_of.along_line(c.beam, v[BEAM], order + 1)
    E = gradient(c.beam.p, along.y, G, G1, _rates(c, v, order + 1))
    local = contracted("ye...,yj...->ej...", E[:8], inner_rows(along))
    _put(c, order * local.c[order], order * E.c[order][8:], out)


def hessian(c: WarpingAngleState, sigma: Array, out: Array) -> None:
    """sum_k sigma_k d2(e_k) (16, 16, n)."""
    b, tail = c.beam, sigma.shape[1:]
    directions = identity(10, len(tail))
    y, w = Taylor([b.inner.y[:, None], directions[:8]]), Taylor([c.w[:, None], directions[8:]])
    G = b.G[:, None]
    rates = gradient(b.p, y, composed(y[0], *G[:2]), composed(y[0], *G[1:3]), w).c[1]
    curvature = np.einsum("yed...,e...->yd...", rates, sigma)
    force = np.einsum("ye...,e...->y...", b.E[:8], sigma)
    H = np.empty((14, 14, *tail), curvature.dtype)
    beam_of.write_hessian(b, curvature[:8, :8], force, H)
    out[np.ix_(BEAM, BEAM)] = H
    local = np.einsum("yd...,yj...->dj...", curvature[:8, 8:], inner_rows(b.inner))
    mixed = np.empty((2, 14, *tail), curvature.dtype)
    beam_of.rows(b, local, mixed)
    out[np.ix_(RATES, BEAM)] = mixed
    out[np.ix_(BEAM, RATES)] = mixed.swapaxes(0, 1)
    out[np.ix_(RATES, RATES)] = curvature[8:, 8:]
