"""The spatial element types in SymPy: deformations, slips and inertia (theory-spatial.md sections 1 to 10).

Beams and tubes have the local coordinates z = (x_q - x_p, lambda_p, lambda_q, lambda_q o r), where r turns the start
frame at p into that at q: of beams, whose frames are the same, it is exactly one.
"""

from __future__ import annotations

import math

import sympy as sp

from spacar.compiled.element_parameters import GUARD, LEFT
from spacar.compiled.planar_definitions import CUBIC, dot, length
from spacar.elements.beam import LARGE_ANGLE

UP = [0, 0, 1]
BENT = math.cos(LARGE_ANGLE) + 0.003 - GUARD  # cosines of beams are above GUARD within LARGE_ANGLE
FRAME = tuple(f"{axis}{k}" for axis in ("fx", "fy", "fz") for k in range(3))
# start frames at p and q, Euler parameters of the second to the first
ENDS = (*FRAME, *(name.replace("f", "g") for name in FRAME), "r0", "r1", "r2", "r3")
START = tuple(f"s{k}" for k in range(6))  # deformations at the start


def numbers(name: str, n: int, p: dict) -> list:
    return [p[f"{name}{k}"] for k in range(n)]


def frame(p: dict, name: str = "f") -> tuple[list, list, list]:
    return tuple(numbers(f"{name}{axis}", 3, p) for axis in "xyz")  # type: ignore[return-value]


def cross(a: list, b: list) -> list:
    return list(sp.Matrix(a).cross(sp.Matrix(b)))


def rotated(lam: list, c: list) -> list:
    """R(lambda) c in the homogeneous quadratic form."""
    l0, l = lam[0], sp.Matrix(lam[1:])
    v = sp.Matrix(c)
    return list((l0**2 - l.dot(l)) * v + 2 * l.dot(v) * l + 2 * l0 * l.cross(v))


def relative(p: list, q: list, axis: list) -> sp.Expr:
    """mu_axis of the rotation of q relative to p."""
    lp, lq, a = sp.Matrix(p[1:]), sp.Matrix(q[1:]), sp.Matrix(axis)
    return p[0] * a.dot(lq) - q[0] * a.dot(lp) - lp.cross(lq).dot(a)


def followed(lam: list, r: list) -> list:
    """lambda o r."""
    l, v = sp.Matrix(lam[1:]), sp.Matrix(r[1:])
    return [lam[0] * r[0] - l.dot(v), *(lam[0] * v + r[0] * l + l.cross(v))]


def beam_local(x: list, p: dict) -> list:
    d = [x[7 + k] - x[k] for k in range(3)]
    return [*d, *x[3:7], *x[10:14], *followed(x[10:14], numbers("r", 4, p))]


def beam_raw(z: list, p: dict) -> list:
    """The deformations of a spatial beam without second order terms."""
    d, lp, lq, turned = z[:3], z[3:7], z[7:11], z[11:15]
    (x_p, y_p, z_p), (_, y_q, z_q) = frame(p), frame(p, "g")
    l, l0 = length(d), p["l0"]
    n = [c / l for c in d]
    e2 = 2 * l0 * dot(lp, turned) * relative(lp, turned, x_p)
    e3, e4 = -l0 * dot(n, rotated(lp, z_p)), l0 * dot(n, rotated(lq, z_q))
    e5, e6 = l0 * dot(n, rotated(lp, y_p)), -l0 * dot(n, rotated(lq, y_q))
    return [l - l0, e2, e3, e4, e5, e6]


def from_start(e: list, p: dict) -> list:
    return [value - p[name] for value, name in zip(e, START, strict=True)]


def beam_strain(z: list, p: dict) -> list:
    e1, e2, e3, e4, e5, e6 = beam_raw(z, p)
    k, l0 = p["second"], p["l0"]
    (y, z_, left_y, left_z), bent, both = beam_second_order((e3, e4, e5, e6), p)
    e = [
        e1 + k * (bent + p["f"] * e2**2 / (2 * l0**3)),
        e2 + k * both,
        e3 + k * e2 * (z_ / 6 - left_z / 4) / l0,
        e4 - k * e2 * (z_ / 6 + left_z / 4) / l0,
        e5 - k * e2 * (y / 6 - left_y / 4) / l0,
        e6 + k * e2 * (y / 6 + left_y / 4) / l0,
    ]
    return from_start(e, p)


