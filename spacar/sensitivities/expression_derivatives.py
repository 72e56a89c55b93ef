"""Derivatives of expressions (spacar.expressions) by the chain rule, from those of the variables in them.

A value is an array over the stored steps, or one number; its derivatives have one axis more, the directions. Functions
with a corner (abs, max, min, span) have the derivative of the branch that they are on.
"""

import ast
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.expressions.expression_units import NONE, Unit, combine, of_power, of_sum
from spacar.expressions.functions import FUNCTIONS
from spacar.expressions.grammar import Expression, when


class ChainValue(NamedTuple):
    """A value (steps,) or (), its derivatives (..., directions), and its unit."""

    value: Array
    rate: Array
    unit: Unit | None


Leaf = Callable[[ast.Subscript], ChainValue]


def derivative(expression: Expression, variable: Leaf, steps: int, directions: int) -> ChainValue:
    """Value and derivatives of an expression; `variable` gives its variables over all steps. Raises UsageError for a
    step that does not exist."""
    return _Chain(expression.text, variable, steps, directions).of(expression.tree)


def variables(node: ast.expr) -> Iterator[ast.Subscript]:
    return (n for n in ast.walk(node) if isinstance(n, ast.Subscript))


def steps_of(expression: Expression, steps: int) -> set[int]:
    """Steps (from 0) whose variables the expression needs. Raises UsageError for a step that does not exist."""
    found: set[int] = set()

    def walk(node: ast.expr, at: int | None) -> None:
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            walk(node.left, step_of(when(node.right, expression.text), steps, expression.text))
        elif isinstance(node, ast.Subscript):
            found.update(range(steps) if at is None else [at])
        else:
            for child in ast.iter_child_nodes(node):
                if isinstance(child, ast.expr):
                    walk(child, at)

    walk(expression.tree, None)
    return found


def step_of(moment: str | int | float, steps: int, text: str) -> int:
    """The stored step (from 0) of what stands after @; the time of a stationary result counts its steps from 0."""
    if isinstance(moment, str):
        return 0 if moment == "start" else steps - 1
    number = moment - 1 if isinstance(moment, int) else moment
    if number != int(number) or not 0 <= number < steps:
        what = f"step {moment}" if isinstance(moment, int) else f"t = {moment:g}"
        raise UsageError(f"'{text}': {what} does not exist; there are {steps} steps", "expression.step")
    return int(number)


class _Chain:
    def __init__(self, text: str, variable: Leaf, steps: int, directions: int) -> None:
        self.text, self.variable, self.steps, self.directions = text, variable, steps, directions

    def of(self, node: ast.expr) -> ChainValue:
        if isinstance(node, ast.Constant):
            return self.constant(np.asarray(float(node.value)))  # type: ignore[arg-type]
        if isinstance(node, ast.Name):
            return self.constant(np.asarray(np.pi) if node.id == "pi" else np.arange(float(self.steps)))
        if isinstance(node, ast.Subscript):
            return self.variable(node)
        if isinstance(node, ast.UnaryOp):
            a = self.of(node.operand)
            return ChainValue(-a.value, -a.rate, a.unit) if isinstance(node.op, ast.USub) else a
        if isinstance(node, ast.BinOp):
            return self.binary(node)
        assert isinstance(node, ast.Call)
        assert isinstance(node.func, ast.Name)
        return self.call(node.func.id, [self.of(a) for a in node.args])

    def constant(self, value: Array) -> ChainValue:
        return ChainValue(value, np.zeros((*value.shape, self.directions)), NONE)

    def binary(self, node: ast.BinOp) -> ChainValue:
        a = self.of(node.left)
        if isinstance(node.op, ast.MatMult):
            if a.value.shape != (self.steps,):
                text = f"'{self.text}': @ stands behind a series, one value for every step"
                raise UsageError(text, "expression.step")
            k = step_of(when(node.right, self.text), self.steps, self.text)
            return ChainValue(a.value[k], a.rate[k], a.unit)
        b = self.of(node.right)
        x, y = a.value[..., None], b.value[..., None]
        with np.errstate(all="ignore"):
            if isinstance(node.op, (ast.Add, ast.Sub)):
                sign = 1.0 if isinstance(node.op, ast.Add) else -1.0
                return ChainValue(a.value + sign * b.value, a.rate + sign * b.rate, of_sum(a.unit, b.unit, self.text))
            if isinstance(node.op, ast.Mult):
                return ChainValue(a.value * b.value, a.rate * y + x * b.rate, combine(a.unit or NONE, b.unit or NONE))
            if isinstance(node.op, ast.Div):
                unit = combine(a.unit or NONE, b.unit or NONE, -1)
                return ChainValue(a.value / b.value, a.rate / y - x * b.rate / y**2, unit)
            single = float(b.value) if b.value.ndim == 0 and np.isrealobj(b.value) else None
            rate = np.where(a.rate != 0.0, y * x ** (y - 1.0) * a.rate, 0.0)
            if b.rate.any():
                rate = rate + x**y * np.log(x) * b.rate
            return ChainValue(a.value**b.value, rate, of_power(a.unit, b.unit, single, self.text))

    def call(self, name: str, arguments: list[ChainValue]) -> ChainValue:
        unit = FUNCTIONS[name].unit(name, [a.unit for a in arguments], self.text)
        with np.errstate(all="ignore"):
            try:
                value = np.asarray(FUNCTIONS[name].compute(*(a.value for a in arguments)))
                return ChainValue(value, np.asarray(_rate(name, value[..., None], *arguments)), unit)
            except TypeError:  # of NumPy for a function of real numbers
                text = f"'{self.text}': {name} takes real numbers; write abs(), real() or imag() inside"
                raise UsageError(text, "expression.complex") from None


def _rate(name: str, value: Array, a: ChainValue, b: ChainValue | None = None) -> Array:
    x = a.value[..., None]
    if b is not None:
        y = b.value[..., None]
        if name == "hypot":
            return np.asarray((x * a.rate + y * b.rate) / value)
        return np.asarray((y * a.rate - x * b.rate) / (x * x + y * y))  # atan2
    if name in ("max", "min", "span", "mean", "rms", "last"):
        return _of_series(name, value, a)
    factors: dict[str, Callable[[], Any]] = {
        "sqrt": lambda: 0.5 / value, "deg": lambda: 180.0 / np.pi, "sin": lambda: np.cos(x), "cos": lambda: -np.sin(x),
        "tan": lambda: 1.0 / np.cos(x) ** 2, "exp": lambda: value, "log": lambda: 1.0 / x,
        "log10": lambda: 1.0 / (x * np.log(10.0)),
    }  # fmt: skip
    if name == "abs":
        return np.asarray((np.conj(x) * a.rate).real / value)
    if name in ("real", "imag"):
        return np.asarray(getattr(a.rate, name))
    return np.asarray(factors[name]() * a.rate)


def _of_series(name: str, value: Array, a: ChainValue) -> Array:
    series, rate = np.atleast_1d(a.value), a.rate.reshape(-1, a.rate.shape[-1])
    if name == "last":
        return np.asarray(rate[-1])
    if name == "mean":
        return np.asarray(rate.mean(axis=0))
    if name == "rms":
        return np.asarray((np.conj(series)[:, None] * rate).real.mean(axis=0) / value)
    high, low = rate[np.argmax(series)], rate[np.argmin(series)]
    return np.asarray({"max": high, "min": low, "span": high - low}[name])
