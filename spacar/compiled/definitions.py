"""The element types in SymPy: nothing but D(x) and, for elements with mass, y(x) and the constant matrix of y.

Used to generate `kernels.c`, and in tests as an independent statement of the elements.

D(x): deformations (theory-planar.md sections 2 to 5, theory-spatial.md sections 1 to 6). y(x): the quantities in
which the kinetic energy is 1/2 y'^T C y' with a constant C, so that M = Y^T C Y and h = Y^T C y''(x + s v) with Y
= dy/dx.
Everything else (V, H(v,v), M, h) follows by differentiation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from spacar.compiled.element_parameters import LEFT


@dataclass(frozen=True)
class Definition:
    """One element type: number of coordinates, names of its parameters, D and (y, C) as functions of both."""

    name: str
    n_coordinates: int
    parameters: tuple[str, ...]
    strain: Callable[[list[sp.Symbol], dict[str, sp.Symbol]], list[sp.Expr]]
    line: Callable[[list[sp.Symbol], dict[str, sp.Symbol]], tuple[list[sp.Expr], sp.Matrix]] | None = None
    inertia: Callable[[list, list, dict], tuple[sp.Matrix, list]] | None = None  # M, h where no y exists
    guard: Callable[[list, dict], list] | None = None  # all beyond GUARD: surely in the range of the theory
    turns: int = -1  # row of D that is an angle: given within one turn, whole turns are counted along the motion


CUBIC = sp.Matrix([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])


def rotated(lam: list, c: list) -> list:
    """R(lambda) c in the homogeneous quadratic form."""
    l0, l = lam[0], sp.Matrix(lam[1:])
    v = sp.Matrix(c)
    return list((l0**2 - l.dot(l)) * v + 2 * l.dot(v) * l + 2 * l0 * l.cross(v))


def relative(p: list, q: list, axis: list) -> sp.Expr:
    """mu_axis of the rotation of q relative to p."""
    lp, lq, a = sp.Matrix(p[1:]), sp.Matrix(q[1:]), sp.Matrix(axis)
    return p[0] * a.dot(lq) - q[0] * a.dot(lp) - lp.cross(lq).dot(a)


def dot(a: list, b: list) -> sp.Expr:
    return sum(x * y for x, y in zip(a, b, strict=True))


def plbeam_strain(x: list, p: dict) -> list:
    dx, dy = x[3] - x[0], x[4] - x[1]
    l = sp.sqrt(dx**2 + dy**2)
    e2 = p["l0"] * (sp.sin(x[2] + p["beta"]) * dx - sp.cos(x[2] + p["beta"]) * dy) / l
    e3 = -p["l0"] * (sp.sin(x[5] + p["beta"]) * dx - sp.cos(x[5] + p["beta"]) * dy) / l
    return [l - p["l0"] + p["A"] * (e2**2 + e3**2) + p["B"] * e2 * e3, e2, e3]


def plbeam_angle_strain(x: list, p: dict) -> list:
    """theory-beam-order4.md section 1."""
    dx, dy = x[3] - x[0], x[4] - x[1]
    c, s = ([f(a + p["beta"]) for a in (x[2], x[5])] for f in (sp.cos, sp.sin))
    a_p, a_q = (sp.atan2(s[k] * dx - c[k] * dy, c[k] * dx + s[k] * dy) for k in (0, 1))
    e2, e3 = p["l0"] * a_p, -p["l0"] * a_q
    return [sp.sqrt(dx**2 + dy**2) - p["l0"] + p["A"] * (e2**2 + e3**2) + p["B"] * e2 * e3, e2, e3]


def plbeam_line(x: list, p: dict) -> tuple[list, sp.Matrix]:
    y = [x[0], x[1], p["l0"] * sp.cos(x[2] + p["beta"]), p["l0"] * sp.sin(x[2] + p["beta"]),
         x[3], x[4], p["l0"] * sp.cos(x[5] + p["beta"]), p["l0"] * sp.sin(x[5] + p["beta"]), x[2], x[5]]  # fmt: skip
    C = sp.zeros(10, 10)
    C[:8, :8] = p["unit"] * sp.kronecker_product(CUBIC, sp.eye(2))
    C[8, 8] = C[9, 9] = p["lumped"]
    return y, C


def plbeam_guard(x: list, p: dict) -> list:
    """Cosines between ends and chord; length."""
    dx, dy = x[3] - x[0], x[4] - x[1]
    l = sp.sqrt(dx**2 + dy**2)
    ends = [(sp.cos(a + p["beta"]) * dx + sp.sin(a + p["beta"]) * dy) / l for a in (x[2], x[5])]
    return [*ends, l / p["l0"] + LEFT]


def truss_guard(x: list, p: dict) -> list:
    """Length."""
    return [truss_strain(x, p)[0] / p["l0"] + 1 + LEFT]


def truss_strain(x: list, p: dict) -> list:
    half = len(x) // 2
    return [sp.sqrt(sum((q - a) ** 2 for a, q in zip(x[:half], x[half:], strict=True))) - p["l0"]]


def pltor_strain(x: list, p: dict) -> list:
    return [x[1] - x[0]]


def plpinbod_strain(x: list, p: dict) -> list:
    c, s, dx, dy = sp.cos(x[2]), sp.sin(x[2]), x[3] - x[0], x[4] - x[1]
    return [
        (c * p[f"a{k}"] - s * p[f"b{k}"]) * dx + (s * p[f"a{k}"] + c * p[f"b{k}"]) * dy - p[f"d{k}"] for k in (0, 1)
    ]


FRAME = tuple(f"{axis}{k}" for axis in ("fx", "fy", "fz") for k in range(3))


def frame(p: dict) -> tuple[list, list, list]:
    return tuple([p[f"{axis}{k}"] for k in range(3)] for axis in ("fx", "fy", "fz"))  # type: ignore[return-value]


def beam_raw(x: list, p: dict) -> list:
    """The deformations of a spatial beam without second order terms."""
    xp, lp, xq, lq = x[:3], x[3:7], x[7:10], x[10:14]
    ex, ey, ez = frame(p)
    d = [b - a for a, b in zip(xp, xq, strict=True)]
    l = sp.sqrt(dot(d, d))
    n = [c / l for c in d]
    l0 = p["l0"]
    e1 = l - l0
    e2 = 2 * l0 * dot(lp, lq) * relative(lp, lq, ex)
    e3, e4 = -l0 * dot(n, rotated(lp, ez)), l0 * dot(n, rotated(lq, ez))
    e5, e6 = l0 * dot(n, rotated(lp, ey)), -l0 * dot(n, rotated(lq, ey))
    return [e1, e2, e3, e4, e5, e6]


def beam_strain(x: list, p: dict) -> list:
    e1, e2, e3, e4, e5, e6 = beam_raw(x, p)
    k, l0 = p["second"], p["l0"]
    return [
        e1 + k * ((2 * (e3**2 + e4**2 + e5**2 + e6**2) + e3 * e4 + e5 * e6) / (30 * l0) + p["f"] * e2**2 / (2 * l0**3)),
        e2 + k * (e4 * e5 - e3 * e6) / l0,
        e3 + k * e2 * (e5 + e6) / (6 * l0),
        e4 - k * e2 * (e5 + e6) / (6 * l0),
        e5 - k * e2 * (e3 + e4) / (6 * l0),
        e6 + k * e2 * (e3 + e4) / (6 * l0),
    ]


class turn2(sp.Function):
    """Second derivative of `turn0`."""


class turn1(sp.Function):
    """Derivative of `turn0`."""

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        return turn2(self.args[0])


class turn0(sp.Function):
    """G(c) = 2 acos(c)/sqrt(1 - c^2), regular at c = 1 (lanes.c)."""

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        return turn1(self.args[0])


def beam_angle_strain(x: list, p: dict) -> list:
    """theory-beam-order4.md section 2."""
    lp, lq = x[3:7], x[10:14]
    d = [b - a for a, b in zip(x[:3], x[7:10], strict=True)]
    G = turn0(dot(lp, lq))
    psi = [G * relative(lp, lq, axis) for axis in frame(p)]
    middle = [a + b for a, b in zip(lp, lq, strict=True)]
    w = [dot(d, rotated(middle, axis)) for axis in frame(p)]
    l0, k = p["l0"], p["second"]
    Ay = 2 * sp.atan2(w[2], w[0]) - k * psi[0] * psi[2] / 12
    Az = -2 * sp.atan2(w[1], w[0]) + k * psi[0] * psi[1] / 12
    ay, az = Ay * p["sz"], Az * p["sy"]
    Mx = psi[0] + k * (ay * psi[2] - az * psi[1]) / 2
    By, Bz = psi[1] + k * az * psi[0] / 2, psi[2] - k * ay * psi[0] / 2
    P = (p["alpha"] * psi[2] * By - p["beta"] * psi[1] * Bz) / 2
    D = 3 + (p["alpha"] * psi[2] ** 2 + p["beta"] * psi[1] ** 2) / 4
    twist = P / (D + sp.sqrt(3 * D))
    My, Mz = By - twist * psi[2] / 2, Bz + twist * psi[1] / 2
    bent = (psi[1] ** 2 + psi[2] ** 2) / 24 + (ay**2 + az**2) / 40
    e1 = sp.sqrt(dot(d, d)) - l0 + k * (l0 * bent + p["f"] * Mx**2 / (2 * l0))
    return [e1, l0 * Mx, l0 * (My - Ay) / 2, l0 * (My + Ay) / 2, l0 * (Mz - Az) / 2, l0 * (Mz + Az) / 2]


def beam_angle_guard(x: list, p: dict) -> list:
    """Cosines of half the rotation of the ends to each other, and of the chord to the orientation half way; length."""
    lp, lq = x[3:7], x[10:14]
    d = [b - a for a, b in zip(x[:3], x[7:10], strict=True)]
    middle = [a + b for a, b in zip(lp, lq, strict=True)]
    l = sp.sqrt(dot(d, d))
    along = dot(d, rotated(middle, frame(p)[0])) / (l * dot(middle, middle))
    return [dot(lp, lq), along, l / p["l0"] + LEFT]


def beam_line(x: list, p: dict) -> tuple[list, sp.Matrix]:
    ex, _, _ = frame(p)
    tangents = [[p["l0"] * c for c in rotated(lam, ex)] for lam in (x[3:7], x[10:14])]
    return [*x[:3], *tangents[0], *x[7:10], *tangents[1]], p["unit"] * sp.kronecker_product(CUBIC, sp.eye(3))


def beam_guard(x: list, p: dict) -> list:
    """Cosines between end tangents and chord, of the twist; length."""
    xp, lp, xq, lq = x[:3], x[3:7], x[7:10], x[10:14]
    d = [b - a for a, b in zip(xp, xq, strict=True)]
    l = sp.sqrt(dot(d, d))
    axes = [[rotated(lam, c) for c in frame(p)] for lam in (lp, lq)]
    twist = (dot(axes[0][1], axes[1][1]) + dot(axes[0][2], axes[1][2])) / 2
    return [dot(d, axes[0][0]) / l, dot(d, axes[1][0]) / l, twist, l / p["l0"] + LEFT]


def without_warping(x: list) -> list:
    """The coordinates of a beam among those of a beam with warping."""
    return [*x[:7], *x[8:15]]


def beamw_strain(x: list, p: dict) -> list:
    """theory-warping.md section 3."""
    raw = beam_raw(without_warping(x), p)
    k, l0 = p["second"], p["l0"]
    e1, e2, e3, e4, e5, e6 = raw
    e7, e8 = e2 - l0**2 * x[7], l0**2 * x[15] - e2
    bent = (2 * (e3**2 + e4**2 + e5**2 + e6**2) + e3 * e4 + e5 * e6) / (30 * l0)
    twisted = e2**2 + (2 * e7**2 + e7 * e8 + 2 * e8**2) / 15
    both = (e4 * e5 - e3 * e6) / l0
    y, z = e5 + e6, e3 + e4
    return [
        e1 + k * (bent + p["f"] * twisted / (2 * l0**3)),
        e2 + k * both,
        e3 + k * (e2 * y / 6 - e5 * e7 / 10 - e8 * y / 30) / l0,
        e4 + k * (-e2 * y / 6 - e6 * e8 / 10 - e7 * y / 30) / l0,
        e5 + k * (-e2 * z / 6 + e3 * e7 / 10 + e8 * z / 30) / l0,
        e6 + k * (e2 * z / 6 + e4 * e8 / 10 + e7 * z / 30) / l0,
        e7 + k * both,
        e8 - k * both,
    ]


def beamw_line(x: list, p: dict) -> tuple[list, sp.Matrix]:
    return beam_line(without_warping(x), p)


def beamw_guard(x: list, p: dict) -> list:
    return beam_guard(without_warping(x), p)


def hinge_strain(x: list, p: dict) -> list:
    lp, lq = x[:4], x[4:]
    ex, ey, ez = frame(p)
    m0, m1, m2, m3 = dot(lp, lq), relative(lp, lq, ex), relative(lp, lq, ey), relative(lp, lq, ez)
    return [2 * sp.atan2(m1, m0), 2 * (m0 * m2 - m1 * m3), 2 * (m0 * m3 + m1 * m2)]


def pinbody_strain(x: list, p: dict) -> list:
    d = [b - a for a, b in zip(x[:3], x[7:], strict=True)]
    return [dot(rotated(x[3:7], c), d) - p[f"r{k}"] for k, c in enumerate(frame(p))]


def normalization_strain(x: list, p: dict) -> list:
    return [dot(x, x) - 1]


def body_inertia(x: list, v: list, p: dict) -> tuple[sp.Matrix, list]:
    """M = 4 L^T J L, h = 8 L'^T J L v with L(lambda) = [-l, lambda0 I - l~] (theory-spatial.md section 1)."""
    J = sp.Matrix(3, 3, lambda i, j: p[f"J{min(i, j)}{max(i, j)}"])
    L, rate = body_map(x), body_map(v)
    return 4 * L.T * J * L, list(8 * rate.T * J * L * sp.Matrix(v))


