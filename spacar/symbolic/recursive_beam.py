"""A beam in the recursive strategy: shape integrals once per run, moments of the deformed beam once per step.

With r(x) = (x + e − w, u, w) from the root, η_k = ∂r/∂φ_k, r_t = Σ η_k dφ_k, all in the frame of the beam:

    m,  S_k = ∫ρ η_k,  M_kl = ∫ρ η_k·η_l,  H_k = ∫ρ η_k rᵀ,  D_k = ∫ρ η_k r_tᵀ,  S_0 = ∫ρ r,
    A = ∫ρ r rᵀ = ∫ρ (x + w) e1 rᵀ + Σ φ_k H_k,  B = ∫ρ r_t rᵀ = Σ dφ_k H_k

    I_rs += ∫ρ V_r(x)·V_s(x),   V_r(x) = V_r + W_r × r for a speed r of the root,  V_k(x) = η_k for a field speed
    f_r  −= ∫ρ V_r(x)·a0(x),    a0(x) = a0 + al0 × r + w × (w × r) + 2 w × r_t + r_tt,bias

Two products replace all cross products under the integral: ∫ρ p × q = vee(∫ρ p qᵀ) and
∫ρ r × (w × q) = (tr C 1 − C) w with C = ∫ρ q rᵀ. Source: `symbolic.md`, section 4.4; same result as `held.py`.
"""

from itertools import combinations_with_replacement

import sympy as sp

from spacar.symbolic.beam_shapes import X, product_integral, weighted_integral
from spacar.symbolic.fields import Field
from spacar.symbolic.moments import BeamMoments, Integrals, swing, vee
from spacar.symbolic.recursion import NOTHING, Recursion, Sums
from spacar.symbolic.system_parts import Beam

_E1 = sp.Matrix([1, 0, 0])


def add_beam(recursion: Recursion, beam: Beam, sums: Sums) -> None:
    """Add the inertia, stiffness and damping of a beam to I and f."""
    b = BeamMoments(recursion.table.read, beam)
    root, turning = recursion.point(beam.root, beam.frame), recursion.frame(beam.frame)
    V, W, a0, w, al0 = root.partials, turning.partials, root.bias, turning.velocity, turning.bias
    rigid = [s for s in sums.speeds if s in V or s in W]
    J = b.reads(swing(b.A))
    for i, r in enumerate(rigid):
        Vr, Wr = V.get(r, NOTHING), W.get(r, NOTHING)
        push, twist = b.reads(b.m * Vr + Wr.cross(b.S0)), b.reads(b.S0.cross(Vr) + J * Wr)
        for s in rigid[i:]:
            sums.add_mass(r, s, push.dot(V.get(s, NOTHING)) + twist.dot(W.get(s, NOTHING)))
        for q, s in b.speed.items():
            sums.add_mass(r, s, Vr.dot(b.S[q]) + Wr.dot(b.reads(-vee(b.H[q]))))
    wS = b.reads(w.cross(b.S0))
    St = b.reads(sum((b.speed[q] * S for q, S in b.S.items()), NOTHING))
    force = b.m * a0 + al0.cross(b.S0) + w.cross(wS) + 2 * w.cross(St)
    torque = b.S0.cross(a0) + J * al0 + w.cross(b.reads(J * w)) + 2 * swing(b.B) * w
    if b.curved:
        force, torque = force + b.F, torque - vee(b.G)
    force, torque = b.reads(force), b.reads(torque)
    for r in rigid:
        sums.add_force(r, -V.get(r, NOTHING).dot(force) - W.get(r, NOTHING).dot(torque))
    _field_equations(b, sums, a0, w, al0)
    _section_inertia(recursion, b, sums)
    _distributed(recursion, b, sums)


def _field_equations(b: BeamMoments, sums: Sums, a0: sp.Matrix, w: sp.Matrix, al0: sp.Matrix) -> None:
    """Rows of the field coordinates: inertia, strain energy, damping."""
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
        coriolis = 2 * w.dot(-vee(b.D[q]))  # η·(w × r_t) = w·(r_t × η)
        own = b.E[q] if b.curved else sp.S.Zero
        sums.add_force(s, -(b.S[q].dot(a0) - vee(H).dot(al0) + centrifugal + coriolis + own))
    for f, _, s, psi in b.beam.modes:
        sums.add_force(s, -_elastic(b, f, psi))


def _elastic(b: BeamMoments, f: Field, psi: sp.Expr) -> sp.Expr:
    """Σ_j φ_j ∫EI ψ''ψ_j'' + dφ_j ∫2γ ψ'ψ_j' of one shape, the integrals from Z (see `held.damping_force`)."""
    beam, n, terms = b.beam, f.order, []
    for q, s, other in zip(f.coordinates, f.speeds, f.shapes, strict=True):
        stiffness = weighted_integral(f.stiffness, psi.diff(X, n), other.diff(X, n), beam.length)
        terms.append(b.read(stiffness) * q)
        if f.kind == "bending" and beam.damping != 0:
            pair = (psi.diff(X), other.diff(X)) if beam.damping_boundary else (-psi, other.diff(X, 2))
            terms.append(b.read(2 * beam.damping * product_integral(*pair, beam.length)) * s)
    return sp.Add(*terms)


def _section_inertia(recursion: Recursion, b: BeamMoments, sums: Sums) -> None:
    """Polar inertia of the sections: angular momentum ρ_p (w1 + θ_t) b1."""
    beam = b.beam
    if beam.polar == 0:
        return
    turning, polar = recursion.frame(beam.frame), Integrals(recursion.table.read, beam, beam.polar)
    W, w, al0, one = turning.partials, turning.velocity, turning.bias, {sp.S.One: sp.S.One}
    shapes = {s: {sp.S.One: psi} for f, _, s, psi in beam.modes if f.kind == "twist"}
    # the spin of a section by a unit of each speed: a factor and a function of x
    spins = [(s, W[s][0], one) for s in sums.speeds if s in W] + [(s, sp.S.One, form) for s, form in shapes.items()]
    for (r, c, f), (k, d, g) in combinations_with_replacement(spins, 2):
        sums.add_mass(r, k, c * d * polar.integral(f, g))
    h = b.read(polar.integral(one) * w[0] + sp.Add(*(polar.integral(form) * s for s, form in shapes.items())))
    torque = b.reads(polar.integral(one) * al0[0] * _E1 + w.cross(h * _E1))
    for r, column in W.items():
        sums.add_force(r, -column.dot(torque))
    for s, form in shapes.items():
        sums.add_force(s, -polar.integral(form) * al0[0])


def _distributed(recursion: Recursion, b: BeamMoments, sums: Sums) -> None:
    """Forces per length f(x): V·∫f, W·∫r × f, ∫η_k·f."""
    beam = b.beam
    loads = [part for load in recursion.system.distributed_loads if load.beam is beam for part in load.parts]
    if not loads:
        return
    plain = Integrals(recursion.table.read, beam, sp.S.One)
    V, W = recursion.point(beam.root, beam.frame).partials, recursion.frame(beam.frame).partials
    for vector, g in loads:
        form = {sp.S.One: g}
        f = recursion.reads(recursion.cosines.components(vector, beam.frame))
        torque = sp.Matrix([plain.integral(component, form) for component in b.r]).cross(f)
        for s in sums.speeds:
            if s in V:
                sums.add_force(s, V[s].dot(f) * plain.integral(form))
            if s in W:
                sums.add_force(s, W[s].dot(torque))
        for q, forms in b.eta.items():
            sums.add_force(b.speed[q], sp.Add(*(plain.integral(a, form) * f[i] for i, a in enumerate(forms))))
