"""PLPINBOD and PLRBEAM in SymPy (theory-planar.md section 5)."""

import sympy as sp

from spacar.elements.definition_symbolic import Definition


def plpinbod_strain(x: list, p: dict) -> list:
    c, s, dx, dy = sp.cos(x[2]), sp.sin(x[2]), x[3] - x[0], x[4] - x[1]
    return [
        (c * p[f"a{k}"] - s * p[f"b{k}"]) * dx + (s * p[f"a{k}"] + c * p[f"b{k}"]) * dy - p[f"d{k}"] for k in (0, 1)
    ]


DEFINITIONS = (Definition("plpinbod", 5, ("a0", "b0", "d0", "a1", "b1", "d1"), plpinbod_strain),)
