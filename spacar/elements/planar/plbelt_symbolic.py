"""PLBELT in SymPy."""

import sympy as sp

from spacar.elements.definition_symbolic import LEFT, Definition, dot


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


DEFINITIONS = (
    Definition(
        "plbelt", 6, ("l0", "r_p", "r_q", "u0", "u1", "unit", *(f"wound_{k}" for k in range(6))), plbelt_strain,
        inertia=plbelt_inertia, guard=plbelt_guard, turn=plbelt_turn, angle=plbelt_angle,
    ),
)  # fmt: skip
