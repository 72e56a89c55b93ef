"""Strategy `held`: equations in vector notation, products of unit vectors evaluated last.

    E(s) = Σ_B [∂v_B/∂s·(F_B − I_B) + ∂w_B/∂s·(T_B − J_B)] + Σ loads                                         (A)
    E(φ_k) = ∫ [(f − ρ a)·∂v/∂dφ_k − EI u_xx ψ_k,xx − 2γ u_xt ψ_k,x] dx + Σ_p E(s'_p) ∂s'_p/∂dφ_k            (B)

(A) is evaluated for generalized speeds and for pseudo-speeds s'_p. Every equation is linear in the accelerations
(ṡ_r, dφ̇_k, ṡ'_p) = a: E = E_0 − Î a. With a = T ȧ + t (pseudo-speeds follow the field) the result is I = Tᵀ Î T,
f = Tᵀ (E_0 − Î t). Source: the paper, (11) to (20), tables 11 to 19; `symbolic.md`, sections 3.2, 3.3, 4.2.
"""

from dataclasses import dataclass
from functools import cache, partial

import sympy as sp

from spacar.symbolic.beam_shapes import X, integral
from spacar.symbolic.collect import LinearSplit, ZTable, gather_dots, gather_scalars, gather_vectors, read_scalar
from spacar.symbolic.derivation import Derivation
from spacar.symbolic.description import Description
from spacar.symbolic.fields import Field
from spacar.symbolic.moments import Form, Integrals, collected
from spacar.symbolic.reference_frames import omega, partial_velocity
from spacar.symbolic.system_parts import Beam, DistributedLoad, RigidBody
from spacar.symbolic.transform import DirectionCosines, transform
from spacar.symbolic.unit_vectors import TIME, AccelerationSymbols, ByExpression, Key
from spacar.symbolic.vectors import ZERO, Vector, cross, dot


@dataclass(frozen=True)
class Wrench:
    """What acts on a body at its reference point, inertia included: force F − I with v, torque T − J with w."""

    velocity: Vector
    force: Vector
    rotation: Vector
    torque: Vector


@dataclass(frozen=True)
class VectorPart:
    """vector · factor · form(x), the vector without x, the factor an acceleration symbol or one."""

    vector: Vector
    factor: sp.Expr
    form: Form


def beam_functions(beam: Beam, accelerations: AccelerationSymbols) -> dict[sp.Basic, list[tuple[sp.Expr, Form]]]:
    """x, u, u_t, u_tt and the shortening w, w_t, w_tt as [(1 or an acceleration, {monomial: function of x})]."""
    one = sp.S.One
    found: dict[sp.Basic, list[tuple[sp.Expr, Form]]] = {X: [(one, {one: X})]}
    for f in beam.fields:
        found[f.function] = [(one, dict(zip(f.coordinates, f.shapes, strict=True)))]
        found[f.function.diff(TIME)] = [(one, dict(zip(f.speeds, f.shapes, strict=True)))]
        found[f.function.diff(TIME, 2)] = [
            (accelerations[s], {one: psi}) for s, psi in zip(f.speeds, f.shapes, strict=True)
        ]
    if beam.shortening:
        w, S = beam.shortening.function, beam.shortening.kernel(X)
        speed = dict(zip(beam.coordinates, beam.speeds, strict=True))
        found[w] = [(one, collected((p * q, value / 2) for (p, q), value in S.items()))]
        found[w.diff(TIME)] = [(one, collected((q * speed[p], value) for (p, q), value in S.items()))]
        own = [(one, collected((speed[p] * speed[q], value) for (p, q), value in S.items()))]
        own += [
            (accelerations[speed[p]], collected((q, value) for (first, q), value in S.items() if first is p))
            for p in {first: None for first, _ in S}
        ]
        found[w.diff(TIME, 2)] = own
    return found


