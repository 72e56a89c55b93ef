"""Energies of a system, the power of its loads, and a check of derived equations that needs no second derivation.

At a random state, with random positive parameters and many digits, along the motion y' = (q̇, ṡ):

    d(T + V)/dt = power of loads and dampers + λᵀ J s,     de/dt = 0,     dg/dt = e

The left sides are central differences with a step of 10^−digits at three times as many digits, through the energies and
the constraints as they were written and not through J, γ or a derivative of the program.
"""

import random
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
import sympy as sp

from spacar.arrays import EPS
from spacar.errors import AnalysisError, UsageError
from spacar.symbolic.beam_shapes import X, integral
from spacar.symbolic.collect import definition_order
from spacar.symbolic.derivation import DerivedEquations
from spacar.symbolic.description import Description
from spacar.symbolic.held import damping_force
from spacar.symbolic.ordered import UNCONSTRAINED, plain_symbols
from spacar.symbolic.reference_frames import omega
from spacar.symbolic.system_parts import GeometricPoint
from spacar.symbolic.unit_vectors import TIME
from spacar.symbolic.vectors import Vector, dot

LARGEST = 1e-12
"""30 digits leave 1e-28 in equations that are right; a wrong term is of order one."""


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
    if system.gravity and (lost := point.adrift):
        raise UsageError(f"point {lost.name} has no position: potential energy is unknown")
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
    for spread in system.distributed_loads:  # ∫ f·v dx
        beam = spread.beam
        along = system.ddt(system.N, beam.offset).xreplace(beam.assumed(system.accelerations))
        total += integral(dot(spread.vector, beam.root.velocity + along), X, beam.length)
    for beam in system.beams:
        for f, _, s, psi in beam.modes:
            total -= s * damping_force(beam, f, psi)
    return eq.scalar(total)


@dataclass(frozen=True)
class DerivationCheck:
    """`energy_error`: |d(T + V)/dt − power| over the largest part, None when the system has no energy.

    `constraint_error`: largest of |de/dt| and |dg/dt − e| over their parts, None without constraints. `positive`: the
    mass matrix is definite on the motions that the constraints leave. `note` says why there is no energy.
    """

    energy_error: float | None
    positive: bool
    constraint_error: float | None = None
    note: str = ""

    @property
    def error(self) -> float:
        return max(self.energy_error or 0.0, self.constraint_error or 0.0)

    def __str__(self) -> str:
        energy = f"energy {self.energy_error:.1e}" if self.energy_error is not None else f"no energy ({self.note})"
        tied = "" if self.constraint_error is None else f", constraints {self.constraint_error:.1e}"
        return f"{energy}{tied}, mass matrix {'positive definite' if self.positive else 'not positive definite'}"

    def demand(self) -> None:
        """AnalysisError when the equations contradict the energy or the constraints they were derived from."""
        if self.error > LARGEST:
            raise AnalysisError(
                f"the equations contradict their own energy or constraints ({self}): a velocity that was given does "
                "not fit its point, or this is an error of the derivation",
                "check",
            )


