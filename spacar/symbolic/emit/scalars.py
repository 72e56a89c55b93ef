"""Scalar expressions as program text: one small printer and a table of what differs between the languages.

Numbers are folded (1/3 is one literal), small powers are products, negative powers are divisions, so that the three
languages carry out the same operations.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.units import TIME


@dataclass(frozen=True)
class Language:
    """What the printer must know: names of functions, reserved words, the power of a bracket."""

    name: str
    functions: dict[str, str]
    power: str
    small_power: str
    reserved: frozenset[str]


_COMMON = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log")
_SAME = {f: f for f in _COMMON} | {"sqrt": "sqrt"}

_RESERVED = {
    "python": """and as assert async await break class continue def del elif else except false finally for from global
        if import in is lambda none nonlocal not or pass raise return true try while with yield math float abs sqrt
        t y u m j a f p np rhs jac accel outputs inputs feeds parameters low h force constrained dependent manifold""",
    "c": """auto break case char const continue default do double else enum extern float for goto if inline int long
        register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
        main t y u m f p c h i j k n a ydot out jac accel rhs fabs pow j0 j1 y0 y1 jn yn gamma np nc nq ny nu nout
        nm ng l res turn outputs manifold constrained solve""",
    "fortran": """program module subroutine function end do if then else call use implicit none real integer contains
        bind intent in out return stop where select case data p y u m f c t ydot dp abs max min
        j h a res turn""",
}


def _reserved(name: str) -> frozenset[str]:
    return frozenset([*_RESERVED[name].split(), *_SAME])


PYTHON = Language("python", _SAME | {"Abs": "abs"}, "({0})**{1}", "({0})**{1}", _reserved("python"))
C = Language("c", _SAME | {"Abs": "fabs"}, "pow({0}, {1})", "power_{1}({0})", _reserved("c"))
FORTRAN = Language("fortran", _SAME | {"Abs": "abs"}, "({0})**({1})", "({0})**{1}", _reserved("fortran"))


class Writer:
    """Expressions of one program in one language, with its own table of legal unique names."""

    def __init__(self, language: Language, symbols: Iterable[sp.Symbol]) -> None:
        self.language = language
        self.names: dict[sp.Symbol, str] = {TIME: "t"}
        self.taken = set(language.reserved)
        for s in symbols:
            self.add(s)

    def add(self, symbol: sp.Symbol) -> str:
        """The name of a symbol: no keyword, unique without regard to case, at most 63 characters."""
        if symbol not in self.names:
            base = re.sub(r"\W", "_", symbol.name)[:55]
            if re.fullmatch(r"(a|b|l|v|force)(_\d+)+|feed_.*", base):  # what the programs call their own unknowns
                base = f"{base}_"
            if not base[:1].isalpha():
                base = f"v{base}"
            name, number = base, 1
            while name.lower() in self.taken:
                number += 1
                name = f"{base}__{number}"
            self.taken.add(name.lower())
            self.names[symbol] = name
        return self.names[symbol]

    def number(self, value: Any) -> str:
        """A double precision literal that reads back exactly."""
        text = repr(float(value))
        if self.language.name == "fortran":
            return text.replace("e", "d") if "e" in text else text + "d0"
        return text

    def __call__(self, e: sp.Expr) -> str:
        if e.is_Symbol:
            return self.add(e)
        if e.is_number and e.is_real:
            return self.number(e) if e >= 0 else f"(-{self.number(-e)})"
        if e.is_Add:
            return self._sum(e)
        if e.is_Mul:
            return self._product(e)
        if e.is_Pow or isinstance(e, sp.exp):
            return self._power(e)
        if e.is_Function and e.func.__name__ in self.language.functions:
            name = self.language.functions[e.func.__name__]
            return f"{name}({', '.join(map(self, e.args))})"
        raise UsageError(f"cannot write {e} in {self.language.name}")

    def _sum(self, e: sp.Expr) -> str:
        text = ""
        for term in e.as_ordered_terms():
            negative = term.could_extract_minus_sign()
            piece = self(-term if negative else term)
            if not text:
                text = f"-{piece}" if negative else piece
            else:
                text += f" - {piece}" if negative else f" + {piece}"
        return text

    def _factor(self, e: sp.Expr) -> str:
        return f"({self(e)})" if e.is_Add else self(e)

    def _product(self, e: sp.Expr) -> str:
        coefficient, rest = e.as_coeff_Mul()
        above, below = [], []
        for factor in sp.Mul.make_args(rest):
            base, exponent = factor.as_base_exp()
            if exponent.is_Rational and exponent < 0:
                below.append(base**-exponent)
            else:
                above.append(factor)
        sign = "-" if coefficient < 0 else ""
        numbers = [] if abs(coefficient) == 1 else [self.number(abs(coefficient))]
        top = "*".join([*numbers, *map(self._factor, above)]) or self.number(1)
        bottom = "*".join(map(self._factor, below))
        if bottom:
            single = len(below) == 1 and "*" not in bottom and "/" not in bottom
            top += f"/{bottom}" if single else f"/({bottom})"
        return f"({sign}{top})" if sign else top

    def _power(self, e: sp.Expr) -> str:
        if isinstance(e, sp.exp):
            return f"{self.language.functions['exp']}({self(e.args[0])})"
        base, exponent = e.as_base_exp()
        if exponent.is_Rational and exponent < 0:
            return f"{self.number(1)}/({self._factor(base**-exponent)})"
        if exponent == sp.Rational(1, 2):
            return f"{self.language.functions['sqrt']}({self(base)})"
        if exponent.is_Integer and base.is_Symbol and exponent <= 4:
            return "*".join([self.add(base)] * int(exponent))
        if exponent.is_Integer and exponent <= 4:
            return self.language.small_power.format(self(base), exponent)
        if exponent.is_Integer and self.language.name != "c":
            return self.language.small_power.format(self(base), exponent)
        return self.language.power.format(self(base), self(exponent))