class HeldDerivation:
    """The steps of the held derivation for one system, each usable alone."""

    def __init__(self, system: Description, recurrence: bool = True) -> None:
        self.system = system
        self.recurrence = recurrence
        self.accelerations = list(system.accelerations.values())
        self.table = ZTable(forbidden=self.accelerations)
        self.cosines = DirectionCosines(self.table if recurrence else None)
        self.values: ByExpression = {}
        self.integrals = cache(partial(Integrals, self.read))  # of a beam, memory reads when recurrence is on
        self.acceleration, self.relative_acceleration = cache(self._acceleration), cache(self._relative_acceleration)

    # -- Z variables -------------------------------------------------------------------------------------------

    def read(self, expression: sp.Expr, name: str | None = None) -> sp.Expr:
        """A memory read, or the expression itself when recurrence is off."""
        return self.table.read(expression, name) if self.recurrence else expression

    def remember(self, vector: Vector) -> Vector:
        """Measure numbers as Z variables, accelerations kept; only gathered when recurrence is off."""
        gathered = gather_vectors(vector)
        return gathered.map(lambda c: read_scalar(c, self.table, self.accelerations)) if self.recurrence else gathered

    def _acceleration(self, velocity: Vector) -> Vector:
        """Acceleration in N of a point or frame with this velocity; its measure numbers are read from Z."""
        return self.remember(self.system.ddt(self.system.N, velocity))

    # -- bodies ------------------------------------------------------------------------------------------------

    def body(self, body: RigidBody) -> Wrench:
        """F − I = m (g − a_c) and T − J = −dH/dt of a rigid body at its mass centre."""
        force = (self.system.gravity - self.acceleration(body.point.velocity)) * body.mass
        if body.frame is None or not body.inertia:
            return Wrench(body.point.velocity, force, ZERO, ZERO)
        w = omega(self.system.N, body.frame)
        momentum = dot(body.inertia, w)
        return Wrench(body.point.velocity, force, w, self.remember(-self.system.ddt(self.system.N, momentum)))

    def beam(self, beam: Beam) -> Wrench:
        """∫ρ(g − a) dx and ∫ r × ρ(g − a) dx of a beam about its root; the section's own inertia in twist."""
        g, root = self.system.gravity, self.acceleration(beam.root.velocity)
        whole, place, relative = self.integrals(beam), self.split(beam, beam.offset), self.relative_acceleration(beam)
        moment = self.remember(sum((p.vector * whole.integral(p.form) for p in place), ZERO))
        inertia = sum((a.vector * (a.factor * whole.integral(a.form)) for a in relative), ZERO)
        spin = sum(
            (cross(p.vector, a.vector) * (a.factor * whole.integral(p.form, a.form)) for p in place for a in relative),
            ZERO,
        )
        force = self.remember(-inertia) + (g - root) * beam.total_mass
        torque = self.remember(-spin) + cross(moment, g - root)
        torque -= self.section_momentum_rate(beam).map(lambda c: integral(c, X, beam.length))
        return Wrench(beam.root.velocity, force, omega(self.system.N, beam.frame), torque)

    def distributed(self, load: DistributedLoad) -> Wrench:
        """∫ f dx and ∫ r × f dx of a load about the root of its beam."""
        beam, plain = load.beam, Integrals(self.read, load.beam, sp.S.One)
        place = self.split(beam, beam.offset)
        force = sum((v * plain.integral({sp.S.One: g}) for v, g in load.parts), ZERO)
        torque = sum(
            (cross(p.vector, v) * plain.integral(p.form, {sp.S.One: g}) for p in place for v, g in load.parts), ZERO
        )
        return Wrench(beam.root.velocity, force, omega(self.system.N, beam.frame), torque)

    def _relative_acceleration(self, beam: Beam) -> list[VectorPart]:
        """Acceleration in N of the mass point x relative to the root, in parts."""
        N = self.system.N
        return self.split(beam, self.system.ddt(N, self.system.ddt(N, beam.offset)))

    def split(self, beam: Beam, value: Vector) -> list[VectorPart]:
        """A vector that is linear in x and in the field symbols u(x, t), u_t, u_tt, with the assumed fields put in."""
        known = beam_functions(beam, self.system.accelerations)
        split = LinearSplit(known)
        terms: dict[sp.Basic, dict[Key, sp.Expr]] = {symbol: {} for symbol in known}
        for key, c in value.terms.items():
            for symbol, coefficient in split(c)[0].items():
                terms[symbol][key] = coefficient
        directions = ((Vector(parts), known[symbol]) for symbol, parts in terms.items() if parts)
        return [VectorPart(direction, factor, form) for direction, forms in directions for factor, form in forms]

    def section_momentum_rate(self, beam: Beam) -> Vector:
        """d/dt of the polar momentum ρ_p (w·b1 + θ_t) b1 of a section."""
        if beam.polar == 0:
            return ZERO
        twist, b1 = next((f for f in beam.fields if f.kind == "twist"), None), beam.frame[1]
        spin = dot(omega(self.system.N, beam.frame), b1) + (twist.function.diff(TIME) if twist else 0)
        rate = self.system.ddt(self.system.N, b1 * (beam.polar * spin))
        return rate.xreplace(beam.assumed(self.system.accelerations))

    # -- equations ---------------------------------------------------------------------------------------------

    def wrenches(self) -> list[Wrench]:
        N = self.system.N
        wrenches = [*map(self.body, self.system.bodies), *map(self.beam, self.system.beams)]
        wrenches += map(self.distributed, self.system.distributed_loads)
        for load in self.system.all_loads():
            if load.point is not None:
                wrenches.append(Wrench(load.point.velocity, load.vector, ZERO, ZERO))
            for frame, sign in load.turned:
                wrenches.append(Wrench(ZERO, ZERO, omega(N, frame), sign * load.vector))
        return wrenches

    @staticmethod
    def ordinary(wrenches: list[Wrench], speed: sp.Expr) -> sp.Expr:
        """E(speed) of formula (A)."""
        total = sp.S.Zero
        for w in wrenches:
            total += dot(partial_velocity(w.velocity, speed), w.force)
            total += dot(partial_velocity(w.rotation, speed), w.torque)
        return total

    def weak(self, beam: Beam) -> ByExpression:
        """The integral of formula (B) for every field speed of the beam."""
        pull = self.system.gravity - self.acceleration(beam.root.velocity)
        relative, whole = self.relative_acceleration(beam), self.integrals(beam)
        kernel = beam.shortening.kernel(X) if beam.shortening else {}
        b1, plain = beam.frame[1], Integrals(self.read, beam, sp.S.One)
        loads = [load for load in self.system.distributed_loads if load.beam is beam]
        result: ByExpression = {}
        for f, q, s, psi in beam.modes:
            move = [] if f.kind == "twist" else [(beam.frame[f.direction], {sp.S.One: psi})]
            if drawn := collected((p, value) for (first, p), value in kernel.items() if first is q):
                move.append((-b1, drawn))
            moment = self.remember(sum((e * whole.integral(form) for e, form in move), ZERO))
            parts = [dot(moment, pull)]
            inner = -sp.Add(
                *(dot(e, a.vector) * a.factor * whole.integral(form, a.form) for e, form in move for a in relative)
            )
            if f.kind == "twist":
                inner -= integral(psi * dot(b1, self.section_momentum_rate(beam)), X, beam.length)
            inner -= f.strain_energy(beam.length).diff(q) + damping_force(beam, f, psi)
            parts += [
                dot(e, v) * plain.integral(form, {sp.S.One: g})
                for load in loads for e, form in move for v, g in load.parts
            ]  # fmt: skip
            rest = read_scalar(inner, self.table, self.accelerations) if self.recurrence else gather_scalars(inner)
            result[s] = sp.Add(*parts, rest)
        return result

    # -- numbers -----------------------------------------------------------------------------------------------

    def name_fields(self) -> None:
        """Pseudo-coordinates and pseudo-speeds get the values of their fields, memory reads of their names."""
        for p in self.system.pseudo:
            velocity = sp.Add(*(gather_scalars(g) * self.system.field_speeds[q] for q, g in p.gradient.items()))
            self.values[p.coordinate] = self.read(gather_scalars(p.value), str(p.coordinate.func))
            self.values[p.speed] = self.read(gather_scalars(velocity), str(p.speed.func))

    def finish(self, expression: sp.Expr) -> sp.Expr:
        """Dots to cosines, pseudo-coordinates and -speeds to field values, the result a memory read."""
        return self.read(gather_scalars(transform(expression, self.cosines).xreplace(self.values)))

    def pseudo_relations(self) -> tuple[sp.Matrix, sp.Matrix]:
        """T and t of (ṡ, dφ̇, ṡ') = T (ṡ, dφ̇) + t."""
        pseudo, speeds, speed = self.system.pseudo, self.system.speeds, self.system.field_speeds
        n = len(speeds)
        T, t = sp.eye(n).row_insert(n, sp.zeros(len(pseudo), n)), sp.zeros(n + len(pseudo), 1)
        for row, p in enumerate(pseudo, n):
            for q, g in p.gradient.items():
                T[row, speeds.index(speed[q])] = self.finish(g)
            t[row] = self.finish(p.bias(speed))
        return T, t


