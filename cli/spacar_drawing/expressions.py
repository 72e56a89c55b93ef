"""Expressions of result variables: `x[6,1]`, `sig[1,1]`, `xdd[6,1] - xdd[3,1]`, `hypot(x[6,1], x[6,2])`.

Variables of nodes: x xd xdd fx fxgrav fxtot xcompl [node, coordinate]; of elements: e ed edd sig [element, mode]; t.
Units are those of the keyword table; forces are dual to coordinates, stresses dual to deformations.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from spacar.deck import ELEMENT_TYPES
from spacar.errors import UsageError
from spacar_drawing.quantities import NONE, Quantity, Unit, combine, unit

if TYPE_CHECKING:
    from spacar_drawing.source import Source

NODE_VARIABLES = {"x": 0, "xd": 1, "xdd": 2, "fx": -1, "fxgrav": -1, "fxtot": -1, "fxt": -1, "xcompl": -2}
ELEMENT_VARIABLES = {"e": 0, "ed": 1, "edd": 2, "sig": -1}
MEANING = {
    "x": "coordinate",
    "xd": "velocity",
    "xdd": "acceleration",
    "fx": "applied force",
    "fxgrav": "gravity force",
    "fxtot": "force",
    "fxt": "force",
    "xcompl": "compliance",
    "e": "deformation",
    "ed": "deformation rate",
    "edd": "deformation acceleration",
    "sig": "stress resultant",
    "t": "time",
}
FUNCTIONS: dict[str, tuple[int, Callable[..., object]]] = {
    **{name: (1, getattr(np, name)) for name in ("abs", "sqrt", "sin", "cos", "tan", "exp", "log")},
    "deg": (1, np.degrees),
    "hypot": (2, np.hypot),
    "atan2": (2, np.arctan2),
}
HELP = "write for example x[6,1], xdd[6,1], e[2,1], sig[1,1], t, x[6,1]-x[3,1], hypot(x[6,1],x[6,2]), deg(x[2,1])"


@dataclass(frozen=True)
class Curve:
    """An evaluated expression; `variable` is its name when it is a single variable, else empty."""

    text: str
    quantity: Quantity
    variable: str


def evaluate(source: Source, text: str) -> Curve:
    """The values of an expression at all steps, with its unit. Raises UsageError with the reason."""
    if text.strip() in source.named:
        values = np.asarray(source.named[text.strip()], float)
        if not np.isfinite(values).any():
            raise UsageError(f"'{text}' is nowhere a finite number", "plot.finite")
        return Curve(text.strip(), Quantity(values), text.strip())
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise UsageError(f"'{text}' is no expression; {HELP}", "plot.expression") from None
    try:
        value = _value(source, tree, text)
    except (RecursionError, OverflowError):
        raise UsageError(f"'{text}' is nested too deep or has numbers that are too large", "plot.expression") from None
    values = np.broadcast_to(np.asarray(value.values, float), (source.steps,))
    single = tree.value if isinstance(tree, ast.Subscript) else tree
    variable = single.id if isinstance(single, ast.Name) else ""
    if not np.isfinite(values).any():
        raise UsageError(f"'{text}' is nowhere a finite number", "plot.finite")
    return Curve(text.strip(), Quantity(values, value.unit), variable)


def warnings(curves: Sequence[Curve]) -> list[str]:
    """What a user should know before trusting a curve: values that cannot be shown."""
    found = []
    for curve in curves:
        bad = int(np.count_nonzero(~np.isfinite(curve.quantity.values)))
        if bad:
            found.append(f"'{curve.text}' is not a finite number at {bad} of {np.size(curve.quantity.values)} steps")
    return found


def _value(source: Source, node: ast.expr, text: str) -> Quantity:
    if source.named and isinstance(node, (ast.Name, ast.Attribute)) and ast.unparse(node) in source.named:
        return Quantity(source.named[ast.unparse(node)])
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
        return Quantity(float(node.value))
    if isinstance(node, ast.Name):
        if node.id == "t":
            stationary = source.scene.analysis.stationary
            return Quantity(np.ravel(source.get("t")), NONE if stationary else unit(s=1))
        if node.id == "pi":
            return Quantity(np.pi)
        if source.named:
            raise UsageError(f"'{text}': {node.id} is none of t, {', '.join(source.named)}", "plot.name")
        known = [*NODE_VARIABLES, *ELEMENT_VARIABLES]
        if node.id in known:
            raise UsageError(f"'{text}': {node.id} needs two numbers in brackets; {HELP}", "plot.expression")
        raise UsageError(f"'{text}': {node.id} is not a variable; these are t, {', '.join(known)}", "plot.expression")
    if isinstance(node, ast.Subscript):
        return _variable(source, node, text)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        value = _value(source, node.operand, text)
        return Quantity(-value.values, value.unit) if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.BinOp):
        a, b = _value(source, node.left, text), _value(source, node.right, text)
        if isinstance(node.op, (ast.Add, ast.Sub)):
            return a.plus(b, 1 if isinstance(node.op, ast.Add) else -1, f"'{text}'")
        if isinstance(node.op, (ast.Mult, ast.Div)):
            return a.times(b, 1 if isinstance(node.op, ast.Mult) else -1)
        if isinstance(node.op, ast.Pow):
            return a.power(b, f"'{text}'")
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        return _call(node.func.id, [_value(source, a, text) for a in node.args], text)
    raise UsageError(f"'{text}' is no expression that can be plotted; {HELP}", "plot.expression")


def _call(name: str, arguments: list[Quantity], text: str) -> Quantity:
    if name not in FUNCTIONS:
        raise UsageError(f"'{text}': {name} is not a function; these are {', '.join(FUNCTIONS)}", "plot.expression")
    count, function = FUNCTIONS[name]
    if len(arguments) != count:
        raise UsageError(f"'{text}': {name} takes {count} argument{'s' * (count > 1)}", "plot.expression")
    units = [a.unit for a in arguments]
    with np.errstate(invalid="ignore", divide="ignore"):
        values = np.asarray(function(*(a.values for a in arguments)), float)
    if name == "abs":
        return Quantity(values, units[0])
    if name in ("hypot", "atan2"):
        if units[0] != units[1]:
            raise UsageError(f"'{text}': both arguments of {name} must have the same unit", "plot.unit")
        return Quantity(values, units[0] if name == "hypot" else unit(rad=1))
    if name == "sqrt":
        if any(p % 2 for _, p in units[0]):
            raise UsageError(f"'{text}': the square root of this unit is none", "plot.unit")
        return Quantity(values, tuple((s, p // 2) for s, p in units[0]))
    if name == "deg":
        if units[0] not in (unit(rad=1), NONE):
            raise UsageError(f"'{text}': deg converts radians", "plot.unit")
        return Quantity(values, unit(deg=1))
    if units[0] not in ((unit(rad=1), NONE) if name in ("sin", "cos", "tan") else (NONE,)):
        raise UsageError(f"'{text}': {name} takes a number without unit", "plot.unit")
    return Quantity(values)


def _variable(source: Source, node: ast.Subscript, text: str) -> Quantity:
    """x[node, coordinate] or e[element, mode]."""
    if source.named:
        raise UsageError(f"'{text}': the result has no nodes, but t, {', '.join(source.named)}", "plot.name")
    name = node.value.id if isinstance(node.value, ast.Name) else ""
    index = node.slice.elts if isinstance(node.slice, ast.Tuple) else []
    numbers = [n.value for n in index if isinstance(n, ast.Constant) and type(n.value) is int]
    if name not in NODE_VARIABLES and name not in ELEMENT_VARIABLES:
        raise UsageError(f"'{text}': {name or 'this'} is not a variable with brackets; {HELP}", "plot.expression")
    if len(numbers) != 2 or len(index) != 2:
        what = "node and coordinate number" if name in NODE_VARIABLES else "element and mode number"
        raise UsageError(f"'{text}': {name} needs {what}, as {name}[6,1]", "plot.expression")
    number, k = numbers
    of_node = name in NODE_VARIABLES
    table = source.scene.lnp if of_node else source.scene.le
    row = table[number - 1] if 1 <= number <= len(table) else np.zeros(0, int)
    if not np.any(row):
        raise UsageError(f"'{text}': {'node' if of_node else 'element'} {number} does not exist", "plot.number")
    if not (1 <= k <= len(row) and row[k - 1]):
        last = int(np.max(np.flatnonzero(row))) + 1
        what = (
            f"node {number} has the coordinates 1 to {last}"
            if of_node
            else f"element {number} has the modes 1 to {last}"
        )
        raise UsageError(f"'{text}': {what}", "plot.number")
    values = source.get(name)[:, row[k - 1] - 1]
    return Quantity(values, node_unit(source, name, number, row) if of_node else element_unit(source, name, number, k))


def node_unit(source: Source, name: str, number: int, row: np.ndarray) -> Unit:
    position = number in source.scene.position_nodes
    own = unit(m=1) if position else unit(rad=1) if source.scene.planar else NONE
    order = NODE_VARIABLES[name]
    force = unit(N=1) if position else unit(N=1, m=1)
    if order == -1:
        return force
    if order == -2:
        return combine(own, force, -1)
    return combine(own, unit(s=order), -1)


def element_unit(source: Source, name: str, number: int, mode: int) -> Unit:
    word = ELEMENT_TYPES[source.scene.keywords[number - 1]].modes[mode - 1][1]
    own = {"m": unit(m=1), "rad": unit(rad=1), "m^2": unit(m=2)}.get(word, NONE)
    order = ELEMENT_VARIABLES[name]
    if order == -1:  # power: N m/s = sig de/dt
        return combine(unit(N=1, m=1), unit() if word == "rad" else own, -1)
    return combine(own, unit(s=order), -1)
