"""`derive`: a strategy and the constraints make the equations of motion, which know what can be done with them.

The strong form of a field equation is what the assumed field solves approximately, for reading; its boundary terms are
(A) of `held.py` for pseudo-speeds. Source: the paper, (13) to (20); `symbolic.md`, section 3.3.

Linearized equations M0 δs̈ + C0 δṡ + K0 δq = 0 about a state of rest, with the names of the numeric core.

With position constraints δq = T δq_i, J T = 0, in independent speeds chosen by pivoting. The forces λ stay constant in
the derivatives of f − I a + Jᵀ λ, so that K0 has the part of the curved constraints; Tᵀ takes the change of λ out.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.beam_shapes import X
from spacar.symbolic.closure import Manifold
from spacar.symbolic.collect import definition_order, gather_scalars
from spacar.symbolic.constraints import check_constraints, constraint_rows
from spacar.symbolic.derivation import Derivation, DerivedEquations
from spacar.symbolic.derivation_check import DerivationCheck, check, kinetic_energy, potential_energy
from spacar.symbolic.description import Description
from spacar.symbolic.held import derive_unevaluated
from spacar.symbolic.program import EquationProgram, make_program
from spacar.symbolic.recursion import Recursion, Sums
from spacar.symbolic.recursive_beam import add_beam
from spacar.symbolic.reference_frames import dvdt
from spacar.symbolic.system_parts import Beam
from spacar.symbolic.transform import transform
from spacar.symbolic.unit_vectors import TIME, Scalars, UnevaluatedDot
from spacar.symbolic.vectors import dot

STRATEGIES = ("held", "recursive")


def derive_recursive(system: Description) -> Derivation:
    """Mass matrix and right-hand side for all speeds of the system."""
    recursion = Recursion(system)
    sums = Sums(list(system.speeds))
    for body in system.bodies:
        recursion.body(body, sums)
    for beam in system.beams:
        add_beam(recursion, beam, sums)
    for load in system.all_loads():
        recursion.load(load, sums)
    n = len(system.speeds)
    I, f = sp.zeros(n, n), sp.zeros(n, 1)
    for (i, j), parts in sums.mass.items():
        I[i, j] = I[j, i] = sp.Add(*parts)
    for i, parts in sums.force.items():
        f[i] = sp.Add(*parts)
    return Derivation(I, f, recursion.table, recursion.cosines, recursion.values)


@dataclass(frozen=True)
class StrongForm:
    """`equation` = 0 along the beam; `essential` = 0 at x = 0; `natural` pairs (left, right), equal at x = L."""

    equation: sp.Expr
    essential: Scalars
    natural: tuple[tuple[sp.Expr, sp.Expr], ...]


@dataclass(frozen=True, eq=False)
class SymbolicEquations(DerivedEquations):
    """Derived equations with what follows from them: energies, programs, linearization, checks, strong form."""

    def energy(self) -> tuple[sp.Expr, sp.Expr]:
        """Kinetic and potential energy [J] (gravity, strain, springs); see `derivation_check.py`."""
        return kinetic_energy(self), potential_energy(self)

    def program(self, outputs: dict[str, Any] | None = None) -> EquationProgram:
        """The ordered program that evaluates the equations and the named outputs."""
        return make_program(self, outputs or {})

    def linearize(self, values: dict[str, float], point: dict[str, float] | None = None) -> Linearized:
        """Derivatives of f(q, s) − I(q) a at `point` (states by name, others zero) with a the accelerations there.

        Inputs with a law are differentiated with it. Raises UsageError when the coordinates do not correspond to the
        speeds one to one (q̇ = s), because K0 would not be square.
        """
        if len(self.coordinates) != len(self.speeds) or any(
            self.kinematics[q] != s for q, s in zip(self.coordinates, self.speeds, strict=True)
        ):
            raise UsageError("M0, C0, K0 need every speed to be the derivative of its coordinate")
        program = self.program()
        f = program.function(values, jacobian=True)
        names = [str(s.func) for s in (*self.coordinates, *self.speeds)]
        y = [float((point or {}).get(name, 0.0)) for name in names]
        n = len(self.speeds)
        upper, _ = f.accel(y, f.inputs(0.0, y))
        M0 = np.zeros((n, n))
        M0[np.triu_indices(n)] = upper
        M0 += np.triu(M0, 1).T
        slopes = -M0 @ np.asarray(f.jac(0.0, y))[n:]
        speeds = tuple(str(s.func) for s in self.speeds)
        if self.constraints is None:
            return Linearized(speeds, M0, slopes[:, n:], slopes[:, :n])
        if len(self.constraints.position) != len(self.constraints.names):
            raise UsageError(
                "M0, C0, K0 need constraints of positions: a velocity constraint leaves more coordinates than speeds"
            )
        manifold = Manifold(program, f)
        place = np.array(y)
        if np.max(np.abs(manifold.project(0.0, place) - place)) > 1e-6 * max(np.max(np.abs(place)), 1e-3):
            raise UsageError("the point of linearization does not satisfy the constraints")
        free, T = _independent(f.manifold(0.0, y)[1], M0)
        M, C, K = (T.T @ A @ T for A in (M0, slopes[:, n:], slopes[:, :n]))
        return Linearized(tuple(speeds[k] for k in free), M, C, K)

    def check(self, digits: int = 30) -> DerivationCheck:
        """Energy balance and constraints at a random state; see `derivation_check.py`."""
        return check(self, digits)

    def strong_form(self, beam: Beam, name: str = "u") -> StrongForm:
        """Field equation of the bending field `name` in vector notation, with held boundary terms.

        Raises UsageError for recursive equations (they keep no vectors) and for fields that are not bending fields.
        """
        if not self.held_by_speed:
            raise UsageError("the strong form needs equations in vector notation: derive(strategy='held')")
        found = next((f for f in beam.fields if f.kind == "bending" and f.name == name), None)
        if found is None:
            raise UsageError(f"beam {beam.name} has no bending field {name!r}")
        system, u, EI = self.system, found.function, found.stiffness
        velocity = beam.root.velocity + dvdt(system.N, beam.offset).xreplace(system.rates)
        acceleration = dvdt(system.N, velocity).xreplace(system.rates)
        direction = beam.frame[found.direction]
        inertia = beam.mass * dot(acceleration - system.gravity, direction)
        damping = 2 * beam.damping
        equation = (EI * u.diff(X, 2)).diff(X, 2) + sp.expand(inertia) - damping * u.diff(X, 2, TIME)
        letters = f"{beam.name}_{name}"
        E = {str(s.func): e for s, e in self.held_by_speed.items()}
        natural = (
            (EI * u.diff(X, 2), E[f"{letters}xt"]),
            (-(EI * u.diff(X, 2)).diff(X) + damping * u.diff(X, TIME), E[f"{letters}t"]),
        )
        return StrongForm(equation, (u, u.diff(X)), natural)


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
    constraints = None
    if system.constraints:

        def read(expression: sp.Expr) -> sp.Expr:
            value = gather_scalars(transform(expression, derivation.cosines).xreplace(derivation.values))
            return table.read(value) if recurrence else value

        constraints = constraint_rows(system, read)
    kinematics = {q: system.rates[q.diff()].xreplace(derivation.values) for q in system.coordinates}
    for z, definition in table.definitions.items():
        table.definitions[z] = definition.xreplace(derivation.values)
    rows = [*constraints.matrix, *constraints.bias, *constraints.residual] if constraints else []
    needed = [*derivation.mass_matrix, *derivation.rhs, *kinematics.values(), *rows]
    return SymbolicEquations(
        system=system, strategy=strategy, coordinates=tuple(system.coordinates), speeds=tuple(system.speeds),
        kinematics=kinematics, definitions=definition_order(table.definitions, needed),
        mass_matrix=sp.ImmutableMatrix(derivation.mass_matrix), rhs=sp.ImmutableMatrix(derivation.rhs),
        held_by_speed=derivation.held, table=table, cosines=derivation.cosines, seconds=time.perf_counter() - start,
        constraints=constraints,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Linearized:
    """M0, C0 (damping and gyroscopic terms), K0 of shape (n, n) in the order of `speeds`."""

    names: tuple[str, ...]
    M0: np.ndarray
    C0: np.ndarray
    K0: np.ndarray

    def eigenvalues(self) -> np.ndarray:
        """Eigenvalues of the state matrix [1/s], sorted by modulus."""
        n = len(self.names)
        A = np.block([[np.zeros((n, n)), np.eye(n)], [np.linalg.solve(self.M0, -np.hstack((self.K0, self.C0)))]])
        values: np.ndarray = np.linalg.eigvals(A)
        return values[np.argsort(abs(values))]


def _independent(J: np.ndarray, M: np.ndarray) -> tuple[list[int], np.ndarray]:
    """Independent speeds and T with J T = 0, T the unit matrix in them; pivots in mass units."""
    from scipy.linalg import qr

    D = 1 / np.sqrt(np.where(M.diagonal() > 0, M.diagonal(), 1.0))
    m, n = J.shape
    _, _, order = qr(J * D, pivoting=True)
    tied, free = sorted(order[:m].tolist()), sorted(order[m:].tolist())
    T = np.zeros((n, n - m))
    T[free, np.arange(n - m)] = 1.0
    T[tied] = -np.linalg.solve(J[:, tied], J[:, free])
    return free, T
