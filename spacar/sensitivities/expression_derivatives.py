"""Derivatives of expressions (spacar.expressions) by the chain rule, from those of the variables in them.

A value is an array over the stored steps, or one number; its derivatives have one axis more, the directions. Functions
with a corner (abs, max, min, span) have the derivative of the branch that they are on.
"""

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.expressions.evaluation import ExpressionWalk, Value, step_at
from spacar.expressions.expression_units import NONE
from spacar.expressions.grammar import Expression, when


def derivative(
    expression: Expression, variable: Callable[[ast.Subscript], Value], steps: int, directions: int
) -> Value:
    """Value and derivatives (..., directions) of an expression; `variable` gives its variables over all steps. Raises
    UsageError for a step that does not exist."""
    found = _Chain(expression.text, variable, lambda *_: NONE, steps=steps).value(expression.tree)
    return found._replace(rates=np.broadcast_to(found.rates, (*np.shape(found.values), directions)))


def variables(node: ast.expr) -> Iterator[ast.Subscript]:
    return (n for n in ast.walk(node) if isinstance(n, ast.Subscript))


def steps_of(expression: Expression, steps: int) -> set[int]:
    """Steps (from 0) whose variables the expression needs. Raises UsageError for a step that does not exist."""
    found: set[int] = set()

    def walk(node: ast.expr, at: int | None) -> None:
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            walk(node.left, step_at(np.arange(float(steps)), when(node.right, expression.text), expression.text))
        elif isinstance(node, ast.Subscript):
            found.update(range(steps) if at is None else [at])
        else:
            for child in ast.iter_child_nodes(node):
                if isinstance(child, ast.expr):
                    walk(child, at)

    walk(expression.tree, None)
    return found


@dataclass(frozen=True)
class _Chain(ExpressionWalk):
    """Over the steps of a stationary result, whose time counts them from 0."""

    steps: int = 0

    def variable(self, node: ast.Subscript) -> Value:
        return self.variables(node)

    @property
    def t(self) -> NDArray[np.float64]:
        return np.arange(float(self.steps))

    def rates_of(self, operator: ast.operator, left: Value, right: Value) -> Any:
        x, y, a, b = left.values[..., None], right.values[..., None], left.rates, right.rates
        if isinstance(operator, (ast.Add, ast.Sub)):
            return a + b if isinstance(operator, ast.Add) else a - b
        if isinstance(operator, ast.Mult):
            return a * y + x * b
        if isinstance(operator, ast.Div):
            return a / y - x * b / y**2
        rate = np.where(a != 0.0, y * x ** (y - 1.0) * a, 0.0)
        return rate + x**y * np.log(x) * b if np.any(b) else rate

    def rates_of_call(self, name: str, values: Any, *arguments: Value) -> Any:
        value, x, a = values[..., None], arguments[0].values[..., None], arguments[0].rates
        if len(arguments) == 2:
            y, b = arguments[1].values[..., None], arguments[1].rates
            return (x * a + y * b) / value if name == "hypot" else (y * a - x * b) / (x * x + y * y)  # atan2
        if name in ("max", "min", "span", "mean", "rms", "last"):
            rate = np.broadcast_to(a, (*arguments[0].values.shape, np.shape(a)[-1] if np.ndim(a) else 1))
            return _of_series(name, value, np.atleast_1d(arguments[0].values), rate.reshape(-1, rate.shape[-1]))
        if name == "abs":
            return (np.conj(x) * a).real / value
        if name in ("real", "imag"):
            return np.asarray(getattr(np, name)(a))
        factors: dict[str, Callable[[], Any]] = {
            "sqrt": lambda: 0.5 / value, "deg": lambda: 180.0 / np.pi, "sin": lambda: np.cos(x),
            "cos": lambda: -np.sin(x), "tan": lambda: 1.0 / np.cos(x) ** 2, "exp": lambda: value,
            "log": lambda: 1.0 / x, "log10": lambda: 1.0 / (x * np.log(10.0)),
        }  # fmt: skip
        return factors[name]() * a


def _of_series(name: str, value: Array, series: Array, rate: Array) -> Array:
    if name == "last":
        return rate[-1]
    if name == "mean":
        return rate.mean(axis=0)
    if name == "rms":
        return (np.conj(series)[:, None] * rate).real.mean(axis=0) / value
    high, low = rate[np.argmax(series)], rate[np.argmin(series)]
    return {"max": high, "min": low, "span": high - low}[name]
