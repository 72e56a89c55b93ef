"""The planar element types in SymPy: deformations, slips and inertia (theory-planar.md sections 2 to 8).

Local coordinates z of beams are the chord x_q - x_p and the directions of the ends.
"""

from __future__ import annotations

import sympy as sp

from spacar.compiled.element_parameters import LEFT

CUBIC = sp.Matrix([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
ROTARY = sp.Matrix([[4, -1, -3], [-1, 4, -3], [-3, -3, 36]]) / 30
STRETCH = sp.Matrix([[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]) / 30
TRANSPORT = sp.Matrix([[-30, 6, 30, -6], [-6, 0, 6, -1], [-30, -6, 30, 6], [6, 1, -6, 0]]) / 60
FLOW = ("flow", "flow_p", "flow_q", "thrust", "thrust_p", "thrust_q")


def dot(a: list, b: list) -> sp.Expr:
    return sum(x * y for x, y in zip(a, b, strict=True))


def length(d: list) -> sp.Expr:
    return sp.sqrt(dot(d, d))


def half_difference(x: list) -> list:
    """Second half of a list less the first."""
    half = len(x) // 2
    return [b - a for a, b in zip(x[:half], x[half:], strict=True)]


def flow_matrices(p: dict) -> tuple[sp.Matrix, sp.Matrix]:
    """D and A of the force D y' + A y of a fluid on the cubic line: mass flow, thrust; both of jets at p and q."""
    D, A = (TRANSPORT - TRANSPORT.T) * p["flow"], -STRETCH * p["thrust"]
    D[0, 0] -= p["flow_p"]
    A[0, 1] -= p["thrust_p"]
    D[2, 2] += p["flow_q"]
    A[2, 3] += p["thrust_q"]
    return D, A


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


def truss_strain(x: list, p: dict) -> list:
    return [length(half_difference(x)) - p["l0"]]


def truss_guard(x: list, p: dict) -> list:
    """Length."""
    return [length(half_difference(x)) / p["l0"] + LEFT]


def pltor_strain(x: list, p: dict) -> list:
    return [x[1] - x[0]]


def plpinbod_strain(x: list, p: dict) -> list:
    c, s, dx, dy = sp.cos(x[2]), sp.sin(x[2]), x[3] - x[0], x[4] - x[1]
    return [
        (c * p[f"a{k}"] - s * p[f"b{k}"]) * dx + (s * p[f"a{k}"] + c * p[f"b{k}"]) * dy - p[f"d{k}"] for k in (0, 1)
    ]


def plwheel_slips(x: list, v: list, p: dict) -> list:
    """Longitudinal and lateral, theory-planar.md (14)."""
    a = x[2] + p["angle"]
    t = [sp.cos(a), sp.sin(a)]
    return [dot(t, v[:2]) - p["radius"] * v[3], t[0] * v[1] - t[1] * v[0]]


def span(d: list, p: dict) -> tuple[sp.Expr, list]:
    """Length and direction of the straight part of a belt."""
    rho, square = p["r_p"] - p["r_q"], dot(d, d)
    l = sp.sqrt(square - rho**2)
    return l, [(l * d[0] + rho * d[1]) / square, (l * d[1] - rho * d[0]) / square]


def plbelt_strain(x: list, p: dict) -> list:
    """theory-planar.md (15)."""
    l, u = span([x[3] - x[0], x[4] - x[1]], p)
    theta = sp.atan2(p["u0"] * u[1] - p["u1"] * u[0], p["u0"] * u[0] + p["u1"] * u[1])
    return [l - p["l0"] + p["r_p"] * x[2] - p["r_q"] * x[5] - (p["r_p"] - p["r_q"]) * theta]


def plbelt_angle(x: list, e: list, p: dict) -> sp.Expr:
    """theta, on the turn of e1."""
    l, _ = span([x[3] - x[0], x[4] - x[1]], p)
    return (l - p["l0"] + p["r_p"] * x[2] - p["r_q"] * x[5] - e[0]) / (p["r_p"] - p["r_q"])


def plbelt_turn(p: dict) -> list:
    """Of theta."""
    return [-2 * sp.pi * (p["r_p"] - p["r_q"])]


def plbelt_inertia(x: list, v: list, p: dict) -> tuple[sp.Matrix, list]:
    """Lagrange's, of T = unit (|v_p|^2 + v_p.v_q + |v_q|^2) + wound masses; v_i = x_i' - r_i phi_i' u, |u| = 1."""
    U = sp.symbols("U:2", real=True)
    v_p, v_q, rim_p, rim_q = v[0:2], v[3:5], p["r_p"] * v[2], p["r_q"] * v[5]
    along_p, along_q = dot(U, v_p), dot(U, v_q)
    T = p["unit"] * (
        dot(v_p, v_p) - 2 * rim_p * along_p + rim_p**2
        + dot(v_q, v_q) - 2 * rim_q * along_q + rim_q**2
        + dot(v_p, v_q) - rim_q * along_p - rim_p * along_q + rim_p * rim_q
    )  # fmt: skip
    T += sum(p[f"wound_{k}"] * v[k] ** 2 for k in range(6)) / 2
    _, u = span([x[3] - x[0], x[4] - x[1]], p)
    by_x = sp.Matrix(u).jacobian(x)
    rate, by_u = by_x * sp.Matrix(v), sp.Matrix([T]).jacobian(U)
    momenta = sp.Matrix([T]).jacobian(v)
    h = momenta.jacobian(U) * rate - (by_u * by_x).T
    there = dict(zip(U, u, strict=True))
    return momenta.jacobian(v).subs(there), [value.subs(there) for value in h]


def plbelt_guard(x: list, p: dict) -> list:
    """Length of the span."""
    return [span([x[3] - x[0], x[4] - x[1]], p)[0] / p["l0"] + LEFT]
