"""Assumed fields of a beam: u(x, t) = Σ φ_k(t) ψ_k(x), their strain energy and foreshortening.

A field stays a symbol u(x, t) through the kinematics; `substitution` gives what replaces it and its derivatives
afterwards. Energy densities ½ EI u_xx² (bending), ½ GJ θ_x² (twist), ½ EA e_x² (stretch): the paper, (9), (10);
foreshortening w = ½ ∫ u_x² dx: `symbolic.md`, section 8.7.
"""

from dataclasses import dataclass

import sympy as sp

from spacar.symbolic.beam_shapes import X, product_integral, weighted_integral
from spacar.symbolic.unit_vectors import TIME, AccelerationSymbols, ByExpression, Rule, Scalars


@dataclass(frozen=True, eq=False)
class Field:
    """One assumed field. `kind` is bending, twist or stretch; `direction` the unit vector it moves along or about.

    coordinates φ_k(t) and speeds dφ_k(t) belong to `shapes` ψ_k(x); `stiffness` [N m², N m² or N].
    """

    name: str
    kind: str
    direction: int
    function: sp.Expr
    shapes: Scalars
    coordinates: Scalars
    speeds: Scalars
    stiffness: sp.Expr

    @property
    def order(self) -> int:
        """Of the derivative to x that is the strain: u_xx for bending, else θ_x or e_x."""
        return 2 if self.kind == "bending" else 1

    def value(self, x: sp.Expr, derivative: int = 0) -> sp.Expr:
        """Σ φ_k ψ_k, or a derivative with respect to x, at x."""
        return sp.Add(*(p * g for p, g in self.gradient(x, derivative).items()))

    def gradient(self, x: sp.Expr, derivative: int = 0) -> ByExpression:
        """∂(value)/∂φ_k for every coordinate."""
        return {p: psi.diff(X, derivative).subs(X, x) for p, psi in zip(self.coordinates, self.shapes, strict=True)}

    def strain_energy(self, length: sp.Expr) -> sp.Expr:
        """∫ energy density dx of the assumed field [J]."""
        n = self.order
        pairs = [(q, psi.diff(X, n)) for q, psi in zip(self.coordinates, self.shapes, strict=True)]
        total = [p * q * weighted_integral(self.stiffness, f, g, length) for p, f in pairs for q, g in pairs]
        return sp.Add(*total) / 2

    def substitution(self, accelerations: AccelerationSymbols) -> Rule:
        """u, u_t, u_tt and their derivatives to x in terms of φ, dφ and the acceleration symbols."""
        rule: Rule = {}
        levels = (self.coordinates, self.speeds, tuple(accelerations[s] for s in self.speeds))
        for times, amplitudes in enumerate(levels):
            value = sp.Add(*(a * psi for a, psi in zip(amplitudes, self.shapes, strict=True)))
            for n in range(self.order + 1):
                rule[self.function.diff(X, n, TIME, times)] = value.diff(X, n)
        return rule


@dataclass(frozen=True, eq=False)
class Pseudo:
    """A boundary value of a field treated as a coordinate while deriving (pseudo-coordinate of the paper, (5)).

    `value` is the assumed field at the section, or the foreshortening at any place, `gradient` ∂value/∂φ_k.
    """

    coordinate: sp.Expr
    speed: sp.Expr
    value: sp.Expr
    gradient: ByExpression

    def rate(self, speeds: ByExpression) -> sp.Expr:
        """s' = Σ g_k dφ_k for {φ_k: dφ_k}."""
        return sp.Add(*(g * speeds[q] for q, g in self.gradient.items()))

    def acceleration(self, speeds: ByExpression, accelerations: AccelerationSymbols) -> sp.Expr:
        """ṡ' = Σ g_k dφ̇_k + bias."""
        return sp.Add(*(g * accelerations[speeds[q]] for q, g in self.gradient.items()), self.bias(speeds))

    def bias(self, speeds: ByExpression) -> sp.Expr:
        """Σ ∂g_k/∂φ_j dφ_j dφ_k, the part of ṡ' without accelerations."""
        return sp.Add(*(g.diff(r) * speeds[q] * speeds[r] for q, g in self.gradient.items() for r in speeds))


@dataclass(frozen=True, eq=False)
class Foreshortening:
    """w(x, t) = ½ Σ_fields ∫_0^x u_x² dx, by which a bending beam draws its points towards the root [m]."""

    function: sp.Expr
    fields: tuple[Field, ...]
    length: sp.Expr

    def kernel(self, x: sp.Expr) -> dict[tuple[sp.Expr, sp.Expr], sp.Expr]:
        """{(φ_i, φ_j): S_ij}, S_ij = ∫_0^x ψ_i' ψ_j' dx of every two shapes of one field; w = ½ Σ φ_i φ_j S_ij."""
        table: dict[tuple[sp.Expr, sp.Expr], sp.Expr] = {}
        for f in self.fields:
            slopes = [psi.diff(X) for psi in f.shapes]
            for i, p in enumerate(f.coordinates):
                for j, q in enumerate(f.coordinates[: i + 1]):
                    value = product_integral(slopes[i], slopes[j], self.length, x)
                    table[p, q] = table[q, p] = value
        return table

    def value(self, x: sp.Expr) -> sp.Expr:
        return sp.Add(*(p * q * S / 2 for (p, q), S in self.kernel(x).items()))

    def gradient(self, x: sp.Expr) -> ByExpression:
        """∂w/∂φ_k, linear in φ."""
        parts: dict[sp.Expr, list[sp.Expr]] = {q: [] for f in self.fields for q in f.coordinates}
        for (p, q), S in self.kernel(x).items():
            parts[p].append(q * S)
        return {p: sp.Add(*terms) for p, terms in parts.items()}

    def substitution(self, accelerations: AccelerationSymbols) -> Rule:
        """w, w_t and w_tt as polynomials in x."""
        w, w_t = self.function, self.function.diff(TIME)
        here = Pseudo(w, w_t, self.value(X), self.gradient(X))
        speeds = {p: s for f in self.fields for p, s in zip(f.coordinates, f.speeds, strict=True)}
        return {w: here.value, w_t: here.rate(speeds), w_t.diff(TIME): here.acceleration(speeds, accelerations)}
