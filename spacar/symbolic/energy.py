"""Kinetic and potential energy of a system, and the power of its loads."""

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.beam_shapes import X, integral
from spacar.symbolic.derivation import DerivedEquations
from spacar.symbolic.description import Description
from spacar.symbolic.held import damping_force
from spacar.symbolic.reference_frames import omega
from spacar.symbolic.system_parts import DistributedLoad, GeometricPoint
from spacar.symbolic.vectors import Vector, dot


def kinetic_energy(eq: DerivedEquations) -> sp.Expr:
    """½ sᵀ I s [J]. UsageError when velocities contain parts without speeds (prescribed motion)."""
    at_rest = dict.fromkeys(eq.system.speeds, sp.S.Zero)
    points = [b.point.velocity for b in eq.system.bodies] + [b.root.velocity for b in eq.system.beams]
    frames = [b.frame for b in eq.system.bodies if b.frame] + [b.frame for b in eq.system.beams]
    still = at_rest | {p.speed: sp.S.Zero for p in eq.system.pseudo}
    for v in [*points, *(omega(eq.system.N, f) for f in frames)]:
        if v.xreplace(still):
            raise UsageError("kinetic energy from the mass matrix needs velocities that are linear in the speeds")
    s = sp.Matrix(eq.speeds)
    return (s.T * eq.mass_matrix * s)[0] / 2


def potential_energy(eq: DerivedEquations) -> sp.Expr:
    """Gravity, strain energy of the fields and springs [J]; zero at the origin, with unstrained fields."""
    system = eq.system
    total = sp.Add(*(spring.energy() for spring in system.springs))
    for body in system.bodies:
        total -= body.mass * dot(system.gravity, position(system, body.point))
    for beam in system.beams:
        place = beam.offset.xreplace(beam.shape(X))
        offset: Vector = place.map(lambda c, beam=beam: integral(c * beam.mass, X, beam.length))
        weight = dot(system.gravity, position(system, beam.root)) * beam.total_mass
        total -= weight + dot(system.gravity, offset)
        total += sp.Add(*(f.strain_energy(beam.length) for f in beam.fields))
    return eq.scalar(total)


def position(system: Description, point: GeometricPoint) -> Vector:
    """Position from the origin. UsageError for a point of which only the velocity is known, under gravity."""
    here: GeometricPoint | None = point
    while here is not None and system.gravity:
        if here.given and here.base is system.O and not here.offset:
            raise UsageError(f"point {here.name} has no position: potential energy is unknown")
        here = here.base
    return point.position


def power(eq: DerivedEquations) -> sp.Expr:
    """Power [W] of forces, torques, spring dampers and field damping (inputs as symbols)."""
    system = eq.system
    total = sp.Add(*(-s.damping * s.lengthening**2 for s in system.springs))
    for load in system.loads:
        if load.point is not None:
            total += dot(load.vector, load.point.velocity)
        for frame, sign in load.turned:
            total += sign * dot(load.vector, omega(system.N, frame))
    for spread in system.distributed_loads:
        total += _power_along(system, spread)
    for beam in system.beams:
        for f in beam.fields:
            for s, psi in zip(f.speeds, f.shapes, strict=True):
                total -= s * damping_force(beam, f, psi)
    return eq.scalar(total)


def _power_along(system: Description, load: DistributedLoad) -> sp.Expr:
    """∫ f·v dx of a force per length."""
    beam = load.beam
    velocity = beam.root.velocity + system.ddt(system.N, beam.offset).xreplace(beam.assumed(system.accelerations))
    return integral(dot(load.vector, velocity), X, beam.length)
