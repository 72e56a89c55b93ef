"""PLBEAM in SymPy (theory-planar.md section 3; its angle measure in theory-beam-order4.md section 1).

Local coordinates z are the chord x_q - x_p and the directions of the ends.
"""

import sympy as sp

from spacar.elements.definition_symbolic import LEFT, Definition, length

CUBIC = sp.Matrix([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
ROTARY = sp.Matrix([[4, -1, -3], [-1, 4, -3], [-3, -3, 36]]) / 30
BEAM = ("l0", "beta_p", "beta_q", "A", "B", "s0", "s1", "s2", "unit", "lumped")
ANGLE = (*BEAM[:-1], "rotary")


def plbeam_local(x: list, p: dict) -> list:
    return [x[3] - x[0], x[4] - x[1], x[2] + p["beta_p"], x[5] + p["beta_q"]]


def plbeam_bent(l: sp.Expr, e2: sp.Expr, e3: sp.Expr, p: dict) -> list:
    e1 = l - p["l0"] + p["A"] * (e2**2 + e3**2) + p["B"] * e2 * e3
    return [e - p[f"s{k}"] for k, e in enumerate((e1, e2, e3))]


def plbeam_strain(z: list, p: dict) -> list:
    dx, dy, *ends = z
    l = length([dx, dy])
    bent = [p["l0"] * (sp.sin(a) * dx - sp.cos(a) * dy) / l for a in ends]
    return plbeam_bent(l, bent[0], -bent[1], p)


def plbeam_angle_strain(z: list, p: dict) -> list:
    """theory-beam-order4.md section 1."""
    dx, dy, *ends = z
    turned = [sp.atan2(sp.sin(a) * dx - sp.cos(a) * dy, sp.cos(a) * dx + sp.sin(a) * dy) for a in ends]
    return plbeam_bent(length([dx, dy]), p["l0"] * turned[0], -p["l0"] * turned[1], p)


def plbeam_ends(x: list, p: dict) -> list:
    """Positions and tangents of the ends."""
    angles = x[2] + p["beta_p"], x[5] + p["beta_q"]
    ends = [[p["l0"] * sp.cos(a), p["l0"] * sp.sin(a)] for a in angles]
    return [x[0], x[1], *ends[0], x[3], x[4], *ends[1]]


def plbeam_line(x: list, p: dict) -> tuple[list, sp.Matrix]:
    line = p["unit"] * sp.kronecker_product(CUBIC, sp.eye(2))
    return [*plbeam_ends(x, p), x[2], x[5]], sp.diag(line, p["lumped"], p["lumped"])


def plbeam_angle_line(x: list, p: dict) -> tuple[list, sp.Matrix]:
    """Rotary inertia by the rates of the ends and of the chord (theory-beam-order4.md section 1.3)."""
    line = p["unit"] * sp.kronecker_product(CUBIC, sp.eye(2))
    chord = sp.atan2(x[4] - x[1], x[3] - x[0])
    return [*plbeam_ends(x, p), x[2], x[5], chord], sp.diag(line, p["rotary"] * ROTARY)


def plbeam_guard(z: list, p: dict) -> list:
    """Cosines between ends and chord; length."""
    dx, dy, *ends = z
    l = length([dx, dy])
    return [*((sp.cos(a) * dx + sp.sin(a) * dy) / l for a in ends), l / p["l0"] + LEFT]


DEFINITIONS = (
    Definition("plbeam", 6, BEAM, plbeam_strain, plbeam_line, guard=plbeam_guard, local=plbeam_local),
    Definition(
        "plbeam_angle", 6, ANGLE, plbeam_angle_strain, plbeam_angle_line, guard=plbeam_guard, local=plbeam_local
    ),
)