def beam_second_order(e: tuple, p: dict) -> tuple[tuple, sp.Expr, sp.Expr]:
    """Of the raw bending deformations: even parts about y and z, what shear takes of the odd ones; shortening; torsion
    by bending about two axes (theory-spatial.md section 3.2)."""
    e3, e4, e5, e6 = e
    l0, y, z, odd_y, odd_z = p["l0"], e3 + e4, e5 + e6, e4 - e3, e6 - e5
    a, b = p["sz"] * odd_y, p["sy"] * odd_z
    bent = (y**2 + z**2) / (24 * l0) + (a**2 + b**2) / (40 * l0)
    return (y, z, odd_y - a, odd_z - b), bent, (a * z - b * y) / (2 * l0)


class turn3(sp.Function):
    """Third derivative of `turn0`."""


class turn2(sp.Function):
    """Second derivative of `turn0`."""

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        return turn3(self.args[0])


class turn1(sp.Function):
    """Derivative of `turn0`."""

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        return turn2(self.args[0])


class turn0(sp.Function):
    """G(c) = 2 acos(c)/sqrt(1 - c^2), regular at c = 1 (lanes.c)."""

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        return turn1(self.args[0])


def beam_angles(z: list, p: dict) -> tuple[list, sp.Expr, sp.Expr]:
    """psi, A_y, A_z of theory-beam-order4.md section 2."""
    d, lp, lq = z[:3], z[3:7], z[11:15]
    G = turn0(dot(lp, lq))
    psi = [G * relative(lp, lq, axis) for axis in frame(p)]
    middle = [a + b for a, b in zip(lp, lq, strict=True)]
    w = [dot(d, rotated(middle, axis)) for axis in frame(p)]
    k = p["second"]
    Ay = 2 * sp.atan2(w[2], w[0]) - k * psi[0] * psi[2] / 12
    Az = -2 * sp.atan2(w[1], w[0]) + k * psi[0] * psi[1] / 12
    return psi, Ay, Az


def beam_angle_strain(z: list, p: dict) -> list:
    """theory-beam-order4.md section 2."""
    psi, Ay, Az = beam_angles(z, p)
    l0, k = p["l0"], p["second"]
    ay, az = Ay * p["sz"], Az * p["sy"]
    Mx = psi[0] + k * (ay * psi[2] - az * psi[1]) / 2
    By, Bz = psi[1] + k * az * psi[0] / 2, psi[2] - k * ay * psi[0] / 2
    P = (p["alpha"] * psi[2] * (By - p["by"]) - p["beta"] * psi[1] * (Bz - p["bz"])) / 2
    D = 3 + (p["alpha"] * psi[2] ** 2 + p["beta"] * psi[1] ** 2) / 4
    twist = P / (D + sp.sqrt(3 * D))
    My, Mz = By - twist * psi[2] / 2, Bz + twist * psi[1] / 2
    bent = (psi[1] ** 2 + psi[2] ** 2) / 24 + (ay**2 + az**2) / 40
    e1 = length(z[:3]) - l0 + k * (l0 * bent + p["f"] * Mx**2 / (2 * l0))
    e = [e1, l0 * Mx, l0 * (My - Ay) / 2, l0 * (My + Ay) / 2, l0 * (Mz - Az) / 2, l0 * (Mz + Az) / 2]
    return from_start(e, p)


def beam_angle_guard(z: list, p: dict) -> list:
    """Cosines of half the rotation of the ends to each other, and of the chord to the orientation half way; length."""
    d, lp, lq = z[:3], z[3:7], z[11:15]
    middle = [a + b for a, b in zip(lp, lq, strict=True)]
    l = length(d)
    along = dot(d, rotated(middle, frame(p)[0])) / (l * dot(middle, middle))
    return [dot(lp, lq), along, l / p["l0"] + LEFT]


