"""WHEEL and TWHEEL in SymPy (theory-spatial.md section 8)."""

import sympy as sp

from spacar.elements.definition_symbolic import LEFT, Definition, dot, length
from spacar.elements.rotations.rotation_symbolic import cross, global_map, numbers, rotated

UP = [0, 0, 1]


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
    slipping = [c - p["rho"] * s for c, s in zip(v[7:], cross(w, UP), strict=True)]
    return [dot(t, along), dot(cross(UP, t), slipping)]


def wheel_guard(x: list, p: dict) -> list:
    """Height of the contact point over the ground; sine of the angle between spin axis and vertical."""
    a, _ = wheel_vectors(x, p)
    return [1 - (x[9] / p["height"]) ** 2, sp.sqrt(a[0] ** 2 + a[1] ** 2) + LEFT]


DEFINITIONS = (
    Definition(
        "wheel", 10, ("a0", "a1", "a2", "radius", "rho", "height"), wheel_strain, guard=wheel_guard, slips=wheel_slips
    ),
)
