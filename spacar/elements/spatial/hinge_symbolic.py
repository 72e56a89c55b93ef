"""HINGE in SymPy (theory-spatial.md section 5)."""

import sympy as sp

from spacar.elements.definition_symbolic import Definition, dot
from spacar.elements.rotations.rotation_symbolic import FRAME, frame, relative


def hinge_strain(x: list, p: dict) -> list:
    lp, lq = x[:4], x[4:]
    ex, ey, ez = frame(p)
    m0, m1, m2, m3 = dot(lp, lq), relative(lp, lq, ex), relative(lp, lq, ey), relative(lp, lq, ez)
    return [2 * sp.atan2(m1, m0), 2 * (m0 * m2 - m1 * m3), 2 * (m0 * m3 + m1 * m2)]


def hinge_turn(p: dict) -> list:
    return [2 * sp.pi, 0, 0]


DEFINITIONS = (Definition("hinge", 8, FRAME, hinge_strain, turn=hinge_turn),)
