"""The spatial element types: nodes, deformation modes, geometry (reference/input-language.md sections 3 and 4.1).

Codes: reference/files.md section 3, wheels and screw: reference/theory-spatial.md sections 7 and 8.
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
    W,
    real,
    vector,
)

_WHEEL = (
    (P, O, P), ("p position node (wheel centre)", "p orientation node (wheel)", "q position node (contact point)"),
)  # fmt: skip
_WARPED_NODES = (
    (P, O, W, P, O, W),
    (
        "p position node", "p orientation node", "p warping node", "q position node", "q orientation node",
        "q warping node",
    ),
)  # fmt: skip
_BEND3 = (
    ("elongation", "m"), ("torsion", "m"), ("bending at p in the x'z' plane", "m"),
    ("bending at q in the x'z' plane", "m"), ("bending at p in the x'y' plane", "m"),
    ("bending at q in the x'y' plane", "m"),
)  # fmt: skip
_WARPING = (("warping at p", "m"), ("warping at q", "m"))
_MISALIGNED = (("misalignment about y'", "rad"), ("misalignment about z'", "rad"))
_ROLL = (
    ("radial", "m"), ("axial", "m"), ("height of the contact point above the ground", "m"),
    ("position of the contact point along the ground", "m"), ("longitudinal slip", "m^2"), ("lateral slip", "m^2"),
)  # fmt: skip
_SCREW_MODES = (
    ("rotation about the screw axis", "rad"), ("displacement along the axis less pitch times rotation", "m"),
    ("displacement along y'", "m"), ("displacement along z'", "m"), *_MISALIGNED,
)  # fmt: skip
_Y3 = vector("initial direction of the principal y' axis,", "x y z")
_X3 = vector("initial direction of the x' axis (axis of rotation),", "x y z")
_SPIN3 = vector("initial direction of the spin axis,", "x y z")
COUPLING = real("torsion-elongation coupling f", "m^2", 0.0)
_K1 = (
    "The direction lies in the local x'y' plane; default: the standard basis vector that makes the largest angle "
    "with the axis pq, of equals the one with the highest index. Local x' runs from p to q, z' = x' times y'."
)
_K2 = (
    "An axially unloaded beam with specific twist a shortens by f a^2/2 per length; thin-walled open "
    "section: (Iy + Iz)/A."
)
_K3 = (
    "Local y' is the cross product of x' with the standard basis vector that makes the largest angle with x' (of "
    "equals the one with the highest index)."
)
_K4 = (
    "Without direction the measuring directions start parallel to the global axes; with it x' is the line pq and the "
    "vector lies in the x'y' plane. ORPINBOD overrides."
)
_K10 = (
    "A warping node has one coordinate, the twist rate of the section in rad/m, zero at the start. It is a dynamic "
    "degree of freedom unless FIX (clamped section), INPUTX or KINX says otherwise; modes 7 and 8 are always "
    "calculable. Fix both warping nodes of a rigid one."
)
_SIX = "With six arguments the sixth is the coupling f and the direction is the default one."

SPATIAL = (
    ElementType(
        "BEAM", "spatial beam", 1, False, *BEAM_NODES, _BEND3, (*_Y3, COUPLING), (5, 6, 8, 9),
        stiffness=(2, 3, 4, 4, 5, 5), length="always", direction=(6, 3, "plane"), notes=(_K1, _K2, _SIX),
        family="spatial.beam:SpatialBeam", angle_family="spatial.beam_angle:SpatialAngleBeam", shape="beam",
        coefficients="spatial beam", mass="spatial beam", statements=("LDEFORM", "ADEFORM"), axial=True, quadratic=True,
        split=((3, 4), (5, 6)), counterpart="PLBEAM",
    ),
    ElementType(
        "BEAMW", "spatial beam with warping", 18, False, *_WARPED_NODES, (*_BEND3, *_WARPING), (*_Y3, COUPLING),
        (10, 11), stiffness=(2, 3, 4, 4, 5, 5, 8, 8), length="always", direction=(8, 3, "plane"),
        notes=(_K1, _K2, _K10), family="spatial.beam_warping:BeamWithWarping",
        angle_family="spatial.beam_warping_angle:AngleBeamWithWarping", shape="beam",
        coefficients="spatial beam with warping",
        mass="spatial beam with warping", statements=("LDEFORM", "ADEFORM"), axial=True, quadratic=True,
        split=((3, 4), (5, 6)), released=(7, 8),
    ),
    ElementType(
        "TRUSS", "spatial truss", 2, False, *BAR_NODES, STRETCH, stiffness=(2,), length="always",
        family="spatial.truss:SpatialTruss", shape="truss", coefficients="stretch", mass="bar", axial=True,
        counterpart="PLTRUSS",
    ),
    ElementType(
        "HINGE", "spatial hinge", 3, False, *JOINT_NODES, (*TURN, *_MISALIGNED), _X3, stiffness=(2, 3, 4),
        direction=(4, 3, "axis"), notes=(_K3,), family="spatial.hinge:SpatialHinge", shape="hinge",
        counterpart="PLTOR",
    ),
    ElementType(
        "PINBODY", "spatial pinbody", 9, False, *BODY_NODES, BODY_MODES, _Y3, (4, 7), stiffness=(2, 3, 4),
        length="with direction", direction=(5, 3, "plane"), notes=(_K4,), family="spatial.pinbody:SpatialPinbody",
        shape="body",
        statements=("ORPINBOD", "DRPINBOD"),
    ),
    ElementType(
        "RBEAM", "spatial rigid beam", 9, False, *BODY_NODES, BODY_MODES, _Y3, (4, 7), stiffness=(2, 3, 4),
        length="always", direction=(5, 3, "plane"), notes=(_K1,), family="spatial.pinbody:SpatialPinbody", shape="body",
        mass="spatial beam", statements=("ORPINBOD", "DRPINBOD"), counterpart="PLRBEAM",
    ),
    ElementType(
        "WHEEL", "disk wheel", 13, False, *_WHEEL, _ROLL, _SPIN3, slips=(4, 5), stiffness=(2, 3, 4, 5, 6, 7),
        length="always", direction=(5, 3, "spin"), notes=("The radius is the initial distance between p and q.",),
        family="spatial.wheel:DiskWheel", shape="wheel", normal_mode=3,
    ),
    ElementType(
        "TWHEEL", "torus wheel", 14, False, *_WHEEL, _ROLL,
        (real("radius in the equatorial plane", "m"), real("transverse (tread) radius", "m"), *_SPIN3), slips=(4, 5),
        stiffness=(2, 3, 4, 5, 6, 7), length="always", direction=(7, 3, "spin"), family="spatial.wheel:TorusWheel",
        shape="wheel", normal_mode=3,
    ),
    ElementType(
        "TUBE", "spatial tube", 16, False, *BEAM_NODES, _BEND3, (*_Y3, COUPLING), (5, 6, 8, 9),
        stiffness=(2, 3, 4, 4, 5, 5), length="always", direction=(6, 3, "plane"), notes=(_K1, _K2, _SIX),
        family="spatial.tube:SpatialTube", angle_family="spatial.beam_angle:SpatialAngleTube", shape="beam",
        coefficients="spatial beam", mass="spatial tube", statements=("ORTUBE", "DELOMF", "ADEFORM"), axial=True,
        quadratic=True,
    ),
    ElementType(
        "SCREW", "screw", 17, False, *BEAM_NODES, _SCREW_MODES, (*_X3, real("pitch, displacement per radian", "m/rad")),
        stiffness=(2, 3, 4, 5, 6, 7), direction=(6, 3, "axis"), notes=(_K3,), family="spatial.screw:Screw",
        shape="screw",
    ),
)  # fmt: skip
