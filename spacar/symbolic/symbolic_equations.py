"""`derive`: a strategy and the constraints make the equations of motion, which know what can be done with them."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.collect import definition_order, gather_scalars
from spacar.symbolic.constraints import check_constraints, constraint_rows
from spacar.symbolic.derivation import DerivedEquations
from spacar.symbolic.derivation_check import DerivationCheck, check
from spacar.symbolic.description import Description
from spacar.symbolic.energy import kinetic_energy, potential_energy
from spacar.symbolic.held import derive_unevaluated
from spacar.symbolic.linearize import Linearized, linearize
from spacar.symbolic.program import EquationProgram, make_program
from spacar.symbolic.recursive import derive_recursive
from spacar.symbolic.strong import StrongForm, strong_form
from spacar.symbolic.transform import transform
from spacar.symbolic.unit_vectors import UnevaluatedDot

STRATEGIES = ("held", "recursive")


@dataclass(frozen=True, eq=False)
class SymbolicEquations(DerivedEquations):
    """Derived equations with what follows from them: energies, programs, linearization, checks, strong form."""

    def energy(self) -> tuple[sp.Expr, sp.Expr]:
        """Kinetic and potential energy [J] (gravity, strain, springs); see `energy.py`."""
        return kinetic_energy(self), potential_energy(self)

    def program(self, outputs: dict[str, Any] | None = None) -> EquationProgram:
        """The ordered program that evaluates the equations and the named outputs."""
        return make_program(self, outputs or {})

    def linearize(self, values: dict[str, float], point: dict[str, float] | None = None) -> Linearized:
        """M0, C0, K0 at a point; see `linearize.py`."""
        return linearize(self, values, point or {})

    def check(self, digits: int = 30) -> DerivationCheck:
        """Energy balance and constraints at a random state; see `derivation_check.py`."""
        return check(self, digits)

    def strong_form(self, beam: Any, name: str = "u") -> StrongForm:
        """Field equation and boundary conditions of a field of a beam; see `strong.py`."""
        return strong_form(self, beam, name)


def derive(system: Description, strategy: str, recurrence: bool = True) -> SymbolicEquations:
    """Derive by one of `STRATEGIES`; the constraints are added afterwards, in the same way for both."""
    start = time.perf_counter()
    check_constraints(system)
    if strategy == "held":
        derivation = derive_unevaluated(system, recurrence)
    elif strategy == "recursive":
        derivation = derive_recursive(system)
    else:
        raise UsageError(f"unknown strategy {strategy!r}: choose one of {', '.join(STRATEGIES)}")
    table = derivation.table
    for z in list(table.definitions):  # in three dimensions measure numbers contain dots; cosines are new definitions
        if table.definitions[z].has(UnevaluatedDot):
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
    return SymbolicEquations(
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
