"""Text, Unicode and LaTeX of scalars, vectors and dyads, as on paper: b1 n1, ṡ1, (n̂₁ × b̂₁).

Time is not printed: q1(t) is q1, its derivative q1_dot (text), q̇1 (Unicode) or a dot (LaTeX). Derivatives of fields
are written with subscripts, u_x, u_xt.
"""

import re
from collections.abc import Callable
from typing import Any, NamedTuple

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

from spacar.symbolic.unit_vectors import TIME, UnevaluatedCross, UnevaluatedDot, Unit, unit_latex

_SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def _derivative_name(expr: sp.Derivative, dot: str) -> str:
    """Name of d^n f / dt^n or of a field derivative: q_dot, u_xt."""
    function = expr.expr
    name = function.func.__name__
    if function.args == (TIME,):
        return name + dot * sum(n for _, n in expr.variable_count)
    letters = "".join(str(v) * int(n) for v, n in sorted(expr.variable_count, key=lambda p: p[0] == TIME))
    return f"{name}_{letters}"


class _Text(StrPrinter):
    def _print_Function(self, expr: Any) -> str:
        return expr.func.__name__ if isinstance(expr, AppliedUndef) else super()._print_Function(expr)

    def _print_Derivative(self, expr: sp.Derivative) -> str:
        return _derivative_name(expr, "_dot")


class _Unicode(_Text):
    printmethod = ""  # held products are printed by the methods below, not by their own plain text

    def _print_Derivative(self, expr: sp.Derivative) -> str:
        name = _derivative_name(expr, "\0")
        dots = name.count("\0")
        name = name.replace("\0", "")
        return name[0] + ("\u0307" if dots == 1 else "\u0308" if dots == 2 else "") + name[1:]

    def _print_Symbol(self, expr: sp.Symbol) -> str:
        name = expr.name
        return name[0] + "\u0307" + name[1:-4] if name.endswith("_dot") else name

    def _print_UnevaluatedDot(self, expr: UnevaluatedDot) -> str:
        return expr.form.replace(".", "·").format(*map(unit_unicode, expr.units))

    def _print_Pow(self, expr: sp.Pow, rational: bool = False) -> str:
        return super()._print_Pow(expr, rational).replace("**2", "²").replace("**3", "³")


class _Latex(LatexPrinter):
    def _print_Function(self, expr: Any, exp: str | None = None) -> str:
        if not isinstance(expr, AppliedUndef):
            return super()._print_Function(expr, exp)
        return symbol_latex(expr.func.__name__) + (f"^{{{exp}}}" if exp else "")

    def _print_Symbol(self, expr: sp.Symbol, style: str = "plain") -> str:
        return symbol_latex(expr.name)

    def _print_Derivative(self, expr: sp.Derivative) -> str:
        name = expr.expr.func.__name__
        if expr.expr.args != (TIME,):
            return symbol_latex(_derivative_name(expr, ""))
        accent = "dot" if sum(n for _, n in expr.variable_count) == 1 else "ddot"
        return rf"\{accent}{{{symbol_latex(name)}}}"


def symbol_latex(name: str) -> str:
    """q1 -> q_{1}, phi1_2 -> \\phi_{1,2}, s1_dot -> \\dot{s_{1}}."""
    if name.endswith("_dot"):
        return rf"\dot{{{symbol_latex(name[:-4])}}}"
    match = re.fullmatch(r"([A-Za-z]+?)_?(\d[\d_]*|_\w+)?", name)
    if not match:
        head, _, tail = name.partition("_")
        return rf"{head}_{{{tail}}}".replace("_{}", "") if tail else sp.latex(sp.Symbol(name))
    head, tail = match.groups()
    latex_head = sp.latex(sp.Symbol(head)) if len(head) > 1 else head
    return f"{latex_head}_{{{tail.strip('_').replace('_', ',')}}}" if tail else latex_head


def unit_unicode(u: Unit) -> str:
    symbol = u.frame.symbol
    return symbol[0] + "\u0302" + (symbol[1:] + str(u.index)).translate(_SUBSCRIPTS)


class _Style(NamedTuple):
    """How a unit vector, the sign of a cross product and scalars are written."""

    unit: Callable[[Unit], str]
    cross: str
    printer: Any


TEXT = _Style(str, " >< ", _Text)
UNICODE = _Style(unit_unicode, " × ", _Unicode)
LATEX = _Style(unit_latex, r" \times ", _Latex)


def _keys(key: Any, style: _Style) -> str:
    if isinstance(key, tuple):
        return " ".join(f"({_keys(k, style)})" if isinstance(k, UnevaluatedCross) else _keys(k, style) for k in key)
    if isinstance(key, UnevaluatedCross):
        return f"{_keys(key.a, style)}{style.cross}{_keys(key.b, style)}"
    return style.unit(key)


def _shown(value: Any, style: _Style) -> str:
    if not hasattr(value, "terms"):
        return str(style.printer().doprint(value))
    pieces: list[str] = []
    for key, coefficient in value.terms.items():
        name, factor = _keys(key, style), coefficient
        negative = not factor.is_Add and factor.could_extract_minus_sign()
        if negative:
            factor = -factor
        scalar = _shown(factor, style)
        piece = name if factor == 1 else f"({scalar}) {name}" if factor.is_Add else f"{scalar} {name}"
        pieces += ["-" if negative else "+", piece]
    if not pieces:
        return "0"
    return ("-" if pieces[0] == "-" else "") + " ".join(pieces[1:])


def text(value: Any) -> str:
    """Plain ASCII text of a scalar, vector or dyad.

    >>> from sympy.physics.vector import dynamicsymbols
    >>> print(text(dynamicsymbols("s1").diff() + sp.Symbol("x")))
    x + s1_dot
    """
    return _shown(value, TEXT)


def unicode(value: Any) -> str:
    """Text with hats, dots and subscripts for terminals and notebooks."""
    return _shown(value, UNICODE)


def latex(value: Any) -> str:
    """LaTeX of a scalar, vector or dyad.

    >>> from spacar.symbolic.reference_frames import ReferenceFrame
    >>> N, B = ReferenceFrame("N", "n"), ReferenceFrame("B1", "b1")
    >>> print(latex(N[1] ^ B[2]))
    \\hat{n}_{1} \\times \\hat{b}_{12}
    """
    return _shown(value, LATEX)