def beam_line(x: list, p: dict) -> tuple[list, sp.Matrix]:
    tangents = rotated(x[3:7], frame(p)[0]), rotated(x[10:14], frame(p, "g")[0])
    ends = [[p["l0"] * c for c in tangent] for tangent in tangents]
    return [*x[:3], *ends[0], *x[7:10], *ends[1]], p["unit"] * sp.kronecker_product(CUBIC, sp.eye(3))


def beam_guard(z: list, p: dict) -> list:
    """Cosines between end tangents and chord, of the twist, less BENT; length."""
    d, lp, lq = z[:3], z[3:7], z[7:11]
    l = length(d)
    axes = [[rotated(lam, c) for c in frame(p, name)] for lam, name in ((lp, "f"), (lq, "g"))]
    twist = (dot(axes[0][1], axes[1][1]) + dot(axes[0][2], axes[1][2])) / 2
    cosines = dot(d, axes[0][0]) / l, dot(d, axes[1][0]) / l, twist
    return [*(c - BENT for c in cosines), l / p["l0"] + LEFT]


def without_warping(x: list) -> list:
    """The coordinates of a beam among those of a beam with warping."""
    return [*x[:7], *x[8:15]]


def beamw_local(x: list, p: dict) -> list:
    return [*beam_local(without_warping(x), p), x[7], x[15]]


def beamw_strain(z: list, p: dict) -> list:
    """theory-warping.md section 3."""
    e1, e2, e3, e4, e5, e6 = beam_raw(z[:15], p)
    k, l0 = p["second"], p["l0"]
    e7, e8 = e2 - l0**2 * z[15], l0**2 * z[16] - e2
    (z_, y, left_z, left_y), bent, both = beam_second_order((e3, e4, e5, e6), p)
    twisted = e2**2 + (2 * e7**2 + e7 * e8 + 2 * e8**2) / 15
    at_p, at_q = e2 / 4 + e7 / 20, e2 / 4 - e8 / 20
    return [
        e1 + k * (bent + p["f"] * twisted / (2 * l0**3)),
        e2 + k * both,
        e3 + k * (e2 * y / 6 - e5 * e7 / 10 - e8 * y / 30 - left_y * at_p) / l0,
        e4 + k * (-e2 * y / 6 - e6 * e8 / 10 - e7 * y / 30 - left_y * at_q) / l0,
        e5 + k * (-e2 * z_ / 6 + e3 * e7 / 10 + e8 * z_ / 30 + left_z * at_p) / l0,
        e6 + k * (e2 * z_ / 6 + e4 * e8 / 10 + e7 * z_ / 30 + left_z * at_q) / l0,
        e7 + k * both,
        e8 - k * both,
    ]


def beamw_angle_strain(z: list, p: dict) -> list:
    """theory-beam-order4.md section 2.8."""
    psi, Ay, Az = beam_angles(z[:15], p)
    l0, k, wp, wq = p["l0"], p["second"], z[15], z[16]
    ay, az = Ay * p["sz"], Az * p["sy"]
    Mx = psi[0] + k * (ay * psi[2] - az * psi[1]) / 2
    A, c = l0 * (wq - wp) / 6, l0 * (wp + wq) / 2 - Mx
    My = psi[1] + k * (az * psi[0] / 2 - A * psi[2] / 2 - c * az / 10)
    Mz = psi[2] - k * (ay * psi[0] / 2 - A * psi[1] / 2 - c * ay / 10)
    Ay, Az = Ay - k * (3 * A * az / 10 + c * psi[2] / 30), Az + k * (3 * A * ay / 10 + c * psi[1] / 30)
    bent = (psi[1] ** 2 + psi[2] ** 2) / 24 + (ay**2 + az**2) / 40
    twisted = Mx**2 + 3 * A**2 + c**2 / 5
    e1 = length(z[:3]) - l0 + k * (l0 * bent + p["f"] * twisted / (2 * l0))
    bending = [l0 * (My - Ay) / 2, l0 * (My + Ay) / 2, l0 * (Mz - Az) / 2, l0 * (Mz + Az) / 2]
    return [e1, l0 * Mx, *bending, l0 * Mx - l0**2 * wp, l0**2 * wq - l0 * Mx]


def beamw_line(x: list, p: dict) -> tuple[list, sp.Matrix]:
    return beam_line(without_warping(x), p)


