"""Shape functions of assumed fields and exact integrals over a beam.

A family of shapes is a function of (x, L) that gives a tuple of expressions, so that one family serves any beam.
Polynomial integrands are integrated term by term, c x^n -> c L^(n+1)/(n+1); other shapes must depend on x/L only,
and their integrals are numbers found by quadrature to 30 digits (`symbolic.md`, sections 3.4 and 4.3).
"""

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

import mpmath  # type: ignore[import-untyped]
import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.unit_vectors import TIME, Scalars

X = sp.Symbol("x", real=True)
"""The coordinate along a beam [m]."""

Shapes = Callable[[sp.Expr, sp.Expr], Scalars]


def monomial(*exponents: int) -> Shapes:
    """x^n / L^m with m the largest exponent: the field of the paper for exponents 2, 3, 4 (its equation (10)).

    >>> monomial(2, 3, 4)(X, sp.Symbol("L"))[0]
    x**2/L**4
    """
    return lambda x, L: tuple(x**n / L ** max(exponents) for n in exponents)


def orthogonal(number: int, clamped: int = 2) -> Shapes:
    """Polynomials orthogonal in ∫ψψ dx, ψ(L) = 1, with `clamped` vanishing derivatives (0, 1, …) at the root.

    Clamped = 2 for bending, 1 for torsion and stretch. Rational coefficients; the default of new models, because
    rounding noise is one to two orders smaller than with monomials.

    >>> orthogonal(2)(X, sp.Integer(1))
    (x**2, 6*x**3 - 5*x**2)
    """
    return _family(number, lambda xi, k: xi ** (clamped + k), lambda p: p.eval(1))


def pinned(number: int) -> Shapes:
    """Polynomials orthogonal in ∫ψψ dx that vanish at both ends: the frame follows the chord, both ends may turn.

    >>> pinned(1)(X, sp.Integer(1))
    (-4*x**2 + 4*x,)
    """
    return _family(number, lambda xi, k: xi * (1 - xi) * xi**k, fixed=1)


def guided(number: int) -> Shapes:
    """Polynomials with u(0) = u'(0) = u'(L) = 0: clamped at the root, the tip does not turn relative to the frame."""
    return _family(number, lambda xi, k: xi ** (2 + k) * ((3 + k) - (2 + k) * xi), fixed=2)


def free(number: int) -> Shapes:
    """Polynomials orthogonal in ∫ψψ dx to each other and to 1 and x: the frame follows the mean motion of the beam.

    Nothing is fixed at the root, which is then the origin of the frame and no point of the beam; use `section(0)`.
    """
    return _family(number, lambda xi, k: sp.legendre(k + 2, 2 * xi - 1), fixed=0)


def _largest(p: sp.Poly) -> sp.Expr:
    return max(abs(p.eval(sp.Rational(i, 8))) for i in range(9))


def _family(
    number: int, member: Callable[[sp.Symbol, int], sp.Expr], size: Callable[[sp.Poly], sp.Expr] = _largest,
    fixed: int | None = None,
) -> Shapes:  # fmt: skip
    """Orthogonalized members over their size; `fixed` derivatives vanish at the root, if the shapes do not say it."""
    xi = sp.Symbol("xi")
    basis: list[sp.Poly] = []
    for k in range(number):
        p = sp.Poly(sp.expand(member(xi, k)), xi)
        for q in basis:
            p = p - q * (_unit_integral(p * q) / _unit_integral(q * q))
        basis.append(p)
    basis = [p * (1 / size(p)) for p in basis]

    def family(x: sp.Expr, L: sp.Expr) -> Scalars:
        return tuple(sp.expand(p.as_expr().subs(xi, x / L)) for p in basis)

    if fixed is not None:
        family.fixed = fixed  # type: ignore[attr-defined]
    return family


FAMILIES = {"pinned": pinned, "guided": guided, "free": free}


def _unit_integral(p: sp.Poly) -> sp.Expr:
    return sp.Add(*(c / (n + 1) for (n,), c in p.terms()))


def cantilever(number: int) -> Shapes:
    """Bending modes of a uniform cantilever, ψ(L) = 1 or −1: cosh kξ − cos kξ − σ (sinh kξ − sin kξ), halved."""
    z = sp.Symbol("z")
    guesses = [1.8751, *(sp.pi.evalf() * (n - sp.Rational(1, 2)) for n in range(2, number + 1))]
    roots = [sp.nsolve(sp.cos(z) + 1 / sp.cosh(z), z, guess, prec=34) for guess in guesses[:number]]

    def family(x: sp.Expr, L: sp.Expr) -> Scalars:
        modes = []
        for k in roots:
            sigma = (sp.cosh(k) + sp.cos(k)) / (sp.sinh(k) + sp.sin(k))
            z = k * x / L
            modes.append((sp.cosh(z) - sp.cos(z) - sigma * (sp.sinh(z) - sp.sin(z))) / 2)
        return tuple(modes)

    return family