def damping_force(beam: Beam, f: Field, psi: sp.Expr) -> sp.Expr:
    """∫ 2γ u_xt ψ_x dx of a bending field, or −∫ 2γ u_xxt ψ dx as printed in the paper (no boundary condition)."""
    if f.kind != "bending" or beam.damping == 0:
        return sp.S.Zero
    order = 1 if beam.damping_boundary else 2
    u_t = sp.Add(*(s * p.diff(X, order) for s, p in zip(f.speeds, f.shapes, strict=True)))
    weight = psi.diff(X) if beam.damping_boundary else -psi
    return integral(2 * beam.damping * u_t * weight, X, beam.length)


def derive_unevaluated(system: Description, recurrence: bool = True) -> Derivation:
    """Mass matrix and right-hand side for all speeds of the system, and the held equations."""
    steps = HeldDerivation(system, recurrence)
    wrenches = steps.wrenches()
    ordinary = [s for s in system.speeds if s not in system.field_speeds.values()]
    pseudo = [p.speed for p in system.pseudo]
    held = {s: gather_dots(steps.ordinary(wrenches, s)) for s in [*ordinary, *pseudo]}
    for beam in system.beams:
        held |= steps.weak(beam)
    extended = [*system.speeds, *pseudo]
    steps.name_fields()
    symbols = [system.accelerations[s] for s in extended]
    n, split = len(extended), LinearSplit(symbols)
    I, E0 = sp.zeros(n, n), sp.zeros(n, 1)
    for i, s in enumerate(extended):
        coefficients, rest = split(held[s])
        E0[i] = steps.finish(rest)
        for j in range(i, n):
            I[i, j] = I[j, i] = steps.finish(-coefficients.get(symbols[j], sp.S.Zero))
    complete = dict(held)
    for p in system.pseudo:  # the boundary terms of (B)
        for q, g in p.gradient.items():
            complete[system.field_speeds[q]] += held[p.speed] * g
    T, t = steps.pseudo_relations()
    mass = (T.T * I * T).applyfunc(sp.expand) if not recurrence else T.T * I * T
    return Derivation(mass, T.T * (E0 - I * t), steps.table, steps.cosines, steps.values, complete)
