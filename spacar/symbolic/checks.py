"""Checks of derived equations that need no second derivation: energy balance and a positive definite mass matrix.

The rate of the energy T + V along the motion, found by the chain rule through all definitions, must equal the power
of the loads and dampers.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy as sp

from spacar.symbolic.energy import power
from spacar.symbolic.jacobian import gradients

if TYPE_CHECKING:
    from spacar.symbolic.equations import Equations


@dataclass(frozen=True)
class Check:
    """`energy_error`: |d(T + V)/dt − power| over the largest of the parts; `positive`: the mass matrix is definite."""

    energy_error: float
    positive: bool


def check(eq: Equations, digits: int = 30, seed: int = 1) -> Check:
    """Evaluate at a random state and random positive parameters with `digits` digits.

    UsageError from `energy` when the system has no energy (prescribed motion, points without position).
    """
    kinetic, potential = eq.energy()
    program = eq.program({"T": kinetic, "V": potential, "power": power(eq)})
    chance = random.Random(seed)
    values = {s.name: chance.uniform(0.4, 1.2) for s in [*program.parameters, *program.state, *program.inputs]}
    numbers = program.evaluate(values, digits)
    I, f = numbers["mass"], numbers["rhs"]
    rates = [*numbers["rates"], *I.LUsolve(f)]
    slopes = gradients(program, [program.outputs["T"], program.outputs["V"]])
    known = {s: sp.Float(values[s.name], digits + 10) for s in [*program.parameters, *program.state, *program.inputs]}
    for s, e in [*program.once, *slopes.step]:
        known[s] = sp.N(e.xreplace(known), digits + 10)
    parts = [sp.N(e.xreplace(known), digits) * r for row in slopes.rows for e, r in zip(row, rates, strict=True)]
    total = sp.Add(*parts) - numbers["outputs"]["power"]
    positive = all(I[:k, :k].det() > 0 for k in range(1, I.rows + 1))
    return Check(float(abs(total) / max(abs(p) for p in parts)), positive)
