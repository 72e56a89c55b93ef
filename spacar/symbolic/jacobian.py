"""The exact Jacobian of a program by the forward chain rule through its ordered definitions.

With g(y, a) = f(y, u(y)) − I(y) a and a held constant: ∂a/∂y = I⁻¹ ∂g/∂y. Z variables stay reads; inputs that are
expressions of the state are differentiated too (feedback). Source: `symbolic.md`, section 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from spacar.symbolic.program import Assignments, NameSource, Program, share


@dataclass(frozen=True, eq=False)
class Jacobian:
    """∂g/∂y and ∂q̇/∂y: `step` holds the values and derivatives in order, `accelerations` the symbols a.

    `dg` has shape (n, len(y)), `drates` (len(q), len(y)); entries are short expressions in the symbols of `step`.
    `once` replaces the once part of the program.
    """

    accelerations: tuple[sp.Symbol, ...]
    once: Assignments
    step: Assignments
    dg: sp.ImmutableMatrix
    drates: sp.ImmutableMatrix

    def count_ops(self) -> int:
        """Operations per evaluation, I and f included."""
        return sum(int(sp.count_ops(e)) for e in [*(e for _, e in self.step), *self.dg, *self.drates])


def make_jacobian(program: Program) -> Jacobian:
    """Differentiate the program with respect to its state."""
    state = program.state
    constants = {*program.parameters, *(s for s, _ in program.once)}
    names = NameSource([*constants, *state, *program.inputs, *(s for s, _ in program.step)])
    definitions: dict[sp.Symbol, sp.Expr] = dict(program.step)
    known: dict[sp.Symbol, dict[sp.Symbol, sp.Expr]] = {y: {y: sp.S.One} for y in state}

    def gradient(expression: sp.Expr) -> dict[sp.Symbol, sp.Expr]:
        result: dict[sp.Symbol, list[sp.Expr]] = {}
        for atom in sorted(expression.free_symbols & known.keys(), key=lambda s: s.name):
            slope = expression.diff(atom)
            for y, d in known[atom].items():
                result.setdefault(y, []).append(slope * d)
        return {y: sp.Add(*parts) for y, parts in result.items()}

    for symbol, expression in [*program.inputs.items(), *program.step]:
        if expression is None:
            continue
        slopes: dict[sp.Symbol, sp.Expr] = {}
        for y, d in gradient(expression).items():
            if d.is_Atom or (-d).is_Atom:
                slopes[y] = d
            elif d != 0:
                slopes[y] = names("d")
                definitions[slopes[y]] = d
        if slopes:
            known[symbol] = slopes
    accelerations = tuple(names("a") for _ in program.speeds)
    n = program.n
    upper = iter(program.mass)
    I = sp.zeros(n, n)
    for i in range(n):
        for j in range(i, n):
            I[i, j] = I[j, i] = next(upper)
    rows = [gradient(program.rhs[i] - sum(I[i, j] * accelerations[j] for j in range(n))) for i in range(n)]
    rows += [gradient(e) for e in program.rates]
    flat = [row.get(y, sp.S.Zero) for row in rows for y in state]
    once, step, flat = share(definitions, flat, constants, names)
    everything = sp.Matrix(len(rows), len(state), flat)
    return Jacobian(
        accelerations,
        (*program.once, *once),
        step,
        sp.ImmutableMatrix(everything[:n, :]),
        sp.ImmutableMatrix(everything[n:, :]),
    )
