"""Elimination of dependent speeds: minimal equations of non-holonomic systems without multipliers.

From J s + c = 0 follow s_d = A s_i + b and ṡ_d = A ṡ_i + β, where β holds everything without accelerations
(Ȧ s_i + ḃ included). The equations E_i + Aᵀ E_d = 0 are then

    (I_ii + I_id A + Aᵀ I_di + Aᵀ I_dd A) ṡ_i = f_i + Aᵀ f_d − (I_id + Aᵀ I_dd) β

The equations that are dropped give the constraint forces: J_dᵀ λ = (I ṡ − f)_d, with generalized forces Jᵀ λ.

Source: `symbolic.md`, section 3.5.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp
from sympy.core.function import AppliedUndef

from spacar.errors import UsageError
from spacar.symbolic.collect import split_linear
from spacar.symbolic.derivatives import rate
from spacar.symbolic.transform import transform
from spacar.symbolic.units import TIME, HeldScalar

if TYPE_CHECKING:
    from spacar.symbolic.equations import Derivation
    from spacar.symbolic.parts import Constraint
    from spacar.symbolic.system import System


@dataclass(frozen=True)
class Reduced:
    """Equations in the independent speeds, and {dependent speed function: its Z variable}.

    `reactions` (C, d): constraint forces λ = C ṡ_i + d, one for each constraint; None without constraints.
    """

    speeds: tuple[sp.Expr, ...]
    mass_matrix: sp.Matrix
    rhs: sp.Matrix
    dependent: dict[sp.Expr, sp.Symbol]
    reactions: tuple[sp.Matrix, sp.Matrix] | None = None

    def put_in(self, expression: sp.Expr) -> sp.Expr:
        return expression.xreplace(self.dependent)


def eliminate_dependent_speeds(system: System, derivation: Derivation) -> Reduced:
    """Reduce the derived equations; the derivation itself when there are no constraints.

    Raises UsageError when a constraint is not linear in the speeds, or the constraints depend on each other.
    """
    speeds = tuple(system.speeds)
    if not system.constraints:
        return Reduced(speeds, derivation.mass_matrix, derivation.rhs, {})
    rows, rest = constraint_rows(system)
    d = choose_dependent(system, rows)
    i = [k for k in range(len(speeds)) if k not in d]
    table, cosines = derivation.table, derivation.cosines

    def read(expression: sp.Expr) -> sp.Expr:
        held = expression.atoms(HeldScalar)
        return table.read(expression.xreplace({atom: cosines.value(atom) for atom in sorted(held, key=str)}))

    J, c = rows.applyfunc(read), rest.applyfunc(read)
    Jd, Ji = J.extract(range(J.rows), d), J.extract(range(J.rows), i)
    solved = Jd.LUsolve(sp.Matrix.hstack(-Ji, -c)).applyfunc(table.read)
    A, b = solved[:, :-1], solved[:, -1]
    independent = sp.Matrix([speeds[k] for k in i])
    values = A * independent + b
    dependent = {speeds[k]: table.read(values[n], name=f"{speeds[k].func}_") for n, k in enumerate(d)}
    at_rest = {a: sp.S.Zero for a in system.accelerations.values()}
    bias_rates = sp.Matrix([rate(k.expression).xreplace(system.rates).xreplace(at_rest) for k in system.constraints])
    beta = Jd.LUsolve(-bias_rates.applyfunc(lambda e: read(e.xreplace(dependent)))).applyfunc(table.read)
    for symbol in list(table.definitions):  # definitions that were made before the dependent speeds were known
        table.definitions[symbol] = table.definitions[symbol].xreplace(
            {s: z for s, z in dependent.items() if z is not symbol}
        )
    I, f = derivation.mass_matrix.xreplace(dependent), derivation.rhs.xreplace(dependent)
    Iii, Iid, Idd = I.extract(i, i), I.extract(i, d), I.extract(d, d)
    left = (Iid + A.T * Idd).applyfunc(table.read)
    mass = Iii + left * A + A.T * Iid.T
    rhs = f.extract(i, [0]) + A.T * f.extract(d, [0]) - left * beta
    dropped = sp.Matrix.hstack(Iid.T + Idd * A, Idd * beta - f.extract(d, [0])).applyfunc(table.read)
    forces = Jd.T.LUsolve(dropped)
    return Reduced(tuple(speeds[k] for k in i), mass, rhs, dependent, (forces[:, :-1], forces[:, -1]))


def check_constraints(system: System) -> None:
    """UsageError when the constraints so far are not linear in the speeds or depend on each other."""
    choose_dependent(system, constraint_rows(system)[0])


def constraint_rows(system: System) -> tuple[sp.Matrix, sp.Matrix]:
    """J and c of J s + c = 0, one row a constraint. UsageError when an expression is not linear in the speeds."""
    rows, rest = [], []
    for number, constraint in enumerate(system.constraints, 1):
        try:
            row, c = split_linear(constraint.expression, system.speeds)
        except ValueError:
            raise UsageError(
                f"constraint {number}: {constraint.expression} = 0 is not linear in the speeds", "constraint"
            ) from None
        rows.append(row)
        rest.append([c])
    return sp.Matrix(rows), sp.Matrix(rest)


def choose_dependent(system: System, rows: sp.Matrix) -> list[int]:
    """Columns of the dependent speeds: the wanted ones, else the last that keep the rank. UsageError if dependent."""
    numbers = _random_numbers(rows)
    wanted = [_wanted(system, c) for c in system.constraints]
    chosen = [k for k in wanted if k is not None]
    for k in reversed(range(rows.cols)):
        if len(chosen) == rows.rows:
            break
        if k not in chosen and _rank(numbers[:, [*chosen, k]]) == len(chosen) + 1:
            chosen.append(k)
    rank = _rank(numbers[:, chosen])
    if rank < rows.rows:
        texts = "; ".join(f"{c.expression} = 0" for c in system.constraints)
        raise UsageError(f"{rows.rows} constraints have rank {rank}: they depend on each other ({texts})", "constraint")
    return sorted(chosen)


def _wanted(system: System, constraint: Constraint) -> int | None:
    if constraint.dependent is None:
        return None
    if constraint.dependent not in system.speeds:
        raise UsageError(f"{constraint.dependent} is not a speed and cannot be dependent", "constraint")
    return system.speeds.index(constraint.dependent)


def _random_numbers(rows: sp.Matrix) -> np.ndarray:
    """The matrix at a random point, rows scaled to length one."""
    chance = random.Random(7)
    plain = rows.applyfunc(transform)
    atoms = sorted(plain.free_symbols - {TIME} | plain.atoms(AppliedUndef), key=str)
    numbers = np.array(plain.xreplace({a: sp.Float(chance.uniform(0.2, 2.0)) for a in atoms}).evalf(), dtype=float)
    lengths = np.linalg.norm(numbers, axis=1, keepdims=True)
    return numbers / np.where(lengths > 0, lengths, 1.0)


def _rank(numbers: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(numbers, tol=1e-9)) if numbers.size else 0