def shape_functions(field: Any, L: sp.Expr, clamped: int) -> Scalars:
    """The shapes that `field` stands for: a family, a number of default shapes, or expressions in x.

    Raises UsageError for a shape that violates the essential conditions ψ(0) = 0 (and ψ'(0) = 0 for bending).
    """
    if isinstance(field, int):
        field = orthogonal(field, clamped)
    clamped = min(clamped, getattr(field, "fixed", clamped))
    shapes: Sequence[Any] = field(X, L) if callable(field) else field
    result = tuple(sp.sympify(psi).xreplace({sp.Symbol("x"): X}) for psi in shapes)
    conditions = "u(0) = u'(0) = 0" if clamped == 2 else "u(0) = 0"
    for psi in result:
        values = [sp.nsimplify(psi.diff(X, n).subs(X, 0)) if n else psi.subs(X, 0) for n in range(clamped)]
        if any(abs(v.xreplace({s: sp.S.One for s in v.free_symbols}).evalf()) > 1e-12 for v in values):
            raise UsageError(f"field {psi} does not satisfy {conditions}", "field")
    return result


Powers = tuple[tuple[int, Fraction], ...]
"""A polynomial in x/L with rational coefficients: (exponent, coefficient)."""


@lru_cache(maxsize=4096)
def _dimensionless(f: sp.Expr, L: sp.Expr) -> tuple[sp.Expr, Powers] | None:
    """(c, p) with f(x) = c p(x/L), p(ξ) = … + ξ^n with rational coefficients; None when f is no such polynomial."""
    rows: dict[int, list[sp.Expr]] = {}
    for term in sp.Add.make_args(sp.expand(f)):
        coefficient, power = term.as_independent(X, as_Add=False)
        base, n = power.as_base_exp()
        if power == 1:
            n = sp.S.Zero
        elif base != X or not (n.is_Integer and n > 0):
            return None
        rows.setdefault(int(n), []).append(coefficient * L**n)
    sums = {n: sp.Add(*terms) for n, terms in rows.items()}
    scale = sums[max(sums)]
    ratios = {n: c / scale if scale != 0 else c for n, c in sums.items()}
    ratios = {n: r if r.is_Rational else sp.cancel(r) for n, r in ratios.items()}
    if not all(r.is_Rational for r in ratios.values()):
        return None
    return scale, tuple((n, Fraction(int(r.p), int(r.q))) for n, r in sorted(ratios.items()))


def product_integral(f: sp.Expr, g: sp.Expr, L: sp.Expr, end: sp.Expr | None = None) -> sp.Expr:
    """∫ f g dx from 0 to `end` (L): where both are polynomials their scales times the dimensionless primitive."""
    end = L if end is None else end
    a, b = _dimensionless(sp.sympify(f), L), _dimensionless(sp.sympify(g), L)
    if a is None or b is None:
        return integral(f * g, X, end)
    terms = ((n + m + 1, c * d) for n, c in a[1] for m, d in b[1])
    return a[0] * b[0] * L * sp.Add(*(sp.Rational(c / n) * (end / L) ** n for n, c in terms))


def weighted_integral(weight: sp.Expr, f: sp.Expr, g: sp.Expr, L: sp.Expr) -> sp.Expr:
    """∫ weight f g dx from 0 to L; the weight may depend on x (a tapered beam)."""
    if weight.has(X):
        return product_integral(sp.expand(weight * f), g, L)
    return weight * product_integral(f, g, L)


def integral(integrand: sp.Expr, x: sp.Symbol, L: sp.Expr) -> sp.Expr:
    """∫ from 0 to L of an integrand that is a polynomial in x, or a sum of f(x/L)·x^n with numerical f.

    >>> rho, L = sp.symbols("rho L")
    >>> integral(rho * X**2, X, L)
    L**3*rho/3
    """
    integrand = sp.expand(integrand)
    if integrand == 0:
        return sp.S.Zero
    if integrand.is_polynomial(x):
        return sp.Add(*(c * L ** (n + 1) / (n + 1) for (n,), c in sp.Poly(integrand, x).terms()))
    xi = sp.Symbol("xi", positive=True)
    total = sp.S.Zero
    for term in sp.Add.make_args(sp.expand(integrand.xreplace({x: L * xi}))):
        coefficient, shape = term.as_independent(xi, as_Add=False)
        if shape.free_symbols - {xi}:
            raise UsageError(f"shape integral of {shape} depends on more than x/L", "field")
        total += coefficient * L * _quadrature(shape, xi)
    return total


@lru_cache(maxsize=4096)
def _quadrature(shape: sp.Expr, xi: sp.Symbol) -> sp.Expr:
    if shape.is_polynomial(xi):
        return _unit_integral(sp.Poly(shape, xi))
    with mpmath.workdps(34):
        function = sp.lambdify(xi, shape, "mpmath")
        return sp.Float(mpmath.quad(function, mpmath.linspace(0, 1, 5)), 30)


def field_function(name: str) -> sp.Expr:
    """The symbol u(x, t) of a field."""
    return sp.Function(name, real=True)(X, TIME)
