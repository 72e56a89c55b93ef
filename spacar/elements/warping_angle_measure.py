"""The angle measure of the spatial beam with warping (theory-beam-order4.md section 2.8).

The twist rate is the parabola through its nodal values w_p, w_q with the mean M_x/l0. So the gradient of the twist and
its curvature are coordinates, and nothing inside the element is unknown. With A, B, M_x, a of `angle_measure` (2a, 2b)

    A_x = l0 (w_q - w_p)/6,   c = l0 (w_p + w_q)/2 - M_x
    M_y = B_y - A_x psi_z/2 - c a_z/10,   M_z = B_z + A_x psi_y/2 + c a_y/10
    A'_y = A_y - 3 A_x a_z/10 - c psi_z/30,   A'_z = A_z + 3 A_x a_y/10 + c psi_y/30
    e1 = l - l0 + l0 [(psi_y^2 + psi_z^2)/24 + (a_y^2 + a_z^2)/40] + f1 (M_x^2 + 3 A_x^2 + c^2/5)/(2 l0)
    e2 = l0 M_x,   e3, e4 = l0 (M_y -+ A'_y)/2,   e5, e6 = l0 (M_z -+ A'_z)/2
    e7 = e2 - l0^2 w_p,   e8 = l0^2 w_q - e2

To second order in the rotations these are the formulas of theory-warping.md section 3. LDEFORM: M = psi, A' = t,
e1 = l - l0.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from spacar.elements.angle_measure import AngleConstants, Outer, by_local, outer
from spacar.elements.taylor import Taylor, stacked


def _warped(p: AngleConstants, y: Any, G: Any, w: Any) -> tuple[Outer, Any, Any]:
    """Quantities of the beam, A_x and c."""
    o = outer(p, y, G)
    return o, (w[1] - w[0]) * (p.l0 / 6.0), (w[0] + w[1]) * (p.l0 / 2.0) - o.Mx


def deformations(p: AngleConstants, y: Any, G: Any, w: Any) -> Any:
    """e (8, n) at y (8, n), G (n,) and w (2, n)."""
    o, A, c = _warped(p, y, G, w)
    k, half, square = p.second, 0.5 * p.l0, p.l0**2
    My, Mz = o.By - (A * o.psi[2] * 0.5 + c * o.az * 0.1) * k, o.Bz + (A * o.psi[1] * 0.5 + c * o.ay * 0.1) * k
    Ay, Az = o.Ay - (A * o.az * 0.3 + c * o.psi[2] / 30.0) * k, o.Az + (A * o.ay * 0.3 + c * o.psi[1] / 30.0) * k
    bent = (o.psi[1] * o.psi[1] + o.psi[2] * o.psi[2]) / 24.0 + (o.ay * o.ay + o.az * o.az) / 40.0
    twisted = o.Mx * o.Mx + A * A * 3.0 + c * c * 0.2
    e1 = y[7] - p.l0 + bent * (p.l0 * k) + twisted * (p.f * k / (2.0 * p.l0))
    e2 = o.Mx * p.l0
    bending = [(My - Ay) * half, (My + Ay) * half, (Mz - Az) * half, (Mz + Az) * half]
    return stacked([e1, e2, *bending, e2 - w[0] * square, w[1] * square - e2])


def gradient(p: AngleConstants, y: Any, G: Any, G1: Any, w: Any) -> Any:
    """de/d(y, w) transposed, (10, 8, n), of y (8, n), G and its derivative (n,), w (2, n)."""
    o, A, c = _warped(p, y, G, w)
    x, yy, z = o.psi[0], o.psi[1], o.psi[2]
    value = (y.c[0] if isinstance(y, Taylor) else y)[7]
    dx, dy, dz, dty, dtz, dwp, dwq = np.eye(7).reshape(7, 7, *(1,) * value.ndim)
    k = p.second
    twelfth, half, l, square = k / 12.0, 0.5 * k, 0.5 * p.l0, p.l0**2
    dAy, dAz = dty - (dx * z + dz * x) * twelfth, dtz + (dx * yy + dy * x) * twelfth
    day, daz = dAy * p.shear[0], dAz * p.shear[1]
    dMx = dx + (day * z + dz * o.ay - daz * yy - dy * o.az) * half
    dBy, dBz = dy + (daz * x + dx * o.az) * half, dz - (day * x + dx * o.ay) * half
    dA, dc = (dwq - dwp) * (p.l0 / 6.0), -dMx + (dwp + dwq) * (p.l0 / 2.0)
    dMy = dBy - ((dA * z + A * dz) * 0.5 + (dc * o.az + c * daz) * 0.1) * k
    dMz = dBz + ((dA * yy + A * dy) * 0.5 + (dc * o.ay + c * day) * 0.1) * k
    dAy = dAy - ((dA * o.az + A * daz) * 0.3 + (dc * z + c * dz) / 30.0) * k
    dAz = dAz + ((dA * o.ay + A * day) * 0.3 + (dc * yy + c * dy) / 30.0) * k
    de1 = ((dy * yy + dz * z) / 12.0 + (day * o.ay + daz * o.az) / 20.0) * (p.l0 * k)
    de1 = de1 + (dMx * o.Mx + dA * A * 3.0 + dc * c * 0.2) * (p.f * k / p.l0)
    de2 = dMx * p.l0
    bending = [(dMy - dAy) * l, (dMy + dAy) * l, (dMz - dAz) * l, (dMz + dAz) * l]
    E = stacked([de1, de2, *bending, de2 - dwp * square, -de2 + dwq * square])
    return stacked([*by_local(E, y, G, G1, np.zeros((8, *value.shape))), E[:, 5], E[:, 6]])
