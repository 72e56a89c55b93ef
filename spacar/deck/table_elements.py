"""The element types: nodes, deformation modes, geometry. Their keywords in the kinematics block follow from them.

Facts: reference/input-language.md sections 3 and 4.1, codes: reference/files.md section 3, wheels and screw:
reference/theory-spatial.md sections 7 and 8.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from spacar.deck.table_types import (
    Block,
    ElementType,
    Keyword,
    Parameter,
    form,
    integer,
    real,
    span,
    vector,
)

P, O, W = "position", "orientation", "warping"
_BEAM = ((P, O, P, O), ("p position node", "p orientation node", "q position node", "q orientation node"))
_WARPED = (
    (P, O, W, P, O, W),
    (
        "p position node",
        "p orientation node",
        "p warping node",
        "q position node",
        "q orientation node",
        "q warping node",
    ),
)
_BAR = ((P, P), ("p position node", "q position node"))
_JOINT = ((O, O), ("p orientation node", "q orientation node"))
_BODY = ((P, O, P), ("p position node", "p orientation node", "q position node"))
_WHEEL = (
    (P, O, P),
    ("p position node (wheel centre)", "p orientation node (wheel)", "q position node (contact point)"),
)
_PLWHEEL = (
    (P, O, O),
    ("position node (wheel centre)", "orientation node (yaw angle)", "orientation node (spin angle)"),
)

_BEND2 = (("elongation", "m"), ("bending at p", "m"), ("bending at q", "m"))
_BEND3 = (
    ("elongation", "m"),
    ("torsion", "m"),
    ("bending at p in the x'z' plane", "m"),
    ("bending at q in the x'z' plane", "m"),
    ("bending at p in the x'y' plane", "m"),
    ("bending at q in the x'y' plane", "m"),
)
_WARPING = (("warping at p", "m"), ("warping at q", "m"))
_STRETCH = (("elongation", "m"),)
_TURN = (("relative rotation", "rad"),)
_MISALIGNED = (("misalignment about y'", "rad"), ("misalignment about z'", "rad"))
_BODY_MODES = tuple((f"displacement along direction {i}", "m") for i in (1, 2, 3))
_ROLL = (
    ("radial", "m"),
    ("axial", "m"),
    ("height of the contact point above the ground", "m"),
    ("position of the contact point along the ground", "m"),
    ("longitudinal slip", "m^2"),
    ("lateral slip", "m^2"),
)
_SCREW_MODES = (
    ("rotation about the screw axis", "rad"),
    ("displacement along the axis less pitch times rotation", "m"),
    ("displacement along y'", "m"),
    ("displacement along z'", "m"),
    *_MISALIGNED,
)
_Y3 = vector("initial direction of the principal y' axis,", "x y z")
_X3 = vector("initial direction of the x' axis (axis of rotation),", "x y z")
_SPIN3 = vector("initial direction of the spin axis,", "x y z")
_COUPLING = real("torsion-elongation coupling f", "m^2", 0.0)
_RADII = (
    real("base circle radius of the first pulley", "m"),
    real("base circle radius of the second pulley", "m"),
)
_TANGENTS = (
    real("initial rotation of the tangent at p from the line pq", "rad", 0.0),
    real("initial rotation of the tangent at q from the line pq", "rad", 0.0),
)

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
_K9 = (
    "Positive radius: the belt runs on the left of that pulley when looking from p to q; opposite "
    "signs: crossed belt or gears."
)
_K10 = (
    "A warping node has one coordinate, the twist rate of the section in rad/m, zero at the start. It is a dynamic degree "
    "of freedom unless FIX (clamped section), INPUTX or KINX says otherwise; modes 7 and 8 are always calculable. Fix "
    "both warping nodes of a rigid one."
)
_SIX = "With six arguments the sixth is the coupling f and the direction is the default one."


def _type(
    keyword: str,
    title: str,
    code: int,
    planar: bool,
    nodes: tuple[tuple[str, ...], tuple[str, ...]],
    modes: tuple[tuple[str, str], ...],
    geometry: tuple[Parameter, ...] = (),
    counts: tuple[int, ...] = (),
    **facts: Any,
) -> ElementType:
    """A row; `facts` are the other fields of `ElementType`."""
    roles, names = nodes
    counts = counts or (1 + len(roles) + len(geometry),)
    return ElementType(keyword, title, code, planar, roles, names, modes, geometry, counts, **facts)


_ALL = (
    _type(
        "PLBEAM",
        "planar beam",
        5,
        True,
        _BEAM,
        _BEND2,
        stiffness=(2, 3, 3),
        length="always",
        family="plbeam:PlanarBeam",
        shape="beam",
        coefficients="planar beam",
        mass="planar beam",
        statements=("LDEFORM",),
        axial=True,
        quadratic=True,
        split=((2, 3),),
    ),
    _type(
        "PLTRUSS",
        "planar truss",
        7,
        True,
        _BAR,
        _STRETCH,
        stiffness=(2,),
        length="always",
        family="pltruss:PlanarTruss",
        shape="truss",
        coefficients="stretch",
        mass="bar",
        axial=True,
    ),
    _type(
        "PLTOR",
        "planar hinge",
        6,
        True,
        _JOINT,
        _TURN,
        stiffness=(2,),
        family="pltor:PlanarHinge",
        shape="hinge",
    ),
    _type(
        "PLBEAR",
        "planar bearing",
        8,
        True,
        _BEAM,
        (*_BODY_MODES[:2], *_TURN),
        notes=("Not supported, as in the original program.",),
    ),
    _type(
        "PLPINBOD",
        "planar pinbody",
        10,
        True,
        _BODY,
        _BODY_MODES[:2],
        stiffness=(2, 3),
        family="plpinbod:PlanarPinbody",
        shape="body",
        statements=("ORPINBOD", "DRPINBOD"),
    ),
    _type(
        "PLRBEAM",
        "planar rigid beam",
        10,
        True,
        _BODY,
        _BODY_MODES[:2],
        stiffness=(2, 3),
        length="always",
        family="plpinbod:PlanarPinbody",
        shape="body",
        mass="planar beam",
        statements=("ORPINBOD", "DRPINBOD"),
    ),
    _type(
        "PLWHEEL",
        "planar wheel",
        12,
        True,
        _PLWHEEL,
        (("longitudinal slip", "m"), ("lateral slip", "m")),
        (real("wheel radius", "m"), *vector("initial direction of the spin axis,", "x y")),
        slips=(0, 1),
        direction=(6, 2, "axis"),
        family="plwheel:PlanarWheel",
        shape="planar wheel",
    ),
    _type(
        "PLBELT",
        "planar belt",
        11,
        True,
        _BEAM,
        (("elongation of the belt", "m"),),
        _RADII,
        stiffness=(2,),
        length="always",
        notes=(_K9,),
        family="plbelt:PlanarBelt",
        shape="belt",
        coefficients="stretch",
        mass="belt",
    ),
    _type(
        "PLTUBE",
        "planar tube",
        15,
        True,
        _BEAM,
        _BEND2,
        _TANGENTS,
        span(5, 7),
        stiffness=(2, 3, 3),
        length="always",
        family="pltube:PlanarTube",
        shape="beam",
        coefficients="planar beam",
        mass="planar tube",
        statements=("DELOMF",),
        axial=True,
        quadratic=True,
    ),
    _type(
        "BEAM",
        "spatial beam",
        1,
        False,
        _BEAM,
        _BEND3,
        (*_Y3, _COUPLING),
        (5, 6, 8, 9),
        stiffness=(2, 3, 4, 4, 5, 5),
        length="always",
        direction=(6, 3, "plane"),
        notes=(_K1, _K2, _SIX),
        family="beam:SpatialBeam",
        shape="beam",
        coefficients="spatial beam",
        mass="spatial beam",
        statements=("LDEFORM",),
        axial=True,
        quadratic=True,
        split=((3, 4), (5, 6)),
    ),
    _type(
        "BEAMW",
        "spatial beam with warping",
        18,
        False,
        _WARPED,
        (*_BEND3, *_WARPING),
        (*_Y3, _COUPLING),
        (10, 11),
        stiffness=(2, 3, 4, 4, 5, 5, 8, 8),
        length="always",
        direction=(8, 3, "plane"),
        notes=(_K1, _K2, _K10),
        family="beam_warping:BeamWithWarping",
        shape="beam",
        coefficients="spatial beam with warping",
        mass="spatial beam with warping",
        statements=("LDEFORM",),
        axial=True,
        quadratic=True,
        split=((3, 4), (5, 6)),
        released=(7, 8),
    ),
    _type(
        "TRUSS",
        "spatial truss",
        2,
        False,
        _BAR,
        _STRETCH,
        stiffness=(2,),
        length="always",
        family="truss:SpatialTruss",
        shape="truss",
        coefficients="stretch",
        mass="bar",
        axial=True,
    ),
    _type(
        "HINGE",
        "spatial hinge",
        3,
        False,
        _JOINT,
        (*_TURN, *_MISALIGNED),
        _X3,
        stiffness=(2, 3, 4),
        direction=(4, 3, "axis"),
        notes=(_K3,),
        family="hinge:SpatialHinge",
        shape="hinge",
    ),
    _type(
        "PINBODY",
        "spatial pinbody",
        9,
        False,
        _BODY,
        _BODY_MODES,
        _Y3,
        (4, 7),
        stiffness=(2, 3, 4),
        length="with direction",
        direction=(5, 3, "plane"),
        notes=(_K4,),
        family="pinbody:SpatialPinbody",
        shape="body",
        statements=("ORPINBOD", "DRPINBOD"),
    ),
    _type(
        "RBEAM",
        "spatial rigid beam",
        9,
        False,
        _BODY,
        _BODY_MODES,
        _Y3,
        (4, 7),
        stiffness=(2, 3, 4),
        length="always",
        direction=(5, 3, "plane"),
        notes=(_K1,),
        family="pinbody:SpatialPinbody",
        shape="body",
        mass="spatial beam",
        statements=("ORPINBOD", "DRPINBOD"),
    ),
    _type(
        "WHEEL",
        "disk wheel",
        13,
        False,
        _WHEEL,
        _ROLL,
        _SPIN3,
        slips=(4, 5),
        stiffness=(2, 3, 4, 5, 6, 7),
        length="always",
        direction=(5, 3, "spin"),
        notes=("The radius is the initial distance between p and q.",),
        family="wheel:DiskWheel",
        shape="wheel",
        normal_mode=3,
    ),
    _type(
        "TWHEEL",
        "torus wheel",
        14,
        False,
        _WHEEL,
        _ROLL,
        (real("radius in the equatorial plane", "m"), real("transverse (tread) radius", "m"), *_SPIN3),
        slips=(4, 5),
        stiffness=(2, 3, 4, 5, 6, 7),
        length="always",
        direction=(7, 3, "spin"),
        family="wheel:TorusWheel",
        shape="wheel",
        normal_mode=3,
    ),
    _type(
        "TUBE",
        "spatial tube",
        16,
        False,
        _BEAM,
        _BEND3,
        (*_Y3, _COUPLING),
        (5, 6, 8, 9),
        stiffness=(2, 3, 4, 4, 5, 5),
        length="always",
        direction=(6, 3, "plane"),
        notes=(_K1, _K2, _SIX),
        family="tube:SpatialTube",
        shape="beam",
        coefficients="spatial beam",
        mass="spatial tube",
        statements=("ORTUBE", "DELOMF"),
        axial=True,
        quadratic=True,
    ),
    _type(
        "SCREW",
        "screw",
        17,
        False,
        _BEAM,
        _SCREW_MODES,
        (*_X3, real("pitch, displacement per radian", "m/rad")),
        stiffness=(2, 3, 4, 5, 6, 7),
        direction=(6, 3, "axis"),
        notes=(_K3,),
        family="screw:Screw",
        shape="screw",
    ),
)

ELEMENT_TYPES: dict[str, ElementType] = {t.keyword: t for t in _ALL}


def types_that(fit: Callable[[ElementType], bool]) -> str:
    """The keywords of the supported types that fit, for `types` of a form."""
    return " ".join(t.keyword for t in _ALL if t.supported and fit(t))


def types_with(statement: str, planar: bool | None = None) -> str:
    """Those that a statement for some types only applies to; of one space, or of both."""
    return types_that(lambda t: statement in t.statements and planar in (None, t.planar))


def _statement(t: ElementType) -> Keyword:
    head = (
        integer("element number"),
        *(integer(n, f"{role} node") for n, role in zip(t.node_names, t.nodes, strict=True)),
    )
    space = "planar" if t.planar else "spatial"
    counts = tuple(n for n in t.counts if n != 6) if t.geometry[-1:] == (_COUPLING,) else t.counts
    variants = [form(head + t.geometry, *counts, space=space)]
    if counts != t.counts:
        variants.append(form((*head, _COUPLING), 6, space=space))
    modes = "; ".join(f"{i} {name} [{unit}]" for i, (name, unit) in enumerate(t.modes, 1))
    notes = (f"Deformation modes: {modes}.", *t.notes)
    return Keyword(t.keyword, Block.KINEMATICS, f"{t.title} element", tuple(variants), notes=notes)


KEYWORDS = tuple(_statement(t) for t in _ALL)
