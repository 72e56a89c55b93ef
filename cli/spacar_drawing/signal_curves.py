"""Signals of a simulation as curves: `robot:10-12`, `error` (all of a block or scope), `robot[10] - y0[10]`."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from spacar_formats.signal_tables import SignalTable

from spacar import expressions
from spacar.arrays import Array
from spacar.errors import UsageError

if TYPE_CHECKING:
    from spacar_drawing.picture_source import PictureSource

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


class _Signals(ast.NodeTransformer):
    """NAME[k] of a block as the coordinate x[n,1] of a node that does not exist."""

    def __init__(self, table: SignalTable, nodes: int) -> None:
        self.table, self.nodes, self.found = table, nodes, False

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        if not (
            isinstance(node.value, ast.Name)
            and isinstance(node.slice, ast.Constant)
            and isinstance(node.slice.value, int)
        ):
            return node
        found = columns_of(self.table, f"{node.value.id}:{node.slice.value}")
        assert found is not None
        self.found = True
        return ast.parse(f"x[{self.nodes + found[1][0] + 1},1]", mode="eval").body


@dataclass(frozen=True)
class _SignalVariables:
    """The variables of a source with its signals as coordinates 1 of further nodes."""

    source: PictureSource
    table: SignalTable

    @property
    def lnp(self) -> NDArray[np.int64]:
        own = np.asarray(self.source.scene.lnp)
        own = own if own.size else np.zeros((0, 1), np.int64)
        more = np.zeros((len(self.table.names), own.shape[1]), np.int64)
        more[:, 0] = self._coordinates + 1 + np.arange(len(more))
        return np.vstack((own, more))

    @property
    def le(self) -> NDArray[np.int64]:
        return self.source.scene.le

    @property
    def _coordinates(self) -> int:
        return int(np.max(self.source.scene.lnp, initial=0))

    def __getitem__(self, name: str) -> Any:
        if name != "x":
            return self.source.get(name)
        own = self.source.get("x") if self._coordinates else np.zeros((self.source.steps, 0))
        return np.hstack((own[:, : self._coordinates], self.table.values))


def expression_of_signals(source: PictureSource, table: SignalTable, text: str) -> Array | None:
    """(steps,) values of an expression with NAME[k] in it; None when it has no such signal. Raises UsageError."""
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None  # the language of expressions says what is wrong
    nodes = len(source.scene.lnp)
    names = _Signals(table, nodes)
    variables = {n.value.id for n in ast.walk(tree) if isinstance(n, ast.Subscript) and isinstance(n.value, ast.Name)}
    if not any(name in table.blocks for name in variables):
        return None
    changed = names.visit(tree)
    if not names.found:
        return None
    values, _ = expressions.evaluate(expressions.parse(ast.unparse(changed)), _SignalVariables(source, table))
    return np.broadcast_to(np.asarray(values, float), (source.steps,))
