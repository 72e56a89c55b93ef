"""Scalar expressions as program text: the printers of SymPy for Python, C99 and Fortran with our names and numbers.

Numbers are folded (1/3 is one literal) and small powers are products, so that the three languages carry out the same
operations. sign(0) is 0 in all of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.printing.c import C99CodePrinter
from sympy.printing.fortran import FCodePrinter
from sympy.printing.pycode import PythonCodePrinter

from spacar.errors import UsageError
from spacar.symbolic.unit_vectors import TIME


@dataclass(frozen=True)
class Language:
    """The printer of a language, its settings, its reserved words, and its text for x**n with n of 2 to 4."""

    name: str
    printer: Any
    settings: dict[str, Any]
    small_power: str
    reserved: frozenset[str]


_COMMON = ["sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "sqrt"]
_FUNCTIONS = [*_COMMON, "Abs", "sign", "Min", "Max", "Piecewise"]
_NAMES = [f.lower() for f in _FUNCTIONS]

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
    return frozenset([*_RESERVED[name].split(), *_NAMES])


class _Scalars:
    """What the printers of the languages share; `writer` is set by `Writer`."""

    writer: Writer

    def _print_Symbol(self, e: sp.Symbol) -> str:
        return self.writer.add(e)

    def _print_Float(self, e: sp.Expr) -> str:
        return self.writer.number(e)

    _print_Integer = _print_Rational = _print_Half = _print_One = _print_Zero = _print_NegativeOne = _print_Float
    _print_Pi = _print_Exp1 = _print_NumberSymbol = _print_Float

    def _print_Pow(self, e: sp.Pow, rational: bool = False) -> str:
        base, exponent = e.as_base_exp()
        if exponent in (2, 3, 4):
            if base.is_Symbol:
                return f"({'*'.join([self.writer.add(base)] * int(exponent))})"
            return self.writer.language.small_power.format(self.writer(base), int(exponent))
        text: str = super()._print_Pow(e)  # type: ignore[misc]
        return text

    def _print_sign(self, e: sp.Expr) -> str:
        x = self.writer(e.args[0])
        return f"(({x} > 0) - ({x} < 0))"


class _Python(_Scalars, PythonCodePrinter):
    pass


class _C(_Scalars, C99CodePrinter):
    pass


class _Fortran(_Scalars, FCodePrinter):
    def _print_sign(self, e: sp.Expr) -> str:
        x = self.writer(e.args[0])
        return f"(merge(1.0d0, 0.0d0, {x} > 0) - merge(1.0d0, 0.0d0, {x} < 0))"


PYTHON = Language("python", _Python, {"fully_qualified_modules": False}, "(({0})**{1})", _reserved("python"))
C = Language("c", _C, {}, "power_{1}({0})", _reserved("c"))
_FREE = {"source_format": "free", "standard": 2008, "name_mangling": False}
FORTRAN = Language("fortran", _Fortran, _FREE, "(({0})**{1})", _reserved("fortran"))


class Writer:
    """Expressions of one program in one language, with its own table of legal unique names."""

    def __init__(self, language: Language, symbols: Iterable[sp.Symbol]) -> None:
        self.language = language
        self.names: dict[sp.Symbol, str] = {TIME: "t"}
        self.taken = set(language.reserved)
        self.printer = language.printer(language.settings)
        self.printer.writer = self
        for s in symbols:
            self.add(s)

    def add(self, symbol: sp.Symbol) -> str:
        """The name of a symbol: no keyword, unique without regard to case, at most 63 characters."""
        if symbol not in self.names:
            base = re.sub(r"[^0-9A-Za-z_]", "_", symbol.name)[:55]
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
        """The text of an expression. UsageError for a function that is not in all languages."""
        strange = sorted({f.func.__name__ for f in e.atoms(sp.Function, AppliedUndef)} - {*_FUNCTIONS})
        if strange:
            raise UsageError(f"cannot write {e} in {self.language.name}: it has no {strange[0]}")
        if e.is_number:
            return self.number(e)
        text: str = self.printer._print(e)
        return text
