"""Keywords of the third block: trajectories, nominal inputs and outputs, linearization, simulation
(reference/input-language.md sections 6 to 9)."""

from dataclasses import replace

from spacar.deck.table_types import (
    COORDINATE,
    ELEMENT,
    MODE,
    NODE,
    NODE_OR_ELEMENT,
    ORIENTATION,
    POSITION,
    BlockKind,
    Keyword,
    Parameter,
    form,
    integer,
    real,
    vector,
)

_T = BlockKind.TRAJECTORY
_NUMBER = integer("trajectory number")
_INPUT = integer("input number", "input")
_OUTPUT = integer("output number", "output")
_RISE = (real("rise time", "s", 0.0), real("extreme velocity", "1/s", 0.0))
_PROFILE = "No or zero rise time: symmetric; no extreme velocity: no period of constant velocity."

PATHS = ("TROT", "TRANS", "TRCIRL", "TRE")
_TENSOR = vector("extra", "Jxx Jxy Jxz Jyy Jyz Jzz", "kg m^2", 0.0)

NO_TRAJECTORY = "mode 2 needs a third block with at least one TRAJECT"
TRAJECTORIES = (
    Keyword("TRAJECT", _T, "starts a trajectory; holds until the next TRAJECT", (form((_NUMBER,)),)),
    Keyword(
        "TROT", _T, "path: rotation of an orientation node",
        (
            form((ORIENTATION, real("total angle", "rad")), space="planar"),
            form((ORIENTATION, real("total angle", "rad"), *vector("fixed axis", "h1 h2 h3")), space="spatial"),
        ),
    ),
    Keyword(
        "TRANS", _T, "path: straight line of a position node",
        (
            form((POSITION, *vector("end position", "x1 x2", "m")), space="planar", components=True),
            form((POSITION, *vector("end position", "x1 x2 x3", "m")), space="spatial"),
        ),
    ),
    Keyword(
        "TRCIRL", _T, "path: circular arc of a position node",
        (
            form((POSITION, *vector("centre", "c1 c2", "m"), *vector("end point", "x1 x2", "m")), space="planar"),
            form(
                (POSITION, *vector("centre", "c1 c2 c3", "m"), *vector("end point", "x1 x2 x3", "m")),
                space="spatial",
            ),
        ),
        notes=("Only the direction from the centre to the end point counts: the arc ends on that line.",),
    ),
    Keyword(
        "TRE", _T, "path: first deformation mode of an element",
        (form((ELEMENT, real("total displacement (angle or elongation)"))),),
    ),
    Keyword(
        "USERTRAJ", _T, "path: user function, called as USERINP", (form((Parameter("name of the function", "name"),)),),
    ),
    Keyword(
        "TRTIME", _T, "time of the trajectory",
        (
            form((real("total time of this trajectory", "s"), integer("number of time steps"))),
            form(
                (
                    real("total time of this trajectory", "s"), integer("number of steps with an extended analysis"),
                    integer("number of intermediate steps within each"),
                ),
            ),
        ),
    ),
    Keyword("TREPMAX", _T, "velocity profile of an element", (form((ELEMENT, *_RISE), 2, 3),), notes=(_PROFILE,)),
    Keyword("TRVMAX", _T, "velocity profile of a node", (form((NODE, *_RISE), 2, 3),), notes=(_PROFILE,)),
    Keyword(
        "TRFRONT", _T, "shape of the fronts of the velocity profile",
        (
            form(
                (
                    integer("node or element number", NODE_OR_ELEMENT),
                    integer("front type: 0 constant acceleration, 1 sine, 2 squared sine", default=0),
                ),
            ),
        ),
    ),
    Keyword(
        "TRM", _T, "extra mass of a node during a trajectory",
        (
            form((NODE, real("extra mass", "kg")), role="position"),
            form((NODE, real("extra J", "kg m^2")), space="planar", role="orientation"),
            form((NODE, *_TENSOR), *range(2, 8), space="spatial", role="orientation"),
        ),
    ),
    Keyword(
        "TRF", _T, "extra force on a position node during a trajectory",
        (
            form((POSITION, *vector("extra force", "Fx Fy", "N")), space="planar", components=True),
            form((POSITION, *vector("extra force", "Fx Fy Fz", "N")), space="spatial"),
        ),
    ),
)  # fmt: skip


def _port(name: str, block: BlockKind, text: str, *classes: str) -> Keyword:
    """An input or output statement. What follows INPUT, IN, OUT, NOM or REF in the name tells what it
    refers to: E... or S a deformation, X... or F a coordinate."""
    first = _INPUT if name.startswith(("IN", "NOM")) else _OUTPUT
    start = next(p for p in ("NOM", "REF", "INPUT", "OUT", "IN") if name.startswith(p) and name != p)
    target = (ELEMENT, MODE) if name[len(start)] in "ES" else (NODE, COORDINATE)
    return Keyword(name, block, text, (form((first, *target)),), classes=classes, holonomic=name == "INE")


_QUANTITIES = (("", ""), ("P", "first time derivative of a "), ("DP", "second time derivative of a "))


def _series(stem: str, block: BlockKind, text: str, noun: str, *classes: str) -> tuple[Keyword, ...]:
    return tuple(_port(stem + end, block, f"{text}: {what}{noun}", *classes) for end, what in _QUANTITIES)


_L = BlockKind.LINEARIZATION
_FREE = ("dynamic", "kinematic", "calculable")
NOMINAL = (
    _port("NOMS", _T, "nominal input: generalized stress of an actuator element"),
    _port("NOMF", _T, "nominal input: nodal force"), *_series("REFE", _T, "reference output", "deformation"),
    *_series("REFX", _T, "reference output", "coordinate"),
    _port("REFES", _T, "reference output: deformation, with second order expression"),
    _port("REFXS", _T, "reference output: coordinate, with second order expression"),
)  # fmt: skip
LINEARIZATION = (
    _port("INPUTS", _L, "input: stress of a deformation", *_FREE),
    _port("INPUTF", _L, "input: force on a coordinate", *_FREE),
    *_series("INE", _L, "input", "prescribed deformation", "prescribed"),
    *_series("INX", _L, "input", "prescribed coordinate", "prescribed"),
    _port("OUTS", _L, "output: stress of a deformation"),
    *_series("OUTE", _L, "output", "deformation", *_FREE, "prescribed"),
    _port("OUTF", _L, "output: reaction force of a coordinate", "fixed", "prescribed"),
    *_series("OUTX", _L, "output", "coordinate", *_FREE, "prescribed"),
)
_SIMULATED = ("INPUTS", "INPUTF", "OUTE", "OUTEP", "OUTEDP", "OUTX", "OUTXP", "OUTXDP")
SIMULATION = tuple(replace(k, block=BlockKind.SIMULATION) for k in LINEARIZATION if k.name in _SIMULATED)

KEYWORDS = (*TRAJECTORIES, *NOMINAL, *LINEARIZATION, *SIMULATION)
