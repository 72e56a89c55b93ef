"""A beam in the recursive strategy: shape integrals once per run, moments of the deformed beam once per step.

With r(x) = (x + e − w, u, w) from the root, η_k = ∂r/∂φ_k, r_t = Σ η_k dφ_k, all in the frame of the beam:

    m,  S_k = ∫ρ η_k,  M_kl = ∫ρ η_k·η_l,  H_k = ∫ρ η_k rᵀ,  D_k = ∫ρ η_k r_tᵀ,  S_0 = ∫ρ r,
    A = ∫ρ r rᵀ = ∫ρ (x + w) e1 rᵀ + Σ φ_k H_k,  B = ∫ρ r_t rᵀ = Σ dφ_k H_k

    I_rs += m V_r·V_s + (V_r × ... )   in words: the point masses summed,  V(x) = V_r + W_r × r,  V_k(x) = η_k
    f_r  −= ∫ρ V(x)·a0(x),   a0(x) = a0 + al0 × r + w × (w × r) + 2 w × r_t + r_tt,bias

Two products replace all cross products under the integral: ∫ρ p × q = vee(∫ρ p qᵀ) and
∫ρ r × (w × q) = (tr C 1 − C) w with C = ∫ρ q rᵀ. Source: `symbolic.md`, section 4.4; same result as `held.py`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy as sp

from spacar.symbolic.collect import gather_scalars
from spacar.symbolic.fields import Field
from spacar.symbolic.held import damping_force
from spacar.symbolic.parts import Beam
from spacar.symbolic.shapes import X, integral

if TYPE_CHECKING:
    from spacar.symbolic.recursive import Recursion, Sums

_E1 = sp.Matrix([1, 0, 0])


def vee(C: sp.Matrix) -> sp.Matrix:
    """Σ p × q from Σ p qᵀ."""
    return sp.Matrix([C[1, 2] - C[2, 1], C[2, 0] - C[0, 2], C[0, 1] - C[1, 0]])


def swing(C: sp.Matrix) -> sp.Matrix:
    """The matrix of w in Σ r × (w × q), from C = Σ q rᵀ."""
    return sp.eye(3) * C.trace() - C


class BeamMoments:
    """Shape integrals and moments of one beam as Z variables."""

    def __init__(self, recursion: Recursion, beam: Beam) -> None:
        self.beam = beam
        self.read = recursion.table.read
        self.modes = [
            (f, q, s, psi) for f in beam.fields for q, s, psi in zip(f.coordinates, f.speeds, f.shapes, strict=True)
        ]
        self.moving = [mode for mode in self.modes if mode[0].kind != "twist"]
        gradient = beam.shortening.gradient(X) if beam.shortening else {}
        w = beam.shortening.value(X) if beam.shortening else sp.S.Zero
        self.eta = {q: self._direction(f, psi) - gradient.get(q, 0) * _E1 for f, q, _, psi in self.moving}
        self.r = (X - w) * _E1 + sum((q * self._direction(f, psi) for f, q, _, psi in self.moving), sp.zeros(3, 1))
        self.speed = {q: s for _, q, s, _ in self.moving}
        self.m = self.read(beam.mass * beam.length)
        self.S = {q: self.integral(eta) for q, eta in self.eta.items()}
        self.S0 = self._first_moment(w)
        self.H = {q: self.bilinear(eta, q) for q, eta in self.eta.items()}
        self.A = self._second_moment(w)
        self.B = self.reads(self._sum(self.H))

    @staticmethod
    def _direction(f: Field, psi: sp.Expr) -> sp.Matrix:
        return sp.Matrix([psi if i == f.direction else sp.S.Zero for i in (1, 2, 3)])

    def reads(self, matrix: sp.Matrix) -> sp.Matrix:
        return matrix.applyfunc(self.read)

    def scalar(self, integrand: sp.Expr) -> sp.Expr:
        """∫ρ integrand dx as a polynomial in φ whose coefficients are Z variables of parameters."""
        value = integral(self.beam.mass * integrand, X, self.beam.length)
        coordinates = [q for _, q, _, _ in self.moving]
        if value == 0 or not coordinates:
            return self.read(value)
        terms = sp.Poly(value, *coordinates).terms()
        parts = [
            self.read(gather_scalars(c)) * sp.Mul(*(q**n for q, n in zip(coordinates, powers, strict=True)))
            for powers, c in terms
        ]
        return self.read(sp.factor_terms(sp.Add(*parts)))

    def integral(self, column: sp.Matrix) -> sp.Matrix:
        return column.applyfunc(self.scalar)

    def bilinear(self, eta: sp.Matrix, _: sp.Expr) -> sp.Matrix:
        """H_k = ∫ρ η_k rᵀ."""
        return (eta * self.r.T).applyfunc(self.scalar)

    def _sum(self, matrices: dict[sp.Expr, sp.Matrix], by: str = "speed") -> sp.Matrix:
        shape = next(iter(matrices.values())).shape if matrices else (3, 3)
        return sum((m * (self.speed[q] if by == "speed" else q) for q, m in matrices.items()), sp.zeros(*shape))

    def _first_moment(self, w: sp.Expr) -> sp.Matrix:
        """∫ρ r = ∫ρ (x + w) e1 + Σ φ_k S_k."""
        head = self.integral((X + w) * _E1)
        return self.reads(head + (self._sum(self.S, by="coordinate") if self.S else sp.zeros(3, 1)))

    def _second_moment(self, w: sp.Expr) -> sp.Matrix:
        head = ((X + w) * _E1 * self.r.T).applyfunc(self.scalar)
        return self.reads(head + self._sum(self.H, by="coordinate"))

    def mass(self, q: sp.Expr, p: sp.Expr) -> sp.Expr:
        """M_kl = ∫ρ η_k·η_l."""
        return self.scalar(self.eta[q].dot(self.eta[p]))

    def curvature_bias(self) -> tuple[sp.Matrix, sp.Matrix] | None:
        """∫ρ r_tt and ∫ρ r_tt rᵀ of the part −w_tt without accelerations (foreshortening only)."""
        if not self.beam.shortening:
            return None
        rate = sp.Add(*(g.diff(p) * self.speed[q] * self.speed[p] for q, g in self._gradient() for p in self.speed))
        column = -rate * _E1
        return self._quadratic(column), self._quadratic_matrix(column * self.r.T)

    def _gradient(self) -> list[tuple[sp.Expr, sp.Expr]]:
        assert self.beam.shortening is not None
        return list(self.beam.shortening.gradient(X).items())

    def quadratic(self, integrand: sp.Expr) -> sp.Expr:
        """∫ρ integrand dx of a polynomial in φ and dφ."""
        return self.read(gather_scalars(integral(self.beam.mass * integrand, X, self.beam.length)))

    def _quadratic(self, column: sp.Matrix) -> sp.Matrix:
        return column.applyfunc(self.quadratic)

    _quadratic_matrix = _quadratic


def add_beam(recursion: Recursion, beam: Beam, sums: Sums) -> None:
    """Add the inertia, stiffness and damping of a beam to I and f."""
    b = BeamMoments(recursion, beam)
    root, turning = recursion.point(beam.root, beam.frame), recursion.frame(beam.frame)
    V, W, a0, w, al0 = root.partials, turning.partials, root.bias, turning.velocity, turning.bias
    nothing = sp.zeros(3, 1)
    rigid = [s for s in sums.speeds if s in V or s in W]
    J = b.reads(swing(b.A))
    for i, r in enumerate(rigid):
        Vr, Wr = V.get(r, nothing), W.get(r, nothing)
        push, twist = b.reads(b.m * Vr + Wr.cross(b.S0)), b.reads(b.S0.cross(Vr) + J * Wr)
        for s in rigid[i:]:
            sums.add_mass(r, s, push.dot(V.get(s, nothing)) + twist.dot(W.get(s, nothing)))
        for q, s in b.speed.items():
            sums.add_mass(r, s, Vr.dot(b.S[q]) + Wr.dot(b.reads(-vee(b.H[q]))))
    wS = b.reads(w.cross(b.S0))
    St = b.reads(b._sum(b.S)) if b.S else nothing
    force = b.m * a0 + al0.cross(b.S0) + w.cross(wS) + 2 * w.cross(St)
    torque = b.S0.cross(a0) + J * al0 + w.cross(b.reads(J * w)) + 2 * swing(b.B) * w
    bias = b.curvature_bias()
    if bias:
        force, torque = force + bias[0], torque - vee(bias[1])
    force, torque = b.reads(force), b.reads(torque)
    for r in rigid:
        sums.add_force(r, -V.get(r, nothing).dot(force) - W.get(r, nothing).dot(torque))
    _field_equations(b, sums, a0, w, al0, bias is not None)
    _section_inertia(recursion, b, sums)


def _field_equations(b: BeamMoments, sums: Sums, a0: sp.Matrix, w: sp.Matrix, al0: sp.Matrix, curved: bool) -> None:
    """Rows of the field coordinates: inertia, strain energy, damping."""
    beam = b.beam
    coordinates = list(b.speed)
    ww = b.reads(w * w.T)
    swirl = ww - sp.eye(3) * b.read(ww.trace())  # w × (w × r) = (w wᵀ − w² 1) r
    swirl = b.reads(swirl)
    for n, q in enumerate(coordinates):
        s = b.speed[q]
        for p in coordinates[n:]:
            sums.add_mass(s, b.speed[p], b.mass(q, p))
        H = b.H[q]
        centrifugal = sp.Add(*(swirl[i, j] * H[i, j] for i in range(3) for j in range(3)))
        D = b.reads((b.eta[q] * _velocity(b).T).applyfunc(b.quadratic))
        coriolis = 2 * w.dot(-vee(D))  # η·(w × r_t) = w·(r_t × η)
        own = _own_bias(b, q) if curved else sp.S.Zero
        sums.add_force(s, -(b.S[q].dot(a0) - vee(H).dot(al0) + centrifugal + coriolis + own))
    for f, q, s, psi in b.modes:
        elastic = f.strain_energy(beam.length).diff(q) + damping_force(beam, f, psi)
        sums.add_force(s, -_linear(b, f, elastic))


def _velocity(b: BeamMoments) -> sp.Matrix:
    return sum((eta * b.speed[q] for q, eta in b.eta.items()), sp.zeros(3, 1))


def _own_bias(b: BeamMoments, q: sp.Expr) -> sp.Expr:
    """∫ρ η_k·r_tt,bias."""
    rate = sp.Add(*(g.diff(p) * b.speed[k] * b.speed[p] for k, g in b._gradient() for p in b.speed))
    return b.quadratic(-rate * b.eta[q][0])


def _linear(b: BeamMoments, f: Field, expression: sp.Expr) -> sp.Expr:
    """Stiffness and damping forces, linear in φ and dφ, with coefficients from Z."""
    symbols = [*f.coordinates, *f.speeds]
    return sp.Add(*(b.read(gather_scalars(expression.diff(s))) * s for s in symbols))


def _section_inertia(recursion: Recursion, b: BeamMoments, sums: Sums) -> None:
    """Polar inertia of the sections: angular momentum ρ_p (w1 + θ_t) b1."""
    beam = b.beam
    if beam.polar == 0:
        return
    turning = recursion.frame(beam.frame)
    total = b.read(beam.polar * beam.length)
    shapes = [(s, psi) for f, _, s, psi in b.modes if f.kind == "twist"]
    first = {s: b.read(integral(beam.polar * psi, X, beam.length)) for s, psi in shapes}
    W, w, al0 = turning.partials, turning.velocity, turning.bias
    h = b.read(total * w[0] + sp.Add(*(c * s for s, c in first.items())))
    torque = b.reads(total * al0[0] * _E1 + w.cross(h * _E1))
    rigid = [s for s in sums.speeds if s in W]
    for i, r in enumerate(rigid):
        for k in rigid[i:]:
            sums.add_mass(r, k, total * W[r][0] * W[k][0])
        for s, c in first.items():
            sums.add_mass(r, s, c * W[r][0])
        sums.add_force(r, -W[r].dot(torque))
    for i, (s, psi) in enumerate(shapes):
        for k, other in shapes[i:]:
            sums.add_mass(s, k, b.read(integral(beam.polar * psi * other, X, beam.length)))
        sums.add_force(s, -first[s] * al0[0])
