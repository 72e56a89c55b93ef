"""Expressions of a drawn result as curves with units; the language is that of spacar.expressions.

Results of `spacar symbolic`: quantities by name over time, with nodes and elements where the model has points.

Signals of a simulation as curves: `robot:10-12`, `error` (all of a block or scope), `robot[10] - y0[10]`.
"""

import ast
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from spacar_formats.signal_tables import Panel, SignalTable

from spacar import expressions
from spacar.arrays import Array
from spacar.deck.length_unit import shown_in
from spacar.errors import UsageError
from spacar.expressions import NONE, Dimensions, Unit
from spacar_drawing.picture_source import PictureSource


@dataclass(frozen=True)
class Curve:
    """An evaluated expression, (steps,); `variable` is its name when it is a single variable, else empty."""

    text: str
    values: NDArray[np.float64]
    unit: Unit | None
    variable: str
    group: str = ""  # curves with the same one share a panel, which it names


@dataclass(frozen=True)
class _Variables:
    """The variables of a source as the language reads them, with `more` columns as coordinates 1 of further nodes."""

    source: PictureSource
    more: Array | None = None

    @property
    def lnp(self) -> NDArray[np.int64]:
        own = np.asarray(self.source.scene.lnp)
        if self.more is None:
            return own
        own = own if own.size else np.zeros((0, 1), np.int64)
        more = np.zeros((self.more.shape[1], own.shape[1]), np.int64)
        more[:, 0] = np.max(own, initial=0) + 1 + np.arange(len(more))
        return np.vstack((own, more))

    @property
    def le(self) -> NDArray[np.int64]:
        return self.source.scene.le

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name != "x" or self.more is None:
            return self.source.get(name)
        count = int(np.max(self.source.scene.lnp, initial=0))
        own = self.source.get("x")[:, :count] if count else np.zeros((self.source.steps, 0))
        return np.hstack((own, self.more))


class _Names(ast.NodeTransformer):
    """Names of quantities as the coordinate that the language knows: the i-th one is x[before + i,1]."""

    def __init__(self, text: str, names: list[str], before: int) -> None:
        self.text, self.names, self.before = text, names, before

    def visit_Call(self, node: ast.Call) -> ast.AST:
        node.args = [self.visit(a) for a in node.args]
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return node if node.id in ("t", "pi", "end") else self.visit_Attribute(node)

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        raise UsageError(f"'{self.text}': what is plotted here goes by name: t, {', '.join(self.names)}", "plot.name")

    def visit_Attribute(self, node: ast.expr) -> ast.AST:
        name = ast.unparse(node)
        if name not in self.names:
            raise UsageError(f"'{self.text}': {name} is none of t, {', '.join(self.names)}", "plot.name")
        return _coordinate(self.before + self.names.index(name))


class _Signals(ast.NodeTransformer):
    """NAME[k] of a block as the coordinate x[before + n,1]."""

    def __init__(self, table: SignalTable, before: int) -> None:
        self.table, self.before, self.found = table, before, False

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        name, index = node.value, node.slice
        if not (isinstance(name, ast.Name) and isinstance(index, ast.Constant) and isinstance(index.value, int)):
            return node
        found = columns_of(self.table, f"{name.id}:{index.value}")
        assert found is not None
        self.found = True
        return _coordinate(self.before + found[1][0])


def _coordinate(i: int) -> ast.expr:
    return ast.parse(f"x[{i + 1},1]", mode="eval").body


def expression_of_signals(source: PictureSource, table: SignalTable, text: str) -> Array | None:
    """Values, (steps,) or one number (), of an expression with NAME[k] in it; None when it has no such signal. Raises
    UsageError."""
    tree = _tree(text)
    used = () if tree is None else (n.value for n in ast.walk(tree) if isinstance(n, ast.Subscript))
    if tree is None or not any(isinstance(name, ast.Name) and name.id in table.blocks for name in used):
        return None
    names = _Signals(table, len(source.scene.lnp))
    changed = names.visit(tree)
    return _with_columns(source, text, changed, table.values) if names.found else None


def _tree(text: str) -> ast.expr | None:
    """None for what is no expression: the language of expressions says what is wrong."""
    try:
        return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def _with_columns(source: PictureSource, text: str, tree: ast.expr | None, columns: Array) -> Array:
    """Values, (steps,) or one number (), of an expression that names columns (steps, n) as coordinates 1 of further
    nodes."""
    expression = expressions.parse(text if tree is None else ast.unparse(tree))
    return expressions.evaluate(expression, _Variables(source, columns))[0]


NAMED = re.compile(r"\s*([^\s:\[\]()*/+,]+?)\s*(?::\s*([-0-9,\s]+))?\s*")


