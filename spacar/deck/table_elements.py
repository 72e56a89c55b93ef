"""The element types: nodes, deformation modes, geometry (reference/input-language.md sections 3 and 4.1), and their
statements in the kinematics block, which follow from them.

Codes: reference/files.md section 3, wheels and screw: reference/theory-spatial.md sections 7 and 8.
"""

from collections.abc import Callable

from spacar.deck.table_types import BlockKind, ElementType, Keyword, form, integer, real, vector

P, O, W = "position", "orientation", "warping"
BEAM_NODES = ((P, O, P, O), ("p position node", "p orientation node", "q position node", "q orientation node"))
BAR_NODES = ((P, P), ("p position node", "q position node"))
JOINT_NODES = ((O, O), ("p orientation node", "q orientation node"))
BODY_NODES = ((P, O, P), ("p position node", "p orientation node", "q position node"))
STRETCH = (("elongation", "m"),)
TURN = (("relative rotation", "rad"),)
BODY_MODES = tuple((f"displacement along direction {i}", "m") for i in (1, 2, 3))
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
        "PLBEAM", "planar beam", 5, True, *BEAM_NODES, _BEND2, length="always",
        family="planar.plbeam:PlanarBeam", angle_family="planar.plbeam_angle:PlanarAngleBeam", shape="beam",
        coefficients="planar beam", mass="planar beam", statements=("LDEFORM", "ADEFORM"), axial=True,
        split=((2, 3),),
    ),
    ElementType(
        "PLTRUSS", "planar truss", 7, True, *BAR_NODES, STRETCH, length="always",
        family="planar.pltruss:PlanarTruss", shape="truss", coefficients="stretch", mass="bar", axial=True,
    ),
    ElementType(
        "PLTOR", "planar hinge", 6, True, *JOINT_NODES, TURN, family="planar.pltor:PlanarHinge",
        shape="hinge",
    ),
    ElementType(
        "PLBEAR", "planar bearing", 8, True, *BEAM_NODES, (*BODY_MODES[:2], *TURN),
        notes=("Not supported, as in the original program.",),
    ),
    ElementType(
        "PLPINBOD", "planar pinbody", 10, True, *BODY_NODES, BODY_MODES[:2],
        family="planar.plpinbod:PlanarPinbody", shape="body", statements=("ORPINBOD", "DRPINBOD"),
    ),
    ElementType(
        "PLRBEAM", "planar rigid beam", 10, True, *BODY_NODES, BODY_MODES[:2], length="always",
        family="planar.plpinbod:PlanarPinbody", shape="body", mass="planar beam", statements=("ORPINBOD", "DRPINBOD"),
    ),
    ElementType(
        "PLWHEEL", "planar wheel", 12, True, *_PLWHEEL, (("longitudinal slip", "m"), ("lateral slip", "m")),
        (real("wheel radius", "m"), *vector("initial direction of the spin axis,", "x y")), slips=(0, 1),
        direction=(6, 2, "axis"), family="planar.plwheel:PlanarWheel", shape="planar wheel",
    ),
    ElementType(
        "PLBELT", "planar belt", 11, True, *BEAM_NODES, (("elongation of the belt", "m"),), _RADII,
        length="always", notes=(_K9,), family="planar.plbelt:PlanarBelt", shape="belt", coefficients="stretch",
        mass="belt",
    ),
    ElementType(
        "PLTUBE", "planar tube", 15, True, *BEAM_NODES, _BEND2, _TANGENTS,
        length="always", family="planar.pltube:PlanarTube", angle_family="planar.plbeam_angle:PlanarAngleTube",
        shape="beam",
        coefficients="planar beam", mass="planar tube", statements=("DELOMF", "ADEFORM"), axial=True,
    ),
)  # fmt: skip

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
        length="always", direction=(6, 3, "plane"), notes=(_K1, _K2, _SIX),
        family="spatial.beam:SpatialBeam", angle_family="spatial.beam_angle:SpatialAngleBeam", shape="beam",
        coefficients="spatial beam", mass="spatial beam", statements=("LDEFORM", "ADEFORM"), axial=True,
        split=((3, 4), (5, 6)), counterpart="PLBEAM",
    ),
    ElementType(
        "BEAMW", "spatial beam with warping", 18, False, *_WARPED_NODES, (*_BEND3, *_WARPING), (*_Y3, COUPLING),
        length="always", direction=(8, 3, "plane"),
        notes=(_K1, _K2, _K10), family="spatial.beam_warping:BeamWithWarping",
        angle_family="spatial.beam_warping_angle:AngleBeamWithWarping", shape="beam",
        coefficients="spatial beam with warping",
        mass="spatial beam with warping", statements=("LDEFORM", "ADEFORM"), axial=True,
        split=((3, 4), (5, 6)), released=(7, 8),
    ),
    ElementType(
        "TRUSS", "spatial truss", 2, False, *BAR_NODES, STRETCH, length="always",
        family="spatial.truss:SpatialTruss", shape="truss", coefficients="stretch", mass="bar", axial=True,
        counterpart="PLTRUSS",
    ),
    ElementType(
        "HINGE", "spatial hinge", 3, False, *JOINT_NODES, (*TURN, *_MISALIGNED), _X3,
        direction=(4, 3, "axis"), notes=(_K3,), family="spatial.hinge:SpatialHinge", shape="hinge",
        counterpart="PLTOR",
    ),
    ElementType(
        "PINBODY", "spatial pinbody", 9, False, *BODY_NODES, BODY_MODES, _Y3, (4, 7),
        length="with direction", direction=(5, 3, "plane"), notes=(_K4,), family="spatial.pinbody:SpatialPinbody",
        shape="body",
        statements=("ORPINBOD", "DRPINBOD"),
    ),
    ElementType(
        "RBEAM", "spatial rigid beam", 9, False, *BODY_NODES, BODY_MODES, _Y3, (4, 7),
        length="always", direction=(5, 3, "plane"), notes=(_K1,), family="spatial.pinbody:SpatialPinbody", shape="body",
        mass="spatial beam", statements=("ORPINBOD", "DRPINBOD"), counterpart="PLRBEAM",
    ),
    ElementType(
        "WHEEL", "disk wheel", 13, False, *_WHEEL, _ROLL, _SPIN3, slips=(4, 5),
        length="always", direction=(5, 3, "spin"), notes=("The radius is the initial distance between p and q.",),
        family="spatial.wheel:DiskWheel", shape="wheel", normal_mode=3,
    ),
    ElementType(
        "TWHEEL", "torus wheel", 14, False, *_WHEEL, _ROLL,
        (real("radius in the equatorial plane", "m"), real("transverse (tread) radius", "m"), *_SPIN3), slips=(4, 5),
        length="always", direction=(7, 3, "spin"), family="spatial.wheel:TorusWheel",
        shape="wheel", normal_mode=3,
    ),
    ElementType(
        "TUBE", "spatial tube", 16, False, *BEAM_NODES, _BEND3, (*_Y3, COUPLING), (5, 6, 8, 9),
        length="always", direction=(6, 3, "plane"), notes=(_K1, _K2, _SIX),
        family="spatial.tube:SpatialTube", angle_family="spatial.beam_angle:SpatialAngleTube", shape="beam",
        coefficients="spatial beam", mass="spatial tube", statements=("ORTUBE", "DELOMF", "ADEFORM"), axial=True,
    ),
    ElementType(
        "SCREW", "screw", 17, False, *BEAM_NODES, _SCREW_MODES, (*_X3, real("pitch, displacement per radian", "m/rad")),
        direction=(6, 3, "axis"), notes=(_K3,), family="spatial.screw:Screw", shape="screw",
    ),
)  # fmt: skip