def body_map(lam: list) -> sp.Matrix:
    """L(lambda), (3, 4)."""
    a, b, c, d = lam
    return sp.Matrix([[-b, a, d, -c], [-c, -d, a, b], [-d, c, -b, a]])


DEFINITIONS = (
    Definition("plbeam", 6, ("l0", "beta", "A", "B", "unit", "lumped"), plbeam_strain, plbeam_line, guard=plbeam_guard),
    Definition(
        "plbeam_angle",
        6,
        ("l0", "beta", "A", "B", "unit", "lumped"),
        plbeam_angle_strain,
        plbeam_line,
        guard=plbeam_guard,
    ),
    Definition("pltruss", 4, ("l0",), truss_strain, guard=truss_guard),
    Definition("pltor", 2, (), pltor_strain),
    Definition("plpinbod", 5, ("a0", "b0", "d0", "a1", "b1", "d1"), plpinbod_strain),
    Definition("beam", 14, ("l0", *FRAME, "f", "second", "unit"), beam_strain, beam_line, guard=beam_guard),
    Definition(
        "beam_angle",
        14,
        ("l0", *FRAME, "f", "second", "unit", "sz", "sy", "alpha", "beta"),
        beam_angle_strain,
        beam_line,
        guard=beam_angle_guard,
    ),
    Definition("beamw", 16, ("l0", *FRAME, "f", "second", "unit"), beamw_strain, beamw_line, guard=beamw_guard),
    Definition("truss", 6, ("l0",), truss_strain, guard=truss_guard),
    Definition("hinge", 8, FRAME, hinge_strain, turns=0),
    Definition("pinbody", 10, (*FRAME, "r0", "r1", "r2"), pinbody_strain),
    Definition("normalization", 4, (), normalization_strain),
    Definition("body", 4, ("J00", "J01", "J02", "J11", "J12", "J22"), lambda x, p: [], inertia=body_inertia),
)
