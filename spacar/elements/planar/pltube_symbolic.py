"""PLTUBE in SymPy: the beam of `plbeam_symbolic` with a fluid (theory-planar.md section 8)."""

import sympy as sp

from spacar.elements.definition_symbolic import Definition
from spacar.elements.planar.plbeam_symbolic import (
    ANGLE,
    BEAM,
    plbeam_angle_line,
    plbeam_angle_strain,
    plbeam_guard,
    plbeam_line,
    plbeam_local,
    plbeam_strain,
)

STRETCH = sp.Matrix([[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]) / 30
TRANSPORT = sp.Matrix([[-30, 6, 30, -6], [-6, 0, 6, -1], [-30, -6, 30, 6], [6, 1, -6, 0]]) / 60
FLOW = ("flow", "flow_p", "flow_q", "thrust", "thrust_p", "thrust_q")


def flow_matrices(p: dict) -> tuple[sp.Matrix, sp.Matrix]:
    """D and A of the force D y' + A y of a fluid on the cubic line: mass flow, thrust; both of jets at p and q."""
    D, A = (TRANSPORT - TRANSPORT.T) * p["flow"], -STRETCH * p["thrust"]
    D[0, 0] -= p["flow_p"]
    A[0, 1] -= p["thrust_p"]
    D[2, 2] += p["flow_q"]
    A[2, 3] += p["thrust_q"]
    return D, A


DEFINITIONS = (
    Definition(
        "pltube", 6, (*BEAM, *FLOW), plbeam_strain, plbeam_line,
        guard=plbeam_guard, local=plbeam_local, flow=flow_matrices,
    ),
    Definition(
        "pltube_angle", 6, (*ANGLE, *FLOW), plbeam_angle_strain, plbeam_angle_line,
        guard=plbeam_guard, local=plbeam_local, flow=flow_matrices,
    ),
)  # fmt: skip
