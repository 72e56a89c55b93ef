"""Moments of a deformed beam, ∫ρ a_i b_j dx of vectors that are polynomials in the field coordinates.

A component is kept as {monomial in φ, dφ: function of x}. The integral of a product then needs one short integral
∫ρ a(x) b(x) dx for every pair of functions, each found once; nothing long is ever expanded.
"""

from collections.abc import Callable, Iterable

import sympy as sp

from spacar.symbolic.beam_shapes import X, weighted_integral
from spacar.symbolic.collect import common_factors
from spacar.symbolic.system_parts import Beam
from spacar.symbolic.unit_vectors import ByExpression

Form = ByExpression
Forms = tuple[Form, Form, Form]
_UNIT: Form = {sp.S.One: sp.S.One}


def vee(C: sp.Matrix) -> sp.Matrix:
    """Σ p × q from Σ p qᵀ."""
    return sp.Matrix([C[1, 2] - C[2, 1], C[2, 0] - C[0, 2], C[0, 1] - C[1, 0]])


def swing(C: sp.Matrix) -> sp.Matrix:
    """The matrix of w in Σ r × (w × q), from C = Σ q rᵀ."""
    return sp.eye(3) * C.trace() - C


class Integrals:
    """∫ρ a b dx of one beam as memory reads, every pair of functions of x integrated once; `weight` instead of ρ."""

    def __init__(self, read: Callable[[sp.Expr], sp.Expr], beam: Beam, weight: sp.Expr | None = None) -> None:
        self.read, self.beam = read, beam
        self.weight = beam.mass if weight is None else weight
        self._pairs: dict[tuple[sp.Expr, sp.Expr], sp.Expr] = {}

    def integral(self, a: Form, b: Form = _UNIT) -> sp.Expr:
        """∫ρ a b dx as a memory read."""
        parts: dict[sp.Expr, list[sp.Expr]] = {}
        for m, f in a.items():
            for n, g in b.items():
                parts.setdefault(m * n, []).append(self._pair(f, g))
        terms = [self.read(sp.Add(*values)) * m for m, values in parts.items()]
        return self.read(common_factors(sp.Add(*terms)))

    def _pair(self, f: sp.Expr, g: sp.Expr) -> sp.Expr:
        if (f, g) not in self._pairs:
            value = weighted_integral(self.weight, f, g, self.beam.length)
            self._pairs[f, g] = self._pairs[g, f] = value
        return self._pairs[f, g]


class BeamMoments(Integrals):
    """Moments of one beam as Z variables, with r(x) = (x + e − w, u, w) and η_k = ∂r/∂φ_k.

    m, S0 = ∫ρ r, A = ∫ρ r rᵀ, B = ∫ρ r_t rᵀ; per coordinate q: S[q] = ∫ρ η, H[q] = ∫ρ η rᵀ, D[q] = ∫ρ η r_tᵀ;
    with foreshortening also F = ∫ρ r_tt, G = ∫ρ r_tt rᵀ and E[q] = ∫ρ η·r_tt of the part without accelerations.
    """

    def __init__(self, read: Callable[[sp.Expr], sp.Expr], beam: Beam) -> None:
        super().__init__(read, beam)
        moving = [mode for mode in beam.modes if mode[0].kind != "twist"]
        self.speed: ByExpression = {q: s for _, q, s, _ in moving}
        S = beam.shortening.kernel(X) if beam.shortening else {}
        drawn = {p: [(q, -value) for (a, q), value in S.items() if a is p] for p in self.speed}
        self.eta: dict[sp.Expr, Forms] = {
            q: _form([(f.direction, sp.S.One, psi), *((1, p, value) for p, value in drawn[q])])
            for f, q, _, psi in moving
        }
        straight = [(1, sp.S.One, X), *((f.direction, q, psi) for f, q, _, psi in moving)]
        self.r = _form([*straight, *((1, p * q, -value / 2) for (p, q), value in S.items())])
        r_t = _form(
            (i, monomial * self.speed[q], value)
            for q, forms in self.eta.items() for i, form in enumerate(forms, 1) for monomial, value in form.items()
        )  # fmt: skip
        self.m = read(beam.total_mass)
        self.S = {q: self.column(forms) for q, forms in self.eta.items()}
        self.H = {q: self.product(forms, self.r) for q, forms in self.eta.items()}
        self.D = {q: self.product(forms, r_t) for q, forms in self.eta.items()}
        # r = (x + w) b1 + Σ φ_k η_k, because w is quadratic: Σ φ_k ∂w/∂φ_k = 2 w
        head = _form([(1, sp.S.One, X), *((1, p * q, value / 2) for (p, q), value in S.items())])
        zero = sp.zeros(3, 3)
        self.S0 = self.reads(self.column(head) + sum((q * S for q, S in self.S.items()), sp.zeros(3, 1)))
        self.A = self.reads(self.product(head, self.r) + sum((q * H for q, H in self.H.items()), zero))
        self.B = self.reads(sum((self.speed[q] * H for q, H in self.H.items()), zero))
        self.curved = beam.shortening is not None
        if self.curved:
            r_tt = _form((1, self.speed[p] * self.speed[q], -value) for (p, q), value in S.items())
            self.F, self.G = self.column(r_tt), self.product(r_tt, self.r)
            self.E = {q: self.integral(forms[0], r_tt[0]) for q, forms in self.eta.items()}

    def column(self, a: Forms) -> sp.Matrix:
        """∫ρ a dx."""
        return sp.Matrix([self.integral(component) for component in a])

    def product(self, a: Forms, b: Forms) -> sp.Matrix:
        """∫ρ a bᵀ dx."""
        return sp.Matrix(3, 3, lambda i, j: self.integral(a[i], b[j]))

    def mass(self, q: sp.Expr, p: sp.Expr) -> sp.Expr:
        """M_kl = ∫ρ η_k·η_l."""
        return sp.Add(*(self.integral(a, b) for a, b in zip(self.eta[q], self.eta[p], strict=True)))

    def reads(self, matrix: sp.Matrix) -> sp.Matrix:
        return matrix.applyfunc(self.read)


def collected(terms: Iterable[tuple[sp.Expr, sp.Expr]]) -> Form:
    """(monomial, function of x) with the functions of equal monomials added."""
    parts: dict[sp.Expr, list[sp.Expr]] = {}
    for monomial, value in terms:
        parts.setdefault(monomial, []).append(value)
    return {m: total for m, values in parts.items() if (total := sp.Add(*values)) != 0}


def _form(terms: Iterable[tuple[int, sp.Expr, sp.Expr]]) -> Forms:
    """(component, monomial, function of x) collected."""
    rows = list(terms)
    first, second, third = (collected((m, value) for i, m, value in rows if i == k) for k in (1, 2, 3))
    return first, second, third
