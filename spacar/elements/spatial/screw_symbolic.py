"""SCREW in SymPy (theory-spatial.md section 7)."""

import sympy as sp

from spacar.elements.definition_symbolic import Definition
from spacar.elements.rotations.rotation_symbolic import FRAME
from spacar.elements.spatial.hinge_symbolic import hinge_strain
from spacar.elements.spatial.pinbody_symbolic import pinbody_strain


def screw_strain(x: list, p: dict) -> list:
    """theory-spatial.md section 7."""
    phi, *misaligned = hinge_strain([*x[3:7], *x[10:14]], p)
    along, *across = pinbody_strain(x[:10], p)
    return [phi, along - p["pitch"] * phi, *across, *misaligned]


def screw_turn(p: dict) -> list:
    return [2 * sp.pi, -2 * sp.pi * p["pitch"], 0, 0, 0, 0]


DEFINITIONS = (Definition("screw", 14, (*FRAME, "r0", "r1", "r2", "pitch"), screw_strain, turn=screw_turn),)
