"""The values of a checked expression, over the steps or one number, with its unit where units are followed."""

import ast
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from spacar.errors import UsageError
from spacar.expressions.expression_units import NONE, Unit, combine, of_power, of_sum
from spacar.expressions.functions import FUNCTIONS
from spacar.expressions.grammar import ALIASES, E_NAMES, X_NAMES, Expression, indices, when
from spacar.expressions.result_places import ELEMENT, NODE, place

SAME_TIME = 1e-9  # two times are equal when they differ by less than this part of the last time
OPERATORS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}  # fmt: skip


class Variables(Protocol):
    """What an expression reads: a Result, or a file. `variables[name]` has the steps as its first axis."""

    @property
    def lnp(self) -> NDArray[np.int64]: ...
    @property
    def le(self) -> NDArray[np.int64]: ...
    def __getitem__(self, name: str, /) -> Any: ...


class Value(NamedTuple):
    """An array over the steps (steps,) or one number (), and its unit; None: not followed. `rates`: derivatives, with
    an axis of directions at the end, or 0."""

    values: Any
    unit: Unit | None
    rates: Any = 0.0


def evaluate_cases(expression: Expression, variables: Variables) -> NDArray[Any]:
    """Values of many cases at once: of `variables` every one has a further axis of cases at its end, and so have the
    values, (steps, cases); or (cases,) or () where they are numbers. Raises what `evaluate` does."""
    return np.asarray(ExpressionWalk(expression.text, variables, None, of_cases=True).value(expression.tree).values)


def evaluate(
    expression: Expression, variables: Variables, units: Callable[[str, Sequence[int]], Unit | None] | None = None
) -> tuple[NDArray[Any], Unit | None]:
    """Values over the stored steps, (steps,), or one number, (), real or complex; and the unit.

    units   the unit of a variable (`Dimensions`); None: units are not followed

    Raises UsageError for what the result does not have, and for units that do not fit. Numbers that are not finite
    stay in the values.
    """
    try:
        found = ExpressionWalk(expression.text, variables, units).value(expression.tree)
    except (RecursionError, OverflowError):
        text = f"'{expression.text}' is nested too deep or has numbers that are too large"
        raise UsageError(text, "expression.form") from None
    return np.asarray(found.values), found.unit


