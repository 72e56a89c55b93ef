"""Results of `spacar symbolic`: quantities by name over time, with nodes and elements where the model has points."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from spacar import expressions
from spacar.arrays import Array
from spacar.errors import UsageError

if TYPE_CHECKING:
    from spacar_drawing.picture_source import PictureSource


class _Names(ast.NodeTransformer):
    """Names of quantities as the coordinate that the language knows: the i-th one is x[i,1]."""

    def __init__(self, text: str, names: Sequence[str]) -> None:
        self.text, self.names = text, list(names)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        node.args = [self.visit(a) for a in node.args]
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return node if node.id in ("t", "pi", "end") else self._place(node)

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        return self._place(node)

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        raise UsageError(f"'{self.text}': what is plotted here goes by name: t, {', '.join(self.names)}", "plot.name")

    def _place(self, node: ast.expr) -> ast.AST:
        name = ast.unparse(node)
        if name not in self.names:
            raise UsageError(f"'{self.text}': {name} is none of t, {', '.join(self.names)}", "plot.name")
        return _coordinate(self.names.index(name))


def _coordinate(i: int) -> ast.expr:
    return ast.parse(f"x[{i + 1},1]", mode="eval").body


@dataclass(frozen=True)
class _Columns:
    """The quantities as coordinates 1 of nodes 1, 2, ...; none has deformations."""

    source: PictureSource

    @property
    def lnp(self) -> NDArray[np.int64]:
        return np.arange(1, len(self.source.named) + 1)[:, None]

    @property
    def le(self) -> NDArray[np.int64]:
        return np.zeros((0, 0), np.int64)

    def __getitem__(self, name: str) -> Any:
        return np.column_stack(list(self.source.named.values())) if name == "x" else self.source.get(name)


def named_values(source: PictureSource, text: str) -> tuple[Array, str]:
    """(steps,) values of an expression of named quantities, or of a name that is none (`T + V`), and the name if it is
    a single one. Units are those of the model, which nobody stated. Raises UsageError."""
    text, names = text.strip(), list(source.named)
    if text in source.named:
        return source.named[text], text
    try:
        tree = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        expression = expressions.parse(text)  # says what is wrong
    else:
        expression = expressions.parse(ast.unparse(_Names(text, names).visit(tree)))
    values, _ = expressions.evaluate(expression, _Columns(source))
    return np.broadcast_to(np.asarray(values, float), (source.steps,)), "t" if text == "t" else ""
