"""Equations of motion I(q) ṡ = f(q, s, inputs), with the Z variables they read, as one immutable result."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.collect import ZTable, definition_order, gather_scalars
from spacar.symbolic.constraints import ConstraintRows, check_constraints, constraint_rows
from spacar.symbolic.transform import DirectionCosines, transform
from spacar.symbolic.units import HeldScalar

if TYPE_CHECKING:
    from spacar.symbolic.program import Program
    from spacar.symbolic.system import System

STRATEGIES = ("held", "recursive")


@dataclass(frozen=True)
class Derivation:
    """What a strategy delivers: I and f for all speeds of the system, the table of Z variables, held equations.

    `values` are the field values that stand for pseudo-coordinates and pseudo-speeds.
    """

    mass_matrix: sp.Matrix
    rhs: sp.Matrix
    table: ZTable
    cosines: DirectionCosines
    values: dict[sp.Expr, sp.Expr]
    held: dict[sp.Expr, sp.Expr] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Equations:
    """The equations of motion.

    coordinates q, speeds s; `kinematics` {q: q̇(q, s)}; `definitions` {Z: expression} in reading order;
    `mass_matrix` (n, n) symmetric and `rhs` (n, 1), in cosines and Z; `held` {speed: equation in vector notation}
    for the held strategy, pseudo-speeds included; `constraints` J, γ, e, g or None; `seconds` of derivation.
    With constraints I ṡ = f + Jᵀ λ, J ṡ + γ = 0.
    """

    system: System
    strategy: str
    coordinates: tuple[sp.Expr, ...]
    speeds: tuple[sp.Expr, ...]
    kinematics: dict[sp.Expr, sp.Expr]
    definitions: dict[sp.Symbol, sp.Expr]
    mass_matrix: sp.ImmutableMatrix
    rhs: sp.ImmutableMatrix
    held_by_speed: dict[sp.Expr, sp.Expr]
    table: ZTable
    cosines: DirectionCosines
    seconds: float
    constraints: ConstraintRows | None = None

    @property
    def held(self) -> tuple[sp.Expr, ...]:
        """The equations 0 = E(s) in vector notation, in the order of the speeds (UsageError when recursive)."""
        if not self.held_by_speed:
            raise UsageError("only the held strategy keeps equations in vector notation: derive(strategy='held')")
        return tuple(self.held_by_speed[s] for s in self.system.speeds)

    def transform(self) -> tuple[sp.Expr, ...]:
        """The held equations with every product of unit vectors written in cosines and sines."""
        plain = DirectionCosines()
        return tuple(transform(e, plain) for e in self.held)

    def expand(self, expression: Any) -> Any:
        """Put the definitions of all Z variables back into an expression or matrix."""
        for symbol, definition in reversed(self.definitions.items()):
            expression = expression.xreplace({symbol: definition})
        return expression

    def explicit(self) -> tuple[sp.Matrix, sp.Matrix]:
        """Mass matrix and right-hand side without Z variables."""
        return sp.Matrix(self.expand(self.mass_matrix)), sp.Matrix(self.expand(self.rhs))

    def scalar(self, value: Any, cosines: DirectionCosines | None = None) -> sp.Expr:
        """An output expression ready for a program: held products, pseudo-coordinates and their rates replaced.

        Accelerations ṡ and constraint forces λ stay symbols. Cosines are memory reads unless `cosines` are given.
        """
        system = self.system
        value = system.expression(value)
        value = transform(value, cosines or self.cosines) if value.has(HeldScalar) else value
        speeds, a = system.field_speeds, system.accelerations
        moved = {a[p.speed]: p.acceleration(speeds, a) for p in system.pseudo if value.has(a[p.speed])}
        return value.xreplace(moved).xreplace(system.pseudo_values())

    def energy(self) -> tuple[sp.Expr, sp.Expr]:
        """Kinetic and potential energy [J] (gravity, strain, springs); see `energy.py`."""
        from spacar.symbolic.energy import kinetic_energy, potential_energy

        return kinetic_energy(self), potential_energy(self)

    def program(self, outputs: dict[str, Any] | None = None) -> Program:
        """The ordered program that evaluates the equations and the named outputs."""
        from spacar.symbolic.program import make_program

        return make_program(self, outputs or {})

    def linearize(self, values: dict[str, float], point: dict[str, float] | None = None) -> Any:
        """M0, C0, K0 at a point; see `linearize.py`."""
        from spacar.symbolic.linearize import linearize

        return linearize(self, values, point or {})

    def check(self, digits: int = 30) -> Any:
        """Energy balance and constraints at a random state; see `checks.py`."""
        from spacar.symbolic.checks import check

        return check(self, digits)

    def strong_form(self, beam: Any, name: str = "u") -> Any:
        """Field equation and boundary conditions of a field of a beam; see `strong.py`."""
        from spacar.symbolic.strong import strong_form

        return strong_form(self, beam, name)

    def count_ops(self) -> int:
        """Operations of the definitions, the upper triangle of I and the right-hand side, before cse."""
        n = len(self.speeds)
        upper = [self.mass_matrix[i, j] for i in range(n) for j in range(i, n)]
        return sum(int(sp.count_ops(e)) for e in [*self.definitions.values(), *upper, *self.rhs])


def derive(system: System, strategy: str, recurrence: bool = True) -> Equations:
    """Derive by one of `STRATEGIES`; the constraints are added afterwards, in the same way for both."""
    start = time.perf_counter()
    check_constraints(system)
    if strategy == "held":
        from spacar.symbolic.held import derive_held

        derivation = derive_held(system, recurrence)
    elif strategy == "recursive":
        from spacar.symbolic.recursive import derive_recursive

        derivation = derive_recursive(system)
    else:
        raise UsageError(f"unknown strategy {strategy!r}: choose one of {', '.join(STRATEGIES)}")
    table = derivation.table
    for z in list(table.definitions):  # in three dimensions measure numbers contain dots; cosines are new definitions
        if table.definitions[z].has(HeldScalar):
            table.definitions[z] = transform(table.definitions[z], derivation.cosines)
    for z, definition in table.definitions.items():
        table.definitions[z] = definition.xreplace(derivation.values)
    constraints = None
    if system.constraints:

        def read(expression: sp.Expr) -> sp.Expr:
            value = gather_scalars(transform(expression, derivation.cosines).xreplace(derivation.values))
            return table.read(value) if recurrence else value

        constraints = constraint_rows(system, read)
    kinematics = {q: system.rates[q.diff()].xreplace(derivation.values) for q in system.coordinates}
    for z, definition in table.definitions.items():  # cosines of the constraints may be new
        table.definitions[z] = definition.xreplace(derivation.values)
    rows = [*constraints.matrix, *constraints.bias, *constraints.velocity] if constraints else []
    places = constraints.position.values() if constraints else []
    needed = [*derivation.mass_matrix, *derivation.rhs, *kinematics.values(), *rows, *places]
    order = definition_order(table.definitions, needed)
    return Equations(
        system=system,
        strategy=strategy,
        coordinates=tuple(system.coordinates),
        speeds=tuple(system.speeds),
        kinematics=kinematics,
        definitions={z: table.definitions[z] for z in order},
        mass_matrix=sp.ImmutableMatrix(derivation.mass_matrix),
        rhs=sp.ImmutableMatrix(derivation.rhs),
        held_by_speed=derivation.held,
        table=table,
        cosines=derivation.cosines,
        seconds=time.perf_counter() - start,
        constraints=constraints,
    )