@dataclass(frozen=True)
class ExpressionWalk:
    """One walk through an expression; who follows derivatives writes `rates_of` and `rates_of_call`."""

    text: str
    variables: Any  # `Variables`, or what the `variable` of a subclass reads
    units: Callable[[str, Sequence[int]], Unit | None] | None
    of_cases: bool = False  # arrays have an axis of cases at their end

    def value(self, node: ast.expr) -> Value:
        if isinstance(node, ast.Constant):
            return Value(np.asarray(float(node.value)), self.plain)  # type: ignore[arg-type]
        if isinstance(node, ast.Name):
            return Value(np.asarray(np.pi), self.plain) if node.id == "pi" else Value(self.t, self.unit_of("t", ()))
        if isinstance(node, ast.Subscript):
            return self.variable(node)
        if isinstance(node, ast.UnaryOp):
            found = self.value(node.operand)
            return Value(-found.values, found.unit, -found.rates) if isinstance(node.op, ast.USub) else found
        if isinstance(node, ast.BinOp):
            return self.binary(node)
        assert isinstance(node, ast.Call)
        assert isinstance(node.func, ast.Name)
        return self.call(node.func.id, [self.value(a) for a in node.args])

    @property
    def plain(self) -> Unit | None:
        return None if self.units is None else NONE

    @property
    def t(self) -> NDArray[np.float64]:
        t = np.ravel(self.variables["t"])
        return t[:, None] if self.of_cases else t

    def is_series(self, values: Any) -> bool:
        return bool(np.ndim(values) == 1 + self.of_cases)

    def unit_of(self, name: str, numbers: Sequence[int]) -> Unit | None:
        return None if self.units is None else self.units(name, numbers)

    def binary(self, node: ast.BinOp) -> Value:
        left = self.value(node.left)
        if isinstance(node.op, ast.MatMult):
            k = self.at(left.values, when(node.right, self.text))
            rates = left.rates
            if np.ndim(rates):  # of a sum with a number they have no axis of steps
                rates = np.broadcast_to(rates, (*np.shape(left.values), np.shape(rates)[-1]))[k]
            return Value(np.asarray(left.values[k]), left.unit, rates)
        right = self.value(node.right)
        if isinstance(node.op, (ast.Add, ast.Sub)):
            unit = of_sum(left.unit, right.unit, self.text)
        elif isinstance(node.op, ast.Pow):
            single = float(right.values) if right.values.ndim == 0 and np.isrealobj(right.values) else None
            unit = of_power(left.unit, right.unit, single, self.text)
        else:
            known = left.unit is not None and right.unit is not None
            sign = 1 if isinstance(node.op, ast.Mult) else -1
            unit = combine(left.unit or NONE, right.unit or NONE, sign) if known else None
        with np.errstate(all="ignore"):  # who asked reports what is not finite
            values = np.asarray(OPERATORS[type(node.op)](left.values, right.values))
            return Value(values, unit, self.rates_of(node.op, left, right))

    def rates_of(self, operator: ast.operator, left: Value, right: Value) -> Any:
        return 0.0

    def rates_of_call(self, name: str, values: Any, *arguments: Value) -> Any:
        return 0.0

    def call(self, name: str, arguments: list[Value]) -> Value:
        function = FUNCTIONS[name]
        unit = function.unit(name, [a.unit for a in arguments], self.text)
        try:
            with np.errstate(all="ignore"):
                given = [a.values for a in arguments]
                if function.over_steps and not self.is_series(given[0]):
                    given = [np.asarray(given[0])[None]]
                values = np.asarray(function.compute(*given))
                return Value(values, unit, self.rates_of_call(name, values, *arguments))
        except TypeError:  # of NumPy for a function of real numbers
            text = f"'{self.text}': {name} takes real numbers; write abs(), real() or imag() inside"
            raise UsageError(text, "expression.complex") from None

    def variable(self, node: ast.Subscript) -> Value:
        assert isinstance(node.value, ast.Name)
        name, numbers = ALIASES.get(node.value.id, node.value.id), indices(node, self.text)
        if name in X_NAMES or name in E_NAMES:
            table, words = (self.variables.lnp, NODE) if name in X_NAMES else (self.variables.le, ELEMENT)
            try:
                column = place(table, numbers[0], numbers[1], words)
            except UsageError as error:
                raise UsageError(f"'{self.text}': {error}", error.code) from None
            return Value(self.variables[name][:, column], self.unit_of(name, numbers))
        values = self.variables["eigval" if name == "frequency" else name]
        if name == "eigval":
            values = values[..., 0] + 1j * values[..., 1]
        elif name == "frequency":
            values = frequencies(values)
        if any(i > n for i, n in zip(numbers, values.shape[1:], strict=True)):
            size = " x ".join(map(str, values.shape[1:]))
            raise UsageError(f"'{self.text}': {name} has {size} values", "expression.number")
        column_of = (slice(None), *(i - 1 for i in numbers))
        return Value(values[column_of], self.unit_of(name, numbers))

    def at(self, series: Any, moment: str | int | float) -> int:
        t = np.ravel(self.t)
        if not self.is_series(series) or len(series) != len(t):
            raise UsageError(f"'{self.text}': @ stands behind a series, one value for every step", "expression.step")
        return step_at(t, moment, self.text)


def step_at(t: NDArray[np.float64], moment: str | int | float, text: str) -> int:
    """The step (from 0) of what stands after @, of steps at the times t. Raises UsageError."""
    if isinstance(moment, str):
        return 0 if moment == "start" else len(t) - 1
    if isinstance(moment, int):
        if not 1 <= moment <= len(t):
            raise UsageError(f"'{text}': step {moment} does not exist; there are {len(t)} steps", "expression.step")
        return moment - 1
    nearest = int(np.argmin(np.abs(t - moment)))
    if abs(t[nearest] - moment) > SAME_TIME * max(abs(float(t[-1])), 1e-300):
        text = f"'{text}': t = {moment:.9g} is not stored, the nearest is {t[nearest]:.9g}"
        text += f"; give the number of one of the {len(t)} steps, or to a motion another number of steps (TIMESTEP)"
        raise UsageError(text, "expression.step")
    return nearest


def frequency_order(values: NDArray[Any]) -> NDArray[np.int64]:
    """Places of the eigenvalues (n,), complex, that have a frequency of their own, from low to high: of a pair of
    complex ones the one with the positive imaginary part; real ones do not come in pairs."""
    own = np.flatnonzero(values.imag >= 0.0)
    return np.asarray(own[np.argsort(np.abs(values[own]), kind="stable")])


def frequencies(every: NDArray[Any]) -> NDArray[np.float64]:
    """(steps, n) |eigenvalue| / 2 pi [Hz] from low to high of stored eigenvalues (steps, m, 2); nan fills up steps
    with fewer."""
    values = every[..., 0] + 1j * every[..., 1]
    rows = [np.abs(v[frequency_order(v)]) / (2.0 * np.pi) for v in values]
    longest = max(map(len, rows))
    return np.array([np.pad(row, (0, longest - len(row)), constant_values=np.nan) for row in rows])