def beamw_guard(z: list, p: dict) -> list:
    return beam_guard(z[:15], p)


def beamw_angle_guard(z: list, p: dict) -> list:
    return beam_angle_guard(z[:15], p)


def hinge_strain(x: list, p: dict) -> list:
    lp, lq = x[:4], x[4:]
    ex, ey, ez = frame(p)
    m0, m1, m2, m3 = dot(lp, lq), relative(lp, lq, ex), relative(lp, lq, ey), relative(lp, lq, ez)
    return [2 * sp.atan2(m1, m0), 2 * (m0 * m2 - m1 * m3), 2 * (m0 * m3 + m1 * m2)]


def hinge_turn(p: dict) -> list:
    return [2 * sp.pi, 0, 0]


def pinbody_strain(x: list, p: dict) -> list:
    d = [b - a for a, b in zip(x[:3], x[7:], strict=True)]
    return [dot(rotated(x[3:7], c), d) - p[f"r{k}"] for k, c in enumerate(frame(p))]


def screw_strain(x: list, p: dict) -> list:
    """theory-spatial.md section 7."""
    phi, *misaligned = hinge_strain([*x[3:7], *x[10:14]], p)
    along, *across = pinbody_strain(x[:10], p)
    return [phi, along - p["pitch"] * phi, *across, *misaligned]


def screw_turn(p: dict) -> list:
    return [2 * sp.pi, -2 * sp.pi * p["pitch"], 0, 0, 0, 0]


def wheel_vectors(x: list, p: dict) -> tuple[list, list]:
    """Spin axis; from the centre to the centre of the tread circle."""
    r = [q - c for c, q in zip(x[:3], x[7:], strict=True)]
    return rotated(x[3:7], numbers("a", 3, p)), [r[0], r[1], r[2] + p["rho"]]


def wheel_strain(x: list, p: dict) -> list:
    """theory-spatial.md section 8."""
    a, r = wheel_vectors(x, p)
    return [length(r) - p["radius"], dot(a, r), x[9], dot(r, cross(a, UP))]


def wheel_slips(x: list, v: list, p: dict) -> list:
    """Longitudinal, of the material point at the contact; lateral, of the contact point."""
    a, r = wheel_vectors(x, p)
    t = cross(r, a)
    d = [r[0], r[1], r[2] - p["rho"]]
    w = list(2 * global_map(x[3:7]) * sp.Matrix(v[3:7]))
    along = [c + s for c, s in zip(v[:3], cross(w, d), strict=True)]
    rhs_for_differences = [c - p["rho"] * s for c, s in zip(v[7:], cross(w, UP), strict=True)]
    return [dot(t, along), dot(cross(UP, t), rhs_for_differences)]


def wheel_guard(x: list, p: dict) -> list:
    """Height of the contact point over the ground; sine of the angle between spin axis and vertical."""
    a, _ = wheel_vectors(x, p)
    return [1 - (x[9] / p["height"]) ** 2, sp.sqrt(a[0] ** 2 + a[1] ** 2) + LEFT]


def normalization_strain(x: list, p: dict) -> list:
    return [dot(x, x) - 1]


def body_inertia(x: list, v: list, p: dict) -> tuple[sp.Matrix, list]:
    """M = 4 L^T J L, h = 8 L'^T J L v with L(lambda) = [-l, lambda0 I - l~] (theory-spatial.md section 1)."""
    J = sp.Matrix(3, 3, lambda i, j: p[f"J{min(i, j)}{max(i, j)}"])
    L, rate = body_map(x), body_map(v)
    return 4 * L.T * J * L, list(8 * rate.T * J * L * sp.Matrix(v))


def body_map(lam: list) -> sp.Matrix:
    """L(lambda), (3, 4): the angular velocity in body components is 2 L lambda'."""
    a, b, c, d = lam
    return sp.Matrix([[-b, a, d, -c], [-c, -d, a, b], [-d, c, -b, a]])


def global_map(lam: list) -> sp.Matrix:
    """The same for global components: [-l, lambda0 I + l~]."""
    a, b, c, d = lam
    return sp.Matrix([[-b, a, -d, c], [-c, d, a, -b], [-d, -c, b, a]])