def columns_of(table: SignalTable, text: str) -> tuple[str, list[int]] | None:
    """Block and columns of `NAME` or `NAME:1-3,7`; None when the text is no such name. Raises UsageError."""
    match = NAMED.fullmatch(text)
    if match is None or (match[1] not in table.blocks and match[2] is None):
        return None
    block, numbers = match[1], match[2]
    own = table.columns(block)
    if not own:
        known = ", ".join(dict.fromkeys(table.blocks))
        raise UsageError(f"'{text}': there is no block {block} with signals; there are {known}", "plot.signal")
    if numbers is None:
        return block, own
    chosen: list[int] = []
    for part in numbers.split(","):
        first, _, last = (word.strip() for word in part.partition("-"))
        if not first.isdigit() or (last and not last.isdigit()):
            raise UsageError(f"'{text}': '{part.strip()}' is no signal number", "plot.signal")
        a, b = int(first), int(last or first)
        if not 1 <= a <= b <= len(own):
            raise UsageError(f"'{text}': {block} has the signals 1 to {len(own)}", "plot.signal")
        chosen += own[a - 1 : b]
    return block, chosen


def panel_title(panel: Panel) -> str:
    return f"{panel.title} ({panel.unit})" if panel.unit else panel.title


def curves_of(source: PictureSource, text: str) -> list[Curve]:
    """The curve of an expression, or the curves of a block or scope of a simulation. Raises UsageError."""
    table = source.signals
    found = None if table is None else columns_of(table, text)
    if table is None or found is None:
        return [evaluate(source, text)]
    block, columns = found
    panel = next((p for p in table.panels if set(columns) <= set(p.columns)), None)
    group = block if panel is None else panel_title(panel)
    names = {k: table.names[k] for k in columns}
    if panel is not None:
        names |= dict(zip(panel.columns, panel.labels, strict=True))
    return [_shown(source, Curve(names[k], table.values[:, k], NONE, "", group)) for k in columns]


def evaluate(source: PictureSource, text: str) -> Curve:
    """The values of an expression at all steps, with its unit. Raises UsageError with the reason."""
    if source.signals is not None:
        if columns_of(source.signals, text) is not None:
            found, *others = curves_of(source, text)
            if others:
                raise UsageError(f"'{text}' stands for {1 + len(others)} signals, one is needed here", "plot.signal")
            return found
        mixed = expression_of_signals(source, source.signals, text)
        if mixed is not None:
            return _shown(source, Curve(text.strip(), mixed, NONE, ""))
        if not source.scene.lnp.size:
            if text.strip() == "t":
                return _shown(source, Curve("t", np.ravel(source.get("t")), NONE, "t"))
            known = ", ".join(dict.fromkeys(source.signals.blocks))
            raise UsageError(f"'{text}': what is plotted here is t, and BLOCK:NUMBER of {known}", "plot.signal")
    if source.named:  # units are those of the model, which nobody stated
        text = text.strip()
        if text in source.named:
            return _shown(source, Curve(text, source.named[text], NONE, text))
        tree = _tree(text)
        if tree is not None:
            tree = _Names(text, list(source.named), len(source.scene.lnp)).visit(tree)
        values = _with_columns(source, text, tree, np.column_stack(list(source.named.values())))
        return _shown(source, Curve(text, values, NONE, "t" if text == "t" else ""))
    scene = source.scene
    dimensions = Dimensions(scene.planar, scene.analysis.stationary, frozenset(scene.position_nodes), scene.keywords)
    expression = expressions.parse(text)
    values, unit = expressions.evaluate(expression, _Variables(source), dimensions)
    if np.iscomplexobj(values):
        raise UsageError(f"'{text}' is complex; plot its abs(), real() or imag()", "plot.complex")
    return _shown(source, Curve(expression.text, values, unit, expression.variable))


def in_units(curve: Curve, metre: float) -> Curve:
    """The curve in the unit of length of the input, for pictures and tables; as it is where its unit is not known."""
    if metre == 1.0 or not curve.unit:
        return curve
    powers = dict(curve.unit)
    power = powers.pop("m", 0)
    if power:
        powers[shown_in("m", metre)[1]] = power
    return replace(curve, values=np.asarray(curve.values) * metre**-power, unit=tuple(sorted(powers.items())))


def _shown(source: PictureSource, curve: Curve) -> Curve:
    """The curve with a value at every step. Raises UsageError when none of them can be shown."""
    if not np.isfinite(curve.values).any():
        raise UsageError(f"'{curve.text}' is nowhere a finite number", "plot.finite")
    return replace(curve, values=np.broadcast_to(np.asarray(curve.values, float), (source.steps,)))


def warnings(curves: Sequence[Curve]) -> list[str]:
    """What a user should know before trusting a curve: values that cannot be shown."""
    bad = [(c, int(np.count_nonzero(~np.isfinite(c.values)))) for c in curves]
    return [f"'{c.text}' is not a finite number at {n} of {np.size(c.values)} steps" for c, n in bad if n]
