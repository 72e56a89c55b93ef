"""Recurrence (Z variables) and collection functions: exact rewrites that make equations shorter.

Every function f satisfies expand(x − f(x)) = 0, which is how it is tested. Source: the paper, section 2.2 and
tables 11, 14; `symbolic.md`, section 4.2. `simplify` and `trigsimp` are never used: too slow on whole equations.
"""

from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import sympy as sp
from sympy.utilities.iterables import sift

from spacar.symbolic.derivatives import Recurrence
from spacar.symbolic.splitting import LinearSplit, common_factors
from spacar.symbolic.unit_vectors import UnevaluatedDot, Unit
from spacar.symbolic.vectors import Dyad, Vector

Value = TypeVar("Value", sp.Expr, Vector, Dyad)


class ZTable:
    """Ordered table expression -> Z variable. Equal and opposite expressions are found again.

    `forbidden` are the accelerations: a Z is a memory read that must not contain them (ValueError).

    >>> x, y = sp.symbols("x y"); table = ZTable()
    >>> table.read(x * y + 1), table.read(-x * y - 1), table.read(x * y + 1), table.read(-x)
    (Z1, -Z1, Z1, -x)
    """

    def __init__(self, prefix: str = "Z", forbidden: Iterable[sp.Basic] = ()) -> None:
        self.prefix = prefix
        self.forbidden = frozenset(forbidden)
        self.definitions: dict[sp.Symbol, sp.Expr] = {}
        self._symbols: dict[sp.Expr, sp.Expr] = {}

    def read(self, expression: Any, name: str | None = None) -> sp.Expr:
        """The memory read that stands for `expression`; a number, a symbol or minus a symbol stands for itself."""
        expression = sp.sympify(expression)
        if name is None and (expression.is_number or _is_read(expression)):
            return expression
        if expression in self._symbols:
            return self._symbols[expression]
        if -expression in self._symbols:
            return -self._symbols[-expression]
        if self.forbidden and not self.forbidden.isdisjoint(expression.free_symbols | expression.atoms(sp.Derivative)):
            raise ValueError(f"a Z variable must not contain accelerations: {expression}")
        symbol = Recurrence(name or f"{self.prefix}{len(self.definitions) + 1}", real=True)
        if symbol in self.definitions:
            raise ValueError(f"the Z variable {symbol} is already defined")
        self.definitions[symbol] = expression
        self._symbols[expression] = symbol
        return symbol

    def expand(self, value: Value) -> Value:
        """Put the definitions back in: the expression without any Z of this table."""
        for symbol, definition in reversed(self.definitions.items()):
            value = value.xreplace({symbol: definition})
        return value

    def __len__(self) -> int:
        return len(self.definitions)


def _is_read(expression: sp.Expr) -> bool:
    if expression.is_Mul and len(expression.args) == 2 and expression.args[0] == -1:
        expression = expression.args[1]
    return bool(expression.is_Symbol or (expression.is_Function and not expression.args[0].is_Add))


def read_measure_numbers(vector: Vector, table: ZTable, accelerations: Iterable[sp.Symbol]) -> Vector:
    """Replace, in every measure number, the part without accelerations by one Z (table 11 of the paper).

    With t1 = −q ṡ − 2 s v: the measure number becomes Z1 − q ṡ.

    >>> q, s, v, sdot = sp.symbols("q s v sdot"); from spacar.symbolic.reference_frames import ReferenceFrame
    >>> table = ZTable(forbidden=[sdot])
    >>> print(read_measure_numbers((-q * sdot - 2 * s * v) * ReferenceFrame("B")[1], table, [sdot]))
    (Z1 - q*sdot) b1
    """
    return vector.map(lambda c: read_scalar(c, table, accelerations))


