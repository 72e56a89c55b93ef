"""Normalization and rotary inertia of spatial orientation nodes in SymPy (theory-spatial.md section 1)."""

import sympy as sp

from spacar.elements.definition_symbolic import Definition, dot
from spacar.elements.rotations.rotation_symbolic import body_map


def normalization_strain(x: list, p: dict) -> list:
    return [dot(x, x) - 1]


def body_inertia(x: list, v: list, p: dict) -> tuple[sp.Matrix, list]:
    """M = 4 L^T J L, h = 8 L'^T J L v with L(lambda) = [-l, lambda0 I - l~] (theory-spatial.md section 1)."""
    J = sp.Matrix(3, 3, lambda i, j: p[f"J{min(i, j)}{max(i, j)}"])
    L, rate = body_map(x), body_map(v)
    return 4 * L.T * J * L, list(8 * rate.T * J * L * sp.Matrix(v))


DEFINITIONS = (
    Definition("normalization", 4, (), normalization_strain),
    Definition("body", 4, ("J00", "J01", "J02", "J11", "J12", "J22"), inertia=body_inertia),
)
