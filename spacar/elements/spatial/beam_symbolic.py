"""BEAM in SymPy (theory-spatial.md section 3; its angle measure in theory-beam-order4.md section 2).

Local coordinates z = (x_q - x_p, lambda_p, lambda_q, lambda_q o r), where r turns the start frame at p into that at q:
of beams, whose frames are the same, it is exactly one.
"""

import math

import sympy as sp

from spacar.elements.definition_symbolic import LEFT, Definition, dot, length
from spacar.elements.family import GUARD
from spacar.elements.planar.plbeam_symbolic import CUBIC
from spacar.elements.rotations.rotation_symbolic import FRAME, frame, numbers, relative, rotated
from spacar.elements.spatial.beam import LARGE_ANGLE

BENT = math.cos(LARGE_ANGLE) + 0.003 - GUARD  # cosines of beams are above GUARD within LARGE_ANGLE
# start frames at p and q, Euler parameters of the second to the first
ENDS = (*FRAME, *(name.replace("f", "g") for name in FRAME), "r0", "r1", "r2", "r3")
START = tuple(f"s{k}" for k in range(6))  # deformations at the start
BEAM = ("l0", *ENDS, "f", "second", "unit", "sz", "sy")
ANGLE = ("alpha", "beta", "by", "bz")


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


DEFINITIONS = (
    Definition("beam", 14, (*BEAM, *START), beam_strain, beam_line, guard=beam_guard, local=beam_local),
    Definition(
        "beam_angle", 14, (*BEAM, *START, *ANGLE), beam_angle_strain, beam_line,
        guard=beam_angle_guard, local=beam_local,
    ),
)  # fmt: skip
