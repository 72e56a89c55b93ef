"""PLWHEEL in SymPy."""

import sympy as sp

from spacar.elements.definition_symbolic import Definition, dot


def plwheel_slips(x: list, v: list, p: dict) -> list:
    """Longitudinal and lateral, theory-planar.md (14)."""
    a = x[2] + p["angle"]
    t = [sp.cos(a), sp.sin(a)]
    return [dot(t, v[:2]) - p["radius"] * v[3], t[0] * v[1] - t[1] * v[0]]


DEFINITIONS = (Definition("plwheel", 4, ("radius", "angle"), slips=plwheel_slips),)
