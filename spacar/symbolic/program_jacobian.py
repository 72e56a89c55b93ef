"""The exact Jacobian of a program by the forward chain rule through its ordered definitions.

With g(y, a) = f(y, u(y)) − I(y) a and a held constant: ∂a/∂y = I⁻¹ ∂g/∂y. With constraints g = f − I a + Jᵀ λ and
h = J a + γ, a and λ constant: I ∂a − Jᵀ ∂λ = ∂g, J ∂a = −∂h. Z variables stay reads; inputs that are
expressions of the state are differentiated too (feedback). Source: `symbolic.md`, section 5.
"""

from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

from spacar.symbolic.ordered import Assignments, OrderedProgram
from spacar.symbolic.sharing import NameSource, share


@dataclass(frozen=True, eq=False)
class Jacobian:
    """∂g/∂y and ∂q̇/∂y: `step` holds the values and derivatives in order, `accelerations` the symbols a.

    `dg` has shape (n, len(y)), `drates` (len(q), len(y)), `dh` (m, len(y)) of the constraints; entries are
    short expressions in the symbols of `step`. `once` replaces the once part of the program.
    """

    accelerations: tuple[sp.Symbol, ...]
    once: Assignments
    step: Assignments
    dg: sp.ImmutableMatrix
    drates: sp.ImmutableMatrix
    dh: sp.ImmutableMatrix

    def count_ops(self) -> int:
        """Operations per evaluation, I and f included."""
        return sum(int(sp.count_ops(e)) for e in [*(e for _, e in self.step), *self.dg, *self.drates, *self.dh])


def gradients(
    program: OrderedProgram, expressions: list[sp.Expr], constant: tuple[sp.Symbol, ...]
) -> tuple[dict[sp.Symbol, sp.Expr], list[sp.Expr]]:
    """Derivatives of expressions with respect to the state, row by row, and the step that they read: that of the
    program with the derivatives in it, by the forward chain rule through inputs and step.

    `constant` are symbols in the expressions that do not depend on the state.
    """
    known: dict[sp.Symbol, dict[sp.Symbol, sp.Expr]] = {y: {y: sp.S.One} for y in program.state}
    names = _names(program, constant)
    definitions: dict[sp.Symbol, sp.Expr] = {}

    def gradient(expression: sp.Expr) -> dict[sp.Symbol, sp.Expr]:
        result: dict[sp.Symbol, list[sp.Expr]] = {}
        for atom in sorted(expression.free_symbols & known.keys(), key=lambda s: s.name):
            slope = _plain(expression.diff(atom))
            for y, d in known[atom].items():
                result.setdefault(y, []).append(slope * d)
        return {y: sp.Add(*parts) for y, parts in result.items()}

    fed = [(s, e, True) for s, e in program.inputs.items() if e is not None]
    for symbol, expression, is_input in [*fed, *((s, e, False) for s, e in program.step)]:
        if not is_input:
            definitions[symbol] = expression
        slopes: dict[sp.Symbol, sp.Expr] = {}
        for y, d in gradient(expression).items():
            if d.is_Atom or (-d).is_Atom:
                slopes[y] = d
            elif d != 0:
                slopes[y] = names("d")
                definitions[slopes[y]] = d
        if slopes:
            known[symbol] = {y: d for y, d in slopes.items() if d != 0}
    rows = [gradient(e) for e in expressions]
    return definitions, [row.get(y, sp.S.Zero) for row in rows for y in program.state]


def _plain(slope: sp.Expr) -> sp.Expr:
    """Derivatives of sign, Abs, Min and Max in functions that programs have; jumps have the slope 0."""
    slope = slope.replace(sp.DiracDelta, lambda *_: sp.S.Zero)
    return slope.replace(sp.Heaviside, lambda x, *_: (1 + sp.sign(x)) / 2)


def _names(program: OrderedProgram, constant: tuple[sp.Symbol, ...]) -> NameSource:
    assigned = [s for s, _ in [*program.once, *program.step]]
    return NameSource([*program.parameters, *program.state, *program.inputs, *assigned, *constant])


@lru_cache(maxsize=16)
def jacobian_of(program: OrderedProgram) -> Jacobian:
    """Differentiate g = f − I a and q̇ with respect to the state, then share common subexpressions; once a program."""
    accelerations = program.accelerations
    n, I = program.n, program.inertia
    g = [program.rhs[i] - sum(I[i, j] * accelerations[j] for j in range(n)) for i in range(n)]
    h: list[sp.Expr] = []
    if c := program.constraints:
        J = sp.Matrix(program.m, n, c.matrix)
        g = [e + sum(J[k, i] * force for k, force in enumerate(c.forces)) for i, e in enumerate(g)]
        h = [c.bias[k] + sum(J[k, i] * accelerations[i] for i in range(n)) for k in range(program.m)]
    definitions, flat = gradients(program, [*g, *program.rates, *h], program.unknowns)
    constants = {*program.parameters, *(s for s, _ in program.once)}
    taken = _names(program, (*program.unknowns, *definitions))
    once, step, flat = share(definitions, flat, constants, taken)
    everything = sp.Matrix(n + len(program.rates) + len(h), len(program.state), flat)
    return Jacobian(
        accelerations,
        (*program.once, *once),
        step,
        sp.ImmutableMatrix(everything[:n, :]),
        sp.ImmutableMatrix(everything[n : n + len(program.rates), :]),
        sp.ImmutableMatrix(everything[n + len(program.rates) :, :]),
    )
