"""TUBE in SymPy: the beam of `beam_symbolic` with a fluid (theory-spatial.md section 10)."""

from spacar.elements.definition_symbolic import Definition
from spacar.elements.planar.pltube_symbolic import FLOW, flow_matrices
from spacar.elements.spatial.beam_symbolic import (
    ANGLE,
    BEAM,
    START,
    beam_angle_guard,
    beam_angle_strain,
    beam_guard,
    beam_line,
    beam_local,
    beam_strain,
)

DEFINITIONS = (
    Definition(
        "tube", 14, (*BEAM, *START, *FLOW), beam_strain, beam_line,
        guard=beam_guard, local=beam_local, flow=flow_matrices,
    ),
    Definition(
        "tube_angle", 14, (*BEAM, *START, *ANGLE, *FLOW), beam_angle_strain, beam_line,
        guard=beam_angle_guard, local=beam_local, flow=flow_matrices,
    ),
)  # fmt: skip
