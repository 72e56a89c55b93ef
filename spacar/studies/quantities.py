"""Quantities of a result as expressions: `x[6,1]@end`, `max(sig[1,1])`, `2*pi/abs(eigval[1])`.

The text is parsed by Python's grammar and every node is looked up in the tables below; nothing is evaluated as code.

variable      x xd xdd fx fxgrav fxtot xcompl [node, coordinate]; e ed edd sig [element, mode]; t; eigval[i] (complex);
              lmult[i]; m0 c0 d0 k0 n0 g0 [i, j]. All indices from 1. A variable is a series over the stored steps.
series@when   one step: @end, @start, @7 (number of the stored step, from 1) or @0.05 (a stored time, in s)
operators     + - * / ** and numbers, pi
functions     max min mean rms span (largest minus smallest) last of a series;
              abs sqrt sin cos tan exp log log10 real imag
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from spacar.errors import UsageError
from spacar.result import E_VARIABLES, X_VARIABLES, Result

LONGEST = 500  # characters of an expression
SAME_TIME = 1e-9  # two times are equal when they differ by less than this part of the last time
VECTORS, MATRICES = ("eigval", "lmult"), ("m0", "c0", "d0", "k0", "n0", "g0")
INDICES = {
    **dict.fromkeys(X_VARIABLES, 2), **dict.fromkeys(E_VARIABLES, 2),
    **dict.fromkeys(VECTORS, 1), **dict.fromkeys(MATRICES, 2),
}  # fmt: skip
OPERATORS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}  # fmt: skip
REDUCTIONS: dict[str, Callable[[Any], Any]] = {
    "max": np.max, "min": np.min, "mean": np.mean, "span": np.ptp,
    "rms": lambda v: np.sqrt(np.mean(np.abs(v) ** 2)), "last": lambda v: v[-1],
}  # fmt: skip
ELEMENTWISE: dict[str, Callable[[Any], Any]] = {
    "abs": np.abs, "sqrt": np.sqrt, "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp,
    "log": np.log, "log10": np.log10, "real": np.real, "imag": np.imag,
}  # fmt: skip


@dataclass(frozen=True)
class Quantity:
    """A checked expression; `name` heads its column."""

    name: str
    text: str

    def series(self, result: Result) -> np.ndarray:
        """Value over the stored steps, (steps,), or a single number as (1,). Raises UsageError."""
        return np.atleast_1d(np.asarray(_evaluate(_parse(self.text), self.text, result)))

    def number(self, result: Result) -> float | complex:
        """The single number that the expression is. Raises UsageError when it is a series or not finite."""
        value = self.series(result)
        if value.size != 1:
            text = f"{self.text} has a value at each of {value.size} steps; add @end or a function such as max()"
            raise UsageError(text, "study.quantity")
        if not np.isfinite(value[0]):
            raise UsageError(f"{self.text} is {value[0]}", "study.quantity")
        return complex(value[0]) if np.iscomplexobj(value) else float(value[0])


def quantity(text: str) -> Quantity:
    """The quantity of `EXPRESSION` or `NAME: EXPRESSION`; its form is checked now. Raises UsageError."""
    head, colon, tail = text.partition(":")
    name, expression = (head.strip(), tail.strip()) if colon else (text.strip(), text.strip())
    if not name:
        raise UsageError(f"the quantity '{text}' has no name before the colon", "study.quantity")
    _check(_parse(expression), expression)
    return Quantity(name, expression)


def _parse(text: str) -> ast.expr:
    if len(text) > LONGEST:
        raise UsageError(f"the expression has {len(text)} characters, {LONGEST} are allowed", "study.quantity")
    if "\\" in text:
        raise _wrong(text, "a backslash has no meaning")
    try:
        return ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise _wrong(text, getattr(error, "msg", "it cannot be read")) from None


def _wrong(text: str, why: str) -> UsageError:
    return UsageError(f"cannot read the expression '{text}': {why}", "study.quantity")


def _check(node: ast.expr, text: str) -> None:
    """Refuse everything that is not in the tables."""
    if isinstance(node, ast.Constant):
        if isinstance(node.value, bool) or not isinstance(node.value, (int, float)):
            raise _wrong(text, f"{node.value!r} is not a number")
    elif isinstance(node, ast.Name):
        if node.id not in ("t", "pi"):
            known = ", ".join(INDICES)
            form = f"{node.id}[{', '.join(('i', 'j')[: INDICES[node.id]])}]" if node.id in INDICES else ""
            raise _wrong(text, f"write {form}" if form else f"'{node.id}' is not known; variables are t, {known}")
    elif isinstance(node, ast.Subscript):
        _check_variable(node, text)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        _check(node.operand, text)
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        _check(node.left, text)
        _when(node.right, text)
    elif isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        _check(node.left, text)
        _check(node.right, text)
    elif isinstance(node, ast.Call):
        _function(node, text)
        _check(node.args[0], text)
    else:
        raise _wrong(text, f"{type(node).__name__} is not allowed")


def _check_variable(node: ast.Subscript, text: str) -> None:
    if not isinstance(node.value, ast.Name) or node.value.id not in INDICES:
        raise _wrong(text, f"variables with indices are {', '.join(INDICES)}")
    found = _indices(node, text)
    if len(found) != INDICES[node.value.id]:
        raise _wrong(text, f"{node.value.id} takes {INDICES[node.value.id]} indices, not {len(found)}")


def _indices(node: ast.Subscript, text: str) -> tuple[int, ...]:
    parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
    values = [p.value if isinstance(p, ast.Constant) else None for p in parts]
    if not all(type(v) is int and v >= 1 for v in values):
        raise _wrong(text, "indices are whole numbers from 1")
    return tuple(v for v in values if isinstance(v, int))


def _when(node: ast.expr, text: str) -> str | int | float:
    if isinstance(node, ast.Name) and node.id in ("start", "end"):
        return node.id
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return node.value  # type: ignore[return-value]
    raise _wrong(text, "after @ stands end, start, the number of a step or a time such as 0.05")


def _function(node: ast.Call, text: str) -> Callable[[Any], Any]:
    name = node.func.id if isinstance(node.func, ast.Name) else ""
    function = REDUCTIONS.get(name) or ELEMENTWISE.get(name)
    if function is None:
        raise _wrong(text, f"functions are {', '.join((*REDUCTIONS, *ELEMENTWISE))}")
    if len(node.args) != 1 or node.keywords:
        raise _wrong(text, f"{name} takes one argument")
    return function


def _evaluate(node: ast.expr, text: str, result: Result) -> Any:
    if isinstance(node, ast.Constant):
        return float(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return np.pi if node.id == "pi" else result.t
    if isinstance(node, ast.Subscript):
        return _variable(node, text, result)
    if isinstance(node, ast.UnaryOp):
        value = _evaluate(node.operand, text, result)
        return -value if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.BinOp):
        left = _evaluate(node.left, text, result)
        if isinstance(node.op, ast.MatMult):
            return _at(left, _when(node.right, text), text, result.t)
        right = _evaluate(node.right, text, result)
        with np.errstate(all="ignore"):  # number() reports what is not finite
            return OPERATORS[type(node.op)](np.asarray(left), np.asarray(right))
    assert isinstance(node, ast.Call)
    value = np.atleast_1d(_evaluate(node.args[0], text, result))
    with np.errstate(all="ignore"):
        return _function(node, text)(value)


def _variable(node: ast.Subscript, text: str, result: Result) -> Any:
    assert isinstance(node.value, ast.Name)
    name, indices = node.value.id, _indices(node, text)
    if name in X_VARIABLES:
        return result.node(indices[0], indices[1], name)
    if name in E_VARIABLES:
        return result.element(indices[0], indices[1], name)
    values = result[name]
    if name == "eigval":
        values = values[..., 0] + 1j * values[..., 1]
    if any(i > n for i, n in zip(indices, values.shape[1:], strict=True)):
        size = " x ".join(map(str, values.shape[1:]))
        raise UsageError(f"{text}: {name} has {size} values", "study.quantity")
    return values[:, indices[0] - 1] if len(indices) == 1 else values[:, indices[0] - 1, indices[1] - 1]


def _at(series: Any, when: str | int | float, text: str, t: np.ndarray) -> Any:
    series = np.asarray(series)
    if series.shape != t.shape:
        raise UsageError(f"{text}: @ stands behind a series, one value for every step", "study.quantity")
    if when in ("start", "end"):
        return series[0 if when == "start" else -1]
    if isinstance(when, int):
        if not 1 <= when <= len(t):
            raise UsageError(f"{text}: step {when} does not exist; there are {len(t)} steps", "study.quantity")
        return series[when - 1]
    assert isinstance(when, float)
    nearest = int(np.argmin(np.abs(t - when)))
    if abs(t[nearest] - when) > SAME_TIME * max(abs(float(t[-1])), 1e-300):
        text = f"{text}: t = {when:.9g} is not stored, the nearest is {t[nearest]:.9g}"
        raise UsageError(f"{text}; choose the number of steps of TIMESTEP to suit", "study.quantity")
    return series[nearest]
