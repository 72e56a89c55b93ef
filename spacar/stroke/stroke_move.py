"""Which coordinate is moved or pushed, and how far: `7x=0.02`, `8rz=-0.5:0.5`, `e[3,1]=+-0.1`.

A position node moves along x, y, z [m]; an orientation node turns about r (planar) or rx, ry, rz [rad]; e[element,mode]
is a deformation [m, rad]. The value is counted from the reference configuration. A spatial rotation theta about one
axis is prescribed by one Euler parameter, lambda_i = sin(theta/2), whose dual force f gives the moment

    M = f cos(theta/2)/2,      dM/dtheta = (df/dlambda) cos^2(theta/2)/4 - f sin(theta/2)/4,

so that M dtheta = f dlambda (reference/files.md section 5). It is the rotation about that axis as long as the node
turns about no other one; small other rotations change it in the second order.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES
from spacar.errors import UsageError
from spacar.mechanism.numbering import Numbering

SHORT = re.compile(r"(\d+)\s*(x|y|z|rx|ry|rz|r)\Z", re.IGNORECASE)
LONG = re.compile(r"([xe])\s*\[\s*(\d+)\s*,\s*(\d+)\s*\]\Z", re.IGNORECASE)
AXES = ("x", "y", "z")
FORM = "NODEx=VALUE with x, y, z, r, rx, ry or rz, or e[ELEMENT,MODE]=VALUE; VALUE may be FROM:TO or +-VALUE"


@dataclass(frozen=True)
class StrokeMove:
    """A coordinate and its range.

    text        what it is called: "7x", "8rz", "e[3,1]"
    deformation of an element instead of a coordinate;  number, place  node and coordinate, or element and mode, from 1
    rotation    by an Euler parameter: the range is an angle, the coordinate sin(angle/2)
    unit        of the range: "m", "rad", "1";  low, high  [unit], low <= high;  for a force [N, N m] when `pushed`
    """

    text: str
    deformation: bool
    number: int
    place: int
    rotation: bool
    unit: str
    low: float
    high: float
    pushed: bool = False

    @property
    def force_unit(self) -> str:
        return "N" if self.unit == "m" else "N m"

    @property
    def stiffness_unit(self) -> str:
        return "N/m" if self.unit == "m" else "N m/rad"

    def within(self, low: float, high: float) -> StrokeMove:
        """The same coordinate with another range."""
        return replace(self, low=low, high=high)

    def coordinate(self, stroke: Array | float) -> Array:
        """Change of the coordinate by a stroke [unit]."""
        return np.sin(0.5 * np.asarray(stroke)) if self.rotation else np.asarray(stroke, float)

    def stroke(self, change: Array | float) -> Array:
        """The stroke [unit] of a change of the coordinate."""
        return 2.0 * np.arcsin(np.clip(change, -1.0, 1.0)) if self.rotation else np.asarray(change, float)

    def force(self, stroke: Array, dual: Array) -> Array:
        """Force or moment of the actuator from the force dual to the coordinate."""
        return 0.5 * np.cos(0.5 * stroke) * dual if self.rotation else dual

    def stiffness(self, stroke: Array, dual: Array, slope: Array) -> Array:
        """d(force)/d(stroke) from the dual force and its derivative by the coordinate."""
        if not self.rotation:
            return slope
        return 0.25 * (slope * np.cos(0.5 * stroke) ** 2 - dual * np.sin(0.5 * stroke))


def parse_move(
    text: str, numbering: Numbering, metre: float = 1.0, pushed: bool = False, option: str = ""
) -> StrokeMove:
    """The move of `7x=0.02`; lengths are in units of `metre`. `pushed`: the value is a force. `option` is what errors
    call it. Raises UsageError."""
    option = option or ("--force" if pushed else "--move")
    name, equals, value = text.partition("=")
    name, value = name.strip(), value.strip()
    if not equals or not value:
        raise UsageError(f"{option} {text}: expected {FORM}", "flexure.move")
    move = _named(name, numbering, f"{option} {text}")
    low, high = _range(value, f"{option} {text}")
    unit = move.force_unit if pushed else move.unit
    factor = metre if unit in ("m", "N m") else 1.0
    move = replace(move, low=low * factor, high=high * factor, pushed=pushed)
    if move.rotation and not pushed and max(abs(low), abs(high)) > 3.0:
        raise UsageError(f"{option} {text}: a spatial rotation is at most 3 rad to either side", "flexure.move")
    return move


def move_of(numbering: Numbering, deformation: bool, number: int, place: int) -> StrokeMove:
    """The move of a coordinate or deformation without a range yet. Raises UsageError when there is none."""
    name = f"{'e' if deformation else 'x'}[{number},{place}]"
    try:
        (numbering.e_index if deformation else numbering.x_index)(number, place)
    except KeyError:
        raise UsageError(f"there is no {name} in the model", "flexure.move") from None
    rotation, unit, kind = False, "rad", "" if deformation else numbering.kind[number]
    if deformation:
        unit = ELEMENT_TYPES[numbering.keyword[number]].modes[place - 1][1]
    elif kind == "position":
        name, unit = f"{number}{AXES[place - 1]}", "m"
    elif kind == "orientation" and numbering.planar:
        name = f"{number}r"
    elif kind == "orientation" and place > 1:
        name, rotation = f"{number}r{AXES[place - 2]}", True
    else:
        what = "lambda0 follows from the other three" if kind == "orientation" else "a twist rate is no range of motion"
        raise UsageError(f"{name}: {what}", "flexure.move")
    return StrokeMove(name, deformation, number, place, rotation, unit, 0.0, 0.0)


def _named(name: str, numbering: Numbering, asked: str) -> StrokeMove:
    long = LONG.match(name)
    if long:
        return move_of(numbering, long[1].lower() == "e", int(long[2]), int(long[3]))
    short = SHORT.match(name)
    if not short:
        raise UsageError(f"{asked}: {name!r} names no coordinate; expected {FORM}", "flexure.move")
    number, axis = int(short[1]), short[2].lower()
    kind = numbering.kind.get(number)
    if kind is None:
        raise UsageError(f"{asked}: there is no node {number}", "flexure.move")
    wanted = "orientation" if axis[0] == "r" else "position"
    if kind != wanted:
        what = "turns" if wanted == "orientation" else "moves"
        text = f"{asked}: node {number} is a node for {kind}s; what {what} is a node for {wanted}s"
        raise UsageError(text, "flexure.move")
    places = {"x": 1, "y": 2, "r": 1} if numbering.planar else {"x": 1, "y": 2, "z": 3, "rx": 2, "ry": 3, "rz": 4}
    if axis not in places:
        planar = f"a planar model has x, y and r, not {axis}"
        spatial = f"say about which axis node {number} turns: rx, ry or rz"
        raise UsageError(f"{asked}: {planar if numbering.planar else spatial}", "flexure.move")
    return move_of(numbering, False, number, places[axis])


def _range(value: str, asked: str) -> tuple[float, float]:
    both = value.startswith(("+-", "\N{PLUS-MINUS SIGN}"))
    words = value.removeprefix("+-").removeprefix("\N{PLUS-MINUS SIGN}").split(":")
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        raise UsageError(f"{asked}: {value!r} is no number and no range; expected {FORM}", "flexure.move") from None
    if len(numbers) > 2 or (both and len(numbers) > 1) or not np.isfinite(numbers).all():
        raise UsageError(f"{asked}: {value!r} is no finite range; expected {FORM}", "flexure.move")
    if len(numbers) == 1:
        numbers.insert(0, -numbers[0] if both else 0.0)
    low, high = sorted(numbers)
    if low == high:
        raise UsageError(f"{asked}: the range is empty", "flexure.move")
    return low, high
