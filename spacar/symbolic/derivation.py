"""Equations of motion I(q) ṡ = f(q, s, inputs), with the Z variables they read, as one immutable result."""

from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.collect import ZTable
from spacar.symbolic.description import Description
from spacar.symbolic.ordered import ConstraintRows
from spacar.symbolic.transform import DirectionCosines, transform
from spacar.symbolic.unit_vectors import ByExpression, Definitions, Scalars, UnevaluatedDot


@dataclass(frozen=True)
class Derivation:
    """What a strategy delivers: I and f for all speeds of the system, the table of Z variables, held equations.

    `values` are the field values that stand for pseudo-coordinates and pseudo-speeds.
    """

    mass_matrix: sp.Matrix
    rhs: sp.Matrix
    table: ZTable
    cosines: DirectionCosines
    values: ByExpression
    held: ByExpression = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class DerivedEquations:
    """The equations of motion as data.

    coordinates q, speeds s; `kinematics` {q: q̇(q, s)}; `definitions` {Z: expression} in reading order;
    `mass_matrix` (n, n) symmetric and `rhs` (n, 1), in cosines and Z; `held` {speed: equation in vector notation}
    for the held strategy, pseudo-speeds included; `constraints` J, γ, e, g or None; `seconds` of derivation.
    With constraints I ṡ = f + Jᵀ λ, J ṡ + γ = 0.
    """

    system: Description
    strategy: str
    coordinates: Scalars
    speeds: Scalars
    kinematics: ByExpression
    definitions: Definitions
    mass_matrix: sp.ImmutableMatrix
    rhs: sp.ImmutableMatrix
    held_by_speed: ByExpression
    table: ZTable
    cosines: DirectionCosines
    seconds: float
    constraints: ConstraintRows | None = None

    @property
    def held(self) -> Scalars:
        """The equations 0 = E(s) in vector notation, in the order of the speeds (UsageError when recursive)."""
        if not self.held_by_speed:
            raise UsageError("only the held strategy keeps equations in vector notation: derive(strategy='held')")
        return tuple(self.held_by_speed[s] for s in self.system.speeds)

    def transform(self) -> Scalars:
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
        value = system.expression(value, outputs=True)
        known = len(self.table.definitions)
        value = transform(value, cosines or self.cosines) if value.has(UnevaluatedDot) else value
        for z in list(self.table.definitions)[known:]:  # cosines that the equations did not need
            self.table.definitions[z] = self.table.definitions[z].xreplace(system.pseudo_values())
        speeds, a = system.field_speeds, system.accelerations
        moved = {a[p.speed]: p.acceleration(speeds, a) for p in system.pseudo if value.has(a[p.speed])}
        return value.xreplace(moved).xreplace(system.pseudo_values())

    def count_ops(self) -> int:
        """Operations of the definitions, the upper triangle of I and the right-hand side, before cse."""
        n = len(self.speeds)
        upper = [self.mass_matrix[i, j] for i in range(n) for j in range(i, n)]
        return sum(int(sp.count_ops(e)) for e in [*self.definitions.values(), *upper, *self.rhs])
