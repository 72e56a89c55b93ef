"""The tables and keys of a model file: what is required, of which type. Reader, checks and help use this table."""

from dataclasses import dataclass
from functools import partial
from typing import Any


@dataclass(frozen=True)
class Key:
    """One key: accepted types in words (`kind`), required or not, what it is."""

    kind: str
    help: str
    required: bool = True


KINDS: dict[str, tuple[str, Any]] = {
    "text": ("a text", str), "name": ("a name", str), "number": ("a number", (int, float)),
    "integer": ("an integer", int), "flag": ("true or false", bool),
    "expression": ("an expression (text or number)", (str, int, float)), "vector": ("a list of 3 expressions", list),
    "expressions": ("a list of expressions", list),
    "shapes": ('a number of default shapes, a family ("pinned 3") or a list of expressions in x', (int, str, list)),
    "axes": ("2, 3 or [2, 3]", (int, list)),
    "stiffness": ("an expression, or one for each bending direction", (str, int, float, list)),
    "turn": ('1, 2, 3 or a sequence such as "321"', (int, str)),
    "angles": ("an expression, or a list of them for a sequence", (str, int, float, list)), "list": ("a list", list),
    "table": ("a table", dict),
}  # fmt: skip


_may = partial(Key, required=False)
_NAME = Key("name", "name")
_IN = _may("name", "frame of the measure numbers (N)")

TABLES: dict[str, dict[str, Key]] = {
    "system": {"title": _may("text", "title"), "gravity": _may("vector", "gravity in N [m/s²]")},
    "simulate": {
        "time": _may("number", "end of the simulation [s]"), "steps": _may("integer", "number of output steps"),
        "integrator": _may("text", "lsoda, radau or dop853"), "rtol": _may("number", "relative tolerance"),
        "atol": _may("number", "absolute tolerance of all states"),
    },
    "coordinate": {
        "speed": _may("name", "speed that is its derivative"),
        "start": _may("number", "value at t = 0, kept when loops are assembled"),
        "guess": _may("number", "value from which a loop is assembled"),
        "speed_start": _may("number", "speed at t = 0"),
    },
    "speed": {"name": _NAME, "start": _may("number", "value at t = 0")},
    "kinematic": {"coordinate": Key("name", "coordinate"), "rate": Key("expression", "its derivative")},
    "frame": {
        "name": _NAME, "parent": Key("name", "frame or section"),
        "axis": Key("turn", "axis of the parent, 1 to 3, or a sequence of moving axes"),
        "angle": Key("angles", "angle [rad], a list for a sequence"),
        "symbol": _may("text", "letter of its unit vectors"),
    },
    "attitude": {
        "name": _NAME, "parent": Key("name", "frame or section"),
        "quaternion": Key("name", "letter of four coordinates: e makes e0, e1, e2, e3"),
        "speed": Key("name", "letter of three speeds: w makes w1, w2, w3, the angular velocity in the frame [rad/s]"),
        "start": _may("list", "quaternion at t = 0, scaled to length one (1, 0, 0, 0)"),
        "speed_start": _may("list", "angular velocity at t = 0 [rad/s]"),
        "symbol": _may("text", "letter of its unit vectors"),
    },
    "point": {
        "name": _NAME, "base": Key("name", "point"), "offset": Key("vector", "vector from the base [m]"), "in": _IN,
    },
    "beam": {
        "name": _NAME, "frame": Key("name", "frame, axis 1 along the beam"), "root": Key("name", "point"),
        "length": Key("expression", "length [m]"),
        "mass": Key("expression", "mass per length [kg/m], may depend on x"),
        "EI": _may("stiffness", "bending stiffness [N m²], may depend on x"),
        "bends": _may("axes", "unit vectors of deflection"), "field": _may("shapes", "assumed field"),
        "damping": _may("expression", "γ [N s]"),
        "damping_boundary": _may("flag", "natural boundary condition of the damping"),
        "foreshortening": _may("flag", "shortening by bending"), "twist": _may("shapes", "torsion field"),
        "GJ": _may("expression", "torsion stiffness [N m²]"),
        "polar": _may("expression", "polar moment of inertia per length [kg m]"),
        "stretch": _may("shapes", "axial field"), "EA": _may("expression", "axial stiffness [N]"),
        "start": _may("list", "amplitudes of all shapes at t = 0"), "speed_start": _may("list", "their rates at t = 0"),
    },
    "body": {
        "name": _NAME, "at": Key("name", "point of the mass centre"), "mass": Key("expression", "mass [kg]"),
        "frame": _may("name", "frame in which it is fixed (none: particle)"),
        "inertia": _may("expressions", "I11, I22, I33[, I12, I23, I31] [kg m²]"),
    },
    "force": {
        "name": _may("name", "input"), "at": Key("name", "point"), "vector": Key("vector", "force [N]"), "in": _IN,
    },
    "distributed": {
        "beam": Key("name", "beam"), "vector": Key("vector", "force per length [N/m], may depend on x"), "in": _IN,
    },
    "torque": {
        "name": _may("name", "input"), "frame": Key("name", "frame or section"),
        "reaction": _may("name", "frame or section of the reaction"), "vector": Key("vector", "torque [N m]"),
        "in": _IN,
    },
    "spring": {
        "from": Key("name", "point"), "to": Key("name", "point"), "stiffness": Key("expression", "stiffness [N/m]"),
        "length": _may("expression", "length without force [m]"), "damping": _may("expression", "damping [N s/m]"),
    },
    "constraint": {
        "expression": _may("expression", "what is zero: linear in the speeds, or a position"),
        "point": _may("name", "point that does not move along `direction`"),
        "direction": _may("vector", "direction of no velocity"), "in": _IN,
        "name": _may("name", "constraint; NAME_force is its force"),
    },
    "close": {
        "from": Key("name", "point"), "to": Key("name", "point that coincides with it"),
        "directions": _may("list", "axes of the frame along which they coincide (1, 2, 3)"), "in": _IN,
        "name": _may("name", "loop; NAME_force or NAME_1_force … are its forces"),
    },
}  # fmt: skip
"""Arrays of tables `[[name]]`, except `[system]`, `[simulate]` and the rows of `[coordinates]` (`coordinate`)."""

SINGLE = ("system", "simulate", "parameters", "coordinates", "outputs")
REFERENCES = {"frame": ("parent",), "attitude": ("parent",), "point": ("base", "in"), "beam": ("frame", "root")}
"""What must exist before a frame, point or beam can be made; the order in the file is free."""
