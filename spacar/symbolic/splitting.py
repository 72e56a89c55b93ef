"""Splitting of expressions by what they are linear in, and common factors of sums: exact, one walk through the tree.

SymPy's `diff`, `collect` and `factor_terms` give the same; on equations of motion they take nearly all of the time.
"""

from collections.abc import Iterable
from functools import lru_cache
from math import gcd, lcm

import sympy as sp


class LinearSplit:
    """Coefficients of `symbols` (any atoms or functions of time) in expressions that are linear in them.

    >>> x, y, a = sp.symbols("x y a")
    >>> LinearSplit([x, y])(a * (x - 2 * y) + a)
    ({x: a, y: -2*a}, a)
    """

    def __init__(self, symbols: Iterable[sp.Basic]) -> None:
        self.symbols = frozenset(symbols)
        self._touched: dict[sp.Basic, bool] = {}

    def __call__(self, expression: sp.Expr) -> tuple[dict[sp.Basic, sp.Expr], sp.Expr]:
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


def _factors(term: sp.Expr) -> tuple[sp.Expr, dict[sp.Expr, sp.Expr]]:
    """(number, {base: rational exponent}) of a product."""
    number, factors = term.as_coeff_Mul()
    powers: dict[sp.Expr, sp.Expr] = {}
    for factor in sp.Mul.make_args(factors):
        base, exponent = factor.as_base_exp()
        if not exponent.is_Rational or base.is_number:
            base, exponent = factor, sp.S.One
        if base != 1:
            powers[base] = powers.get(base, sp.S.Zero) + exponent
    return number, powers


def _product(powers: dict[sp.Expr, sp.Expr]) -> sp.Expr:
    return sp.Mul(*(base**n for base, n in powers.items()))
