"""The planar element types: nodes, deformation modes, geometry (reference/input-language.md sections 3 and 4.1).

Codes: reference/files.md section 3.
"""

from __future__ import annotations

from spacar.deck.table_types import (
    BAR_NODES,
    BEAM_NODES,
    BODY_MODES,
    BODY_NODES,
    JOINT_NODES,
    STRETCH,
    TURN,
    ElementType,
    O,
    P,
    real,
    span,
    vector,
)

_PLWHEEL = (
    (P, O, O), ("position node (wheel centre)", "orientation node (yaw angle)", "orientation node (spin angle)"),
)  # fmt: skip
_BEND2 = (("elongation", "m"), ("bending at p", "m"), ("bending at q", "m"))
_RADII = (real("base circle radius of the first pulley", "m"), real("base circle radius of the second pulley", "m"))
_TANGENTS = (
    real("initial rotation of the tangent at p from the line pq", "rad", 0.0),
    real("initial rotation of the tangent at q from the line pq", "rad", 0.0),
)
_K9 = (
    "Positive radius: the belt runs on the left of that pulley when looking from p to q; opposite "
    "signs: crossed belt or gears."
)

PLANAR = (
    ElementType(
        "PLBEAM", "planar beam", 5, True, *BEAM_NODES, _BEND2, stiffness=(2, 3, 3), length="always",
        family="planar.plbeam:PlanarBeam", angle_family="planar.plbeam_angle:PlanarAngleBeam", shape="beam",
        coefficients="planar beam", mass="planar beam", statements=("LDEFORM", "ADEFORM"), axial=True, quadratic=True,
        split=((2, 3),),
    ),
    ElementType(
        "PLTRUSS", "planar truss", 7, True, *BAR_NODES, STRETCH, stiffness=(2,), length="always",
        family="planar.pltruss:PlanarTruss", shape="truss", coefficients="stretch", mass="bar", axial=True,
    ),
    ElementType(
        "PLTOR", "planar hinge", 6, True, *JOINT_NODES, TURN, stiffness=(2,), family="planar.pltor:PlanarHinge",
        shape="hinge",
    ),
    ElementType(
        "PLBEAR", "planar bearing", 8, True, *BEAM_NODES, (*BODY_MODES[:2], *TURN),
        notes=("Not supported, as in the original program.",),
    ),
    ElementType(
        "PLPINBOD", "planar pinbody", 10, True, *BODY_NODES, BODY_MODES[:2], stiffness=(2, 3),
        family="planar.plpinbod:PlanarPinbody", shape="body", statements=("ORPINBOD", "DRPINBOD"),
    ),
    ElementType(
        "PLRBEAM", "planar rigid beam", 10, True, *BODY_NODES, BODY_MODES[:2], stiffness=(2, 3), length="always",
        family="planar.plpinbod:PlanarPinbody", shape="body", mass="planar beam", statements=("ORPINBOD", "DRPINBOD"),
    ),
    ElementType(
        "PLWHEEL", "planar wheel", 12, True, *_PLWHEEL, (("longitudinal slip", "m"), ("lateral slip", "m")),
        (real("wheel radius", "m"), *vector("initial direction of the spin axis,", "x y")), slips=(0, 1),
        direction=(6, 2, "axis"), family="planar.plwheel:PlanarWheel", shape="planar wheel",
    ),
    ElementType(
        "PLBELT", "planar belt", 11, True, *BEAM_NODES, (("elongation of the belt", "m"),), _RADII, stiffness=(2,),
        length="always", notes=(_K9,), family="planar.plbelt:PlanarBelt", shape="belt", coefficients="stretch",
        mass="belt",
    ),
    ElementType(
        "PLTUBE", "planar tube", 15, True, *BEAM_NODES, _BEND2, _TANGENTS, span(5, 7), stiffness=(2, 3, 3),
        length="always", family="planar.pltube:PlanarTube", angle_family="planar.plbeam_angle:PlanarAngleTube",
        shape="beam",
        coefficients="planar beam", mass="planar tube", statements=("DELOMF", "ADEFORM"), axial=True, quadratic=True,
    ),
)  # fmt: skip