def read_scalar(expression: sp.Expr, table: ZTable, accelerations: Iterable[sp.Symbol]) -> sp.Expr:
    """Coefficient of every acceleration and the rest become Z variables: Σ Z_j a_j + Z_0."""
    accelerations = list(accelerations)
    coefficients, rest = split_linear(expression, accelerations)
    parts = [table.read(gather_scalars(c)) * a for a, c in zip(accelerations, coefficients, strict=True) if c != 0]
    return sp.Add(*parts, table.read(gather_scalars(rest)))


def split_linear(expression: sp.Expr, symbols: Iterable[sp.Basic]) -> tuple[list[sp.Expr], sp.Expr]:
    """Coefficients and rest of an expression that is linear in `symbols` (ValueError otherwise)."""
    symbols = list(symbols)
    found, rest = LinearSplit(symbols)(expression)
    return [found.get(s, sp.S.Zero) for s in symbols], rest


def gather_vectors(value: Value) -> Value:
    """One measure number per direction, common factors in front; shared axes of turned frames are merged.

    >>> from spacar.symbolic.reference_frames import ReferenceFrame
    >>> q, a, b = sp.symbols("q a b"); N = ReferenceFrame("N"); B = N.turned("B", 3, q)
    >>> print(gather_vectors(a * N[3] + (a * b + a) * B[3]))
    a*(b + 2) b3
    """
    if isinstance(value, Vector):
        latest: dict[Any, Unit] = {}
        for key in value.terms:
            if isinstance(key, Unit):
                latest[key.frame.directions[key.index]] = key
        value = Vector.collect(
            (latest[key.frame.directions[key.index]] if isinstance(key, Unit) else key, c)
            for key, c in value.terms.items()
        )
    return _each(value, lambda c: common_factors(sp.expand(c)))


def gather_dots(value: Value) -> Value:
    """Collect on the held dots and triple products.

    >>> from spacar.symbolic.reference_frames import ReferenceFrame
    >>> a, b = sp.symbols("a b"); N, B = ReferenceFrame("N"), ReferenceFrame("B"); d = N[1] & B[1]
    >>> gather_dots(a * d + b * d)
    (a + b)*n1.b1
    """

    def collect(c: sp.Expr) -> sp.Expr:
        if not c.has(UnevaluatedDot):
            return c
        parts: dict[sp.Expr, list[sp.Expr]] = {}
        for term in sp.Add.make_args(sp.expand(c)):
            held, scalars = sift(sp.Mul.make_args(term), lambda f: f.has(UnevaluatedDot), binary=True)
            parts.setdefault(sp.Mul(*held), []).append(sp.Mul(*scalars))
        return sp.Add(*(dots * common_factors(sp.Add(*coefficients)) for dots, coefficients in parts.items()))

    return _each(value, collect)


def gather_scalars(value: Value, symbols: Iterable[sp.Expr] = ()) -> Value:
    """Collect on the given symbols (speeds), then take common factors out of every sum."""
    symbols = list(symbols)
    return _each(value, lambda c: common_factors(sp.collect(sp.expand(c), symbols) if symbols else c))


def _each(value: Value, function: Any) -> Value:
    if isinstance(value, (Vector, Dyad)):
        result: Value = value.map(function)
        return result
    return function(sp.sympify(value))


def definition_order(definitions: Mapping[sp.Symbol, sp.Expr], results: Iterable[sp.Expr]) -> dict[sp.Symbol, sp.Expr]:
    """Those of the definitions that `results` need, each after everything that it reads."""
    order: dict[sp.Symbol, sp.Expr] = {}
    stack: list[tuple[sp.Symbol, bool]] = []
    for result in results:
        stack += [(s, False) for s in sorted(result.free_symbols & definitions.keys(), key=str, reverse=True)]
        while stack:
            symbol, ready = stack.pop()
            if ready:
                order[symbol] = definitions[symbol]
            elif symbol not in order:
                stack.append((symbol, True))
                needed = definitions[symbol].free_symbols & definitions.keys()
                stack += [(s, False) for s in sorted(needed, key=str, reverse=True) if s not in order]
    return order
