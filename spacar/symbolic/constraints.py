"""Constraints in numbers of the speeds: J s + c = 0 and J ṡ + γ = 0, with positions g = 0 for closed loops.

An expression may contain pseudo-speeds s' (rates of a field at a section). They are no speeds of their own:
s' = Σ g_k(φ) dφ_k is put in before the expression is split and differentiated, so that the fields get their columns
in J and their part of γ. A constraint without speeds is a position constraint g(q, t) = 0; its derivative is the
velocity constraint.

Which speeds depend on the others is no part of the equations: the programs choose them by pivoting at every
evaluation (`emit/solvers.py`), I ṡ − Jᵀ λ = f with J ṡ = −γ; λ are the constraint forces.
Source: `symbolic.md`, section 3.5; the paper, feature 33.
"""

import random
from collections.abc import Callable

import numpy as np
import sympy as sp
from sympy.core.function import AppliedUndef

from spacar.errors import UsageError
from spacar.symbolic.collect import LinearSplit
from spacar.symbolic.description import Description
from spacar.symbolic.ordered import ConstraintRows
from spacar.symbolic.reference_frames import rate
from spacar.symbolic.transform import transform
from spacar.symbolic.unit_vectors import TIME, Rule


def constraint_rows(system: Description, read: Callable[[sp.Expr], sp.Expr] = transform) -> ConstraintRows:
    """All constraints; `read` makes a scalar without held products and pseudo-coordinates of an expression.

    Raises UsageError when an expression is not linear in the speeds.
    """
    at_rest = dict.fromkeys(system.accelerations.values(), sp.S.Zero)
    fields = {p.speed: p.rate(system.field_speeds) for p in system.pseudo}
    rows, bias, velocity, position = [], [], [], {}
    split = LinearSplit(system.speeds)
    for number, constraint in enumerate(system.constraints):
        e = constraint.velocity.xreplace(fields)
        try:
            row, _ = split(e)
        except ValueError:
            raise UsageError(
                f"{constraint.name}: {constraint.velocity} = 0 is not linear in the speeds", "constraint"
            ) from None
        derivative = rate(e).xreplace(system.rates).xreplace(at_rest).xreplace(fields)
        rows.append([read(row.get(s, sp.S.Zero)) for s in system.speeds])
        bias.append(read(derivative))
        velocity.append(read(e))
        if constraint.position is not None:
            position[number] = read(constraint.position)
    return ConstraintRows(
        tuple(c.name for c in system.constraints),
        sp.Matrix(len(rows), len(system.speeds), [c for row in rows for c in row]), tuple(bias), tuple(velocity),
        position, tuple(c.force for c in system.constraints),
    )  # fmt: skip


def check_constraints(system: Description) -> None:
    """UsageError when the constraints so far are not linear in the speeds, or depend on each other everywhere."""
    if not system.constraints:
        return
    values = system.pseudo_values()
    rows = constraint_rows(system, lambda e: transform(e).xreplace(values))
    numbers = _random_numbers(rows.matrix)
    rank = int(np.linalg.matrix_rank(numbers, tol=1e-9)) if numbers.size else 0
    if rank < len(rows.names):
        every = ((c.name, str(c.velocity if c.position is None else c.position)) for c in system.constraints)
        texts = "; ".join(f"{name}: {text if len(text) < 60 else text[:57] + '...'} = 0" for name, text in every)
        raise UsageError(
            f"{len(rows.names)} constraints have rank {rank}: they depend on each other ({texts})", "constraint"
        )


def _random_numbers(rows: sp.Matrix) -> np.ndarray:
    """The matrix at a random point, rows scaled to length one."""
    chance = random.Random(7)
    atoms = sorted(rows.free_symbols - {TIME} | rows.atoms(AppliedUndef), key=str)
    point: Rule = {a: sp.Float(chance.uniform(0.2, 2.0)) for a in atoms}
    numbers = np.array(rows.xreplace(point | {TIME: sp.Float(chance.uniform(0.2, 2.0))}).evalf(), dtype=float)
    lengths = np.linalg.norm(numbers, axis=1, keepdims=True)
    return numbers / np.where(lengths > 0, lengths, 1.0)