_ALL = (*PLANAR, *SPATIAL)

ELEMENT_TYPES: dict[str, ElementType] = {t.keyword: t for t in _ALL}


def types_that(fit: Callable[[ElementType], bool]) -> str:
    """The keywords of the supported types that fit, for `types` of a form."""
    return " ".join(t.keyword for t in _ALL if t.supported and fit(t))


def types_with(statement: str, planar: bool | None = None) -> str:
    """Those that a statement for some types only applies to; of one space, or of both."""
    return types_that(lambda t: statement in t.statements and planar in (None, t.planar))


def _statement(t: ElementType) -> Keyword:
    head = (
        integer("element number", "element"),
        *(integer(n, f"{role} node") for n, role in zip(t.node_names, t.nodes, strict=True)),
    )
    space = "planar" if t.planar else "spatial"
    counts = tuple(n for n in t.counts if n != 6) if t.geometry[-1:] == (COUPLING,) else t.counts
    variants = [form(head + t.geometry, *counts, space=space)]
    if counts != t.counts:
        variants.append(form((*head, COUPLING), 6, space=space))
    modes = "; ".join(f"{i} {name} [{unit}]" for i, (name, unit) in enumerate(t.modes, 1))
    notes = (f"Deformation modes: {modes}.", *t.notes)
    return Keyword(t.keyword, BlockKind.KINEMATICS, f"{t.title} element", tuple(variants), notes=notes)


KEYWORDS = tuple(_statement(t) for t in _ALL)
