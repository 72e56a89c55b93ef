"""The functions of expressions, one row each: arguments, values, and what becomes of the unit."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from spacar.errors import UsageError
from spacar.expressions.expression_units import DEGREE, NONE, RAD, Unit


@dataclass(frozen=True)
class ExpressionFunction:
    """compute: of arrays over the steps, or numbers.  unit(name, units, text): UsageError where it makes no sense.

    over_steps: one number of a series, which is the first axis.
    """

    help: str
    compute: Callable[..., Any]
    unit: Callable[[str, Sequence[Unit | None], str], Unit | None]
    arguments: int = 1
    over_steps: bool = False


def _same(name: str, units: Sequence[Unit | None], text: str) -> Unit | None:
    known = [u for u in units if u is not None]
    if any(u != known[0] for u in known):
        raise UsageError(f"'{text}': both arguments of {name} must have the same unit", "expression.unit")
    return known[0] if len(known) == len(units) else None


def _angle(name: str, units: Sequence[Unit | None], text: str) -> Unit | None:
    return None if _same(name, units, text) is None else RAD


def _root(name: str, units: Sequence[Unit | None], text: str) -> Unit | None:
    if units[0] is None:
        return None
    if any(p % 2 for _, p in units[0]):
        raise UsageError(f"'{text}': the square root of this unit is none", "expression.unit")
    return tuple((s, p // 2) for s, p in units[0])


def _pure(name: str, units: Sequence[Unit | None], text: str) -> Unit | None:
    allowed = (None, NONE, RAD) if name in ("sin", "cos", "tan", "deg") else (None, NONE)
    if units[0] not in allowed:
        why = "deg converts radians" if name == "deg" else f"{name} takes a number without unit"
        raise UsageError(f"'{text}': {why}", "expression.unit")
    return None if units[0] is None else DEGREE if name == "deg" else NONE


def _rms(values: Any) -> Any:
    return np.sqrt(np.mean(np.abs(values) ** 2, axis=0))


FUNCTIONS = {
    "max": ExpressionFunction("largest value of a series", partial(np.max, axis=0), _same, 1, True),
    "min": ExpressionFunction("smallest value", partial(np.min, axis=0), _same, 1, True),
    "mean": ExpressionFunction("mean of the stored values", partial(np.mean, axis=0), _same, 1, True),
    "rms": ExpressionFunction("square root of the mean of the squares", _rms, _same, 1, True),
    "span": ExpressionFunction("largest minus smallest value", partial(np.ptp, axis=0), _same, 1, True),
    "last": ExpressionFunction("last value", lambda v: v[-1], _same, 1, True),
    "abs": ExpressionFunction("absolute value", np.abs, _same),
    "real": ExpressionFunction("real part", np.real, _same),
    "imag": ExpressionFunction("imaginary part", np.imag, _same),
    "sqrt": ExpressionFunction("square root", np.sqrt, _root),
    "hypot": ExpressionFunction("sqrt(a² + b²)", np.hypot, _same, 2),
    "atan2": ExpressionFunction("angle of (second, first argument) with the axis [rad]", np.arctan2, _angle, 2),
    "deg": ExpressionFunction("radians to degrees", np.degrees, _pure),
    **{name: ExpressionFunction(help, getattr(np, name), _pure) for name, help in (
        ("sin", "sine of radians"), ("cos", "cosine of radians"), ("tan", "tangent of radians"),
        ("exp", "exponential function"), ("log", "natural logarithm"), ("log10", "logarithm to base 10"))},
}  # fmt: skip
