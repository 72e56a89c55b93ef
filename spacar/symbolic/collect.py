"""Recurrence (Z variables) and collection functions: exact rewrites that make equations shorter.

Every function f satisfies expand(x − f(x)) = 0, which is how it is tested. Source: the paper, section 2.2 and
tables 11, 14; `symbolic.md`, section 4.2. `simplify` and `trigsimp` are never used: too slow on whole equations.
`LinearSplit` and `common_factors` are one walk through a tree; SymPy's `diff` and `factor_terms` give the same slowly.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from math import gcd, lcm
from typing import Any, TypeVar

import sympy as sp
from sympy.utilities.iterables import sift

from spacar.symbolic.reference_frames import Recurrence
from spacar.symbolic.unit_vectors import ByExpression, Definitions, Rule, UnevaluatedDot, Unit
from spacar.symbolic.vectors import Dyad, Vector

Value = TypeVar("Value", sp.Expr, Vector, Dyad)


class ZTable:
    """Ordered table expression -> Z variable. Equal and opposite expressions are found again.

    `forbidden` are the accelerations: a Z is a memory read that must not contain them (ValueError).

    >>> x, y = sp.symbols("x y"); table = ZTable()
    >>> table.read(x * y + 1), table.read(-x * y - 1), table.read(x * y + 1), table.read(-x)
    (Z1, -Z1, Z1, -x)
    """

    def __init__(self, *, forbidden: Iterable[sp.Basic] = ()) -> None:
        self.forbidden = frozenset(forbidden)
        self.definitions: Definitions = {}
        self._symbols: ByExpression = {}

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
        symbol = Recurrence(name or f"Z{len(self.definitions) + 1}", real=True)
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


def read_scalar(expression: sp.Expr, table: ZTable, accelerations: Sequence[sp.Symbol]) -> sp.Expr:
    """Coefficient of every acceleration and the rest become Z variables (table 11 of the paper): Σ Z_j a_j + Z_0.

    >>> q, s, v, sdot = sp.symbols("q s v sdot"); table = ZTable(forbidden=[sdot])
    >>> read_scalar(-q * sdot - 2 * s * v, table, [sdot])
    Z1 - q*sdot
    """
    found, rest = LinearSplit(accelerations)(expression)
    parts = [table.read(gather_scalars(found[a])) * a for a in accelerations if a in found]
    return sp.Add(*parts, table.read(gather_scalars(rest)))


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
        return value.map(function)
    return function(sp.sympify(value))


def definition_order(definitions: Mapping[sp.Symbol, sp.Expr], results: Iterable[sp.Expr]) -> Definitions:
    """Those of the definitions that `results` need, each after everything that it reads."""
    order: Definitions = {}
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


class LinearSplit:
    """Coefficients of `symbols` (any atoms or functions of time) in expressions that are linear in them.

    >>> x, y, a = sp.symbols("x y a")
    >>> LinearSplit([x, y])(a * (x - 2 * y) + a)
    ({x: a, y: -2*a}, a)
    """

    def __init__(self, symbols: Iterable[sp.Basic]) -> None:
        self.symbols = frozenset(symbols)
        self._touched: dict[sp.Basic, bool] = {}

    def __call__(self, expression: sp.Expr) -> tuple[Rule, sp.Expr]:
        """({symbol: coefficient}, rest); ValueError when the expression is not linear in the symbols."""
        parts = self._parts(expression)
        found = {key: sp.Add(*terms) for key, terms in parts.items()}
        rest = found.pop(None, sp.S.Zero)
        return {s: c for s, c in found.items() if s is not None and c != 0}, rest

    def touches(self, expression: sp.Basic) -> bool:
        known = self._touched.get(expression)
        if known is None:
            known = expression in self.symbols or any(map(self.touches, expression.args))
            self._touched[expression] = known
        return known

    def _parts(self, e: sp.Expr) -> dict[sp.Basic | None, list[sp.Expr]]:
        if not self.touches(e):
            return {None: [e]}
        if e in self.symbols:
            return {e: [sp.S.One]}
        if e.is_Add:
            total: dict[sp.Basic | None, list[sp.Expr]] = {}
            for term in e.args:
                for key, values in self._parts(term).items():
                    total.setdefault(key, []).extend(values)
            return total
        moving = [a for a in e.args if self.touches(a)]
        if not e.is_Mul or len(moving) > 1:
            raise ValueError(f"not linear in {', '.join(map(str, self.symbols))}: {e}")
        others = sp.Mul(*(a for a in e.args if a is not moving[0]))
        return {key: [others * sp.Add(*values)] for key, values in self._parts(moving[0]).items()}


@lru_cache(maxsize=8192)
def common_factors(expression: sp.Expr) -> sp.Expr:
    """Powers that all terms of a sum have, and then their common number, in front of it; the innermost sums first.

    >>> a, b, L = sp.symbols("a b L")
    >>> common_factors(2 * a * L**2 + 4 * a * b * L**3)
    2*L**2*a*(2*L*b + 1)
    """
    if expression.is_Mul:
        return sp.Mul(*map(common_factors, expression.args))
    if expression.is_Pow:
        return sp.Pow(common_factors(expression.base), expression.exp)
    if not expression.is_Add:
        return expression
    terms = [_factors(common_factors(term)) for term in expression.args]
    shared = dict(terms[0][1])
    for _, powers in terms[1:]:
        shared = {base: _between(n, powers.get(base, sp.S.Zero)) for base, n in shared.items() if base in powers}
    shared = {base: n for base, n in shared.items() if n != 0}
    if not shared:
        return sp.Add(*(c * _product(powers) for c, powers in terms))
    numbers = [c for c, _ in terms]
    number = sp.S.One
    if all(c.is_Rational for c in numbers):
        number = sp.Rational(gcd(*(int(c.p) for c in numbers)), lcm(*(int(c.q) for c in numbers)))
        if all(c < 0 for c in numbers):
            number = -number
    rest = [(c / number, {b: n - shared.get(b, 0) for b, n in powers.items()}) for c, powers in terms]
    return sp.Mul(number, _product(shared), sp.Add(*(c * _product(powers) for c, powers in rest)))


def _between(a: sp.Expr, b: sp.Expr) -> sp.Expr:
    """The exponent that is nearer to zero, zero when the signs differ."""
    return sp.S.Zero if a * b < 0 else min(a, b, key=abs)


def _factors(term: sp.Expr) -> tuple[sp.Expr, ByExpression]:
    """(number, {base: rational exponent}) of a product."""
    number, factors = term.as_coeff_Mul()
    powers: ByExpression = {}
    for factor in sp.Mul.make_args(factors):
        base, exponent = factor.as_base_exp()
        if not exponent.is_Rational or base.is_number:
            base, exponent = factor, sp.S.One
        if base != 1:
            powers[base] = powers.get(base, sp.S.Zero) + exponent
    return number, powers


def _product(powers: ByExpression) -> sp.Expr:
    return sp.Mul(*(base**n for base, n in powers.items()))