def check(eq: DerivedEquations, digits: int = 30, seed: int = 1) -> DerivationCheck:
    """Evaluate at a random state and random positive parameters with `digits` digits."""
    import mpmath  # type: ignore[import-untyped]

    note, energies = "", {}
    try:
        kinetic, potential = kinetic_energy(eq), potential_energy(eq)
        energies = {"E": kinetic + potential, "power": power(eq)}
    except UsageError as error:
        note = str(error)
    n, c = len(eq.speeds), eq.constraints or UNCONSTRAINED
    m = len(c.names)
    wanted = {
        "rates": list(eq.kinematics.values()), "mass": list(eq.mass_matrix), "rhs": list(eq.rhs),
        "J": list(c.matrix), "bias": list(c.bias), "e": list(c.velocity), "g": list(c.position.values()),
        **{k: [v] for k, v in energies.items()},
    }  # fmt: skip
    evaluate = _Evaluator(eq, wanted)
    chance = random.Random(seed)
    with mpmath.workdps(3 * digits):
        point = {name: mpmath.mpf(chance.uniform(0.4, 1.2)) for name in evaluate.names}
        here = evaluate(point)
        rows = [here["J"][k * n : k * n + n] for k in range(m)]
        both = [here["mass"][i * n : i * n + n] + [-row[i] for row in rows] for i in range(n)]
        both += [row + m * [0] for row in rows]
        right = here["rhs"] + [-b for b in here["bias"]]
        positive = _positive(np.array(here["mass"], float).reshape(n, n), np.array(here["J"], float).reshape(m, n))
        try:
            solution = mpmath.lu_solve(mpmath.matrix(both), mpmath.matrix(right))
        except ZeroDivisionError:
            return DerivationCheck(None, False, None, "the mass matrix is singular")
        step = mpmath.mpf(10) ** -digits
        speeds = [point[str(s)] for s in evaluate.speeds]
        motion = dict(zip([*evaluate.coordinates, *evaluate.speeds], [*here["rates"], *solution[:n]], strict=True))
        motion[str(TIME)] = mpmath.mpf(1)
        moved = [evaluate({k: v + d * step * motion.get(k, 0) for k, v in point.items()}) for d in (1, -1)]

        def slope(name: str) -> list[Any]:
            return [(a - b) / (2 * step) for a, b in zip(moved[0][name], moved[1][name], strict=True)]

        energy_error = None
        if energies:
            forces = [solution[n + k] * rows[k][i] * speeds[i] for k in range(m) for i in range(n)]
            parts = [here["power"][0], *forces]
            inertia = [s * x for s, x in zip(speeds, here["rhs"], strict=True)]
            total = abs(slope("E")[0] - sum(parts))
            scale = max([abs(x) for x in [*parts, *inertia, slope("E")[0]]])
            energy_error = float(total / scale) if scale else 0.0
        errors = []
        for k, de in enumerate(slope("e")):
            parts = [*(j * a for j, a in zip(rows[k], solution, strict=False)), here["bias"][k], *rows[k]]
            errors.append(float(abs(de) / max(map(abs, parts))))
        for at, dg in zip(c.position, slope("g"), strict=True):
            parts = [j * s for j, s in zip(rows[at], speeds, strict=True)] + [here["e"][at]]
            errors.append(float(abs(dg - here["e"][at]) / max(map(abs, parts))))
    return DerivationCheck(energy_error, positive, max(errors) if errors else None, note)


def _positive(M: np.ndarray, J: np.ndarray) -> bool:
    """Definite on the null space of J, in units in which the diagonal of M is one."""
    size = np.sqrt(np.where(M.diagonal() > 0, M.diagonal(), 1.0))
    n, m = len(M), len(J)
    free = np.linalg.svd(J / size)[2][m:].T if m else np.eye(n)
    values = np.linalg.eigvalsh(free.T @ (M / np.outer(size, size)) @ free)
    return bool(np.all(values > n * EPS))


class _Evaluator:
    """Lists of expressions as one function of named numbers, through the definitions of the equations."""

    def __init__(self, eq: DerivedEquations, wanted: Mapping[str, list[sp.Expr]]) -> None:
        flat = [e for group in wanted.values() for e in group]
        definitions = definition_order(eq.table.definitions, flat)
        rule = plain_symbols([*definitions, *definitions.values(), *flat, *eq.coordinates, *eq.speeds])
        self.coordinates = [rule[q].name for q in eq.coordinates]
        self.speeds = [rule[s].name for s in eq.speeds]
        known = {rule[z] for z in definitions}
        used = set().union(*(e.xreplace(rule).free_symbols for e in [*definitions.values(), *flat])) - known
        used |= {rule[s] for s in [*eq.coordinates, *eq.speeds]}
        self.names = sorted(s.name for s in used)
        given = sorted(used, key=str)  # names of the model stay out of the text that is executed
        local = {s: sp.Symbol(f"v{k}") for k, s in enumerate([*given, *(rule[z] for z in definitions)])}

        def plain(e: sp.Expr) -> sp.Expr:
            return e.xreplace(rule).xreplace(local)

        steps = [(local[rule[z]], plain(e)) for z, e in definitions.items()]
        arguments, results = [local[s] for s in given], [plain(e) for e in flat]
        self.function = sp.lambdify(arguments, results, "mpmath", cse=lambda e: (steps, e))
        self.sizes = {name: len(group) for name, group in wanted.items()}

    def __call__(self, point: Mapping[str, Any]) -> dict[str, list[Any]]:
        found = iter(self.function(*(point[name] for name in self.names)))
        return {name: list(islice(found, size)) for name, size in self.sizes.items()}
