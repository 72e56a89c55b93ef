"""The exact Jacobian of a program by the forward chain rule through its ordered definitions.

With g(y, a) = f(y, u(y)) − I(y) a and a held constant: ∂a/∂y = I⁻¹ ∂g/∂y. With constraints g = f − I a + Jᵀ λ and
h = J a + γ, a and λ constant: I ∂a − Jᵀ ∂λ = ∂g, J ∂a = −∂h. Z variables stay reads; inputs that are
expressions of the state are differentiated too (feedback).

Parts of parameters only move to the `once` part, then `sympy.cse` runs on definitions and results together, so that
equal parts are done once a step; no Z is ever inlined. Source: `symbolic.md`, sections 4.2 and 5.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import lru_cache

import sympy as sp

from spacar.symbolic.collect import definition_order
from spacar.symbolic.ordered import Assignments, OrderedProgram, Symbols
from spacar.symbolic.unit_vectors import Definitions


@dataclass(frozen=True, eq=False)
class Jacobian:
    """∂g/∂y and ∂q̇/∂y: `step` holds the values and derivatives in order.

    `dg` has shape (n, len(y)), `drates` (len(q), len(y)), `dh` (m, len(y)) of the constraints; entries are
    short expressions in the symbols of `step`. `once` replaces the once part of the program.
    """

    once: Assignments
    step: Assignments
    dg: sp.ImmutableMatrix
    drates: sp.ImmutableMatrix
    dh: sp.ImmutableMatrix


class NameSource:
    """New names that differ from all known ones in more than case: w1, w2, …"""

    def __init__(self, symbols: Iterable[sp.Symbol]) -> None:
        self.taken = {s.name.lower() for s in symbols}
        self.number: dict[str, int] = {}

    def __call__(self, prefix: str = "w") -> sp.Symbol:
        while True:
            self.number[prefix] = self.number.get(prefix, 0) + 1
            name = f"{prefix}{self.number[prefix]}"
            if name.lower() not in self.taken:
                self.taken.add(name.lower())
                return sp.Symbol(name, real=True)


def share(
    definitions: Definitions, results: list[sp.Expr], constants: set[sp.Symbol], names: NameSource
) -> tuple[Assignments, Assignments, list[sp.Expr]]:
    """Split into once and step, share common subexpressions in both; returns (once, step, results)."""
    once: Definitions = {}
    step: Definitions = {}
    hoist = Hoist(set(constants), once, names)
    for symbol, expression in definitions.items():
        if expression.free_symbols <= hoist.constants:
            once[symbol] = expression
            hoist.constants.add(symbol)
        else:
            step[symbol] = hoist(expression)
    results = [hoist(e) for e in results]
    step, results = _common(step, results, names)
    needed = (
        set().union(*(e.free_symbols for e in [*step.values(), *results])) & once.keys() if step or results else set()
    )
    once, _ = _common(once, [], names, keep=needed)
    return tuple(once.items()), tuple(step.items()), results


def _common(
    definitions: Definitions, results: list[sp.Expr], names: NameSource, keep: Iterable[sp.Symbol] = ()
) -> tuple[Definitions, list[sp.Expr]]:
    shared, rewritten = sp.cse([*definitions.values(), *results], symbols=iter(names, None), order="none")
    everything = dict(shared)
    everything |= dict(zip(definitions, rewritten, strict=False))
    results = rewritten[len(definitions) :]
    alias: Definitions = {}
    kept = set(keep)
    for s in definition_order(everything, [*results, *kept]):
        everything[s] = everything[s].xreplace(alias)
        if s not in kept and (everything[s].is_Atom or (-everything[s]).is_Atom):
            alias[s] = everything[s]
    results = [e.xreplace(alias) for e in results]
    order = definition_order(everything, [*results, *sorted(kept, key=str)])
    return {s: e for s, e in order.items() if s not in alias}, list(results)


@dataclass
class Hoist:
    """Move every maximal part of an expression that depends on constants only into `once`."""

    constants: set[sp.Symbol]
    once: Definitions
    names: Callable[[str], sp.Symbol]
    _known: dict[sp.Expr, sp.Symbol] = field(default_factory=dict)

    def __call__(self, expression: sp.Expr) -> sp.Expr:
        if not isinstance(expression, sp.Expr):  # a condition of a Piecewise
            return expression
        if not expression.args or not expression.free_symbols & self.constants:
            return expression
        if expression.free_symbols <= self.constants:
            return self._constant(expression)
        if isinstance(expression, (sp.Mul, sp.Add)):
            is_sum = isinstance(expression, sp.Add)
            fixed = [a for a in expression.args if a.free_symbols <= self.constants and not (a.is_number and is_sum)]
            moving = [self(a) for a in expression.args if a not in fixed]
            if any(not a.is_number for a in fixed):
                return expression.func(self._constant(expression.func(*fixed)), *moving)
            return expression.func(*fixed, *moving)
        return expression.func(*map(self, expression.args))

    def _constant(self, expression: sp.Expr) -> sp.Expr:
        """A number, a constant, or plus or minus a constant made for the expression."""
        if expression.is_Atom or (-expression).is_Atom:
            return expression
        if -expression in self._known:
            return -self._known[-expression]
        if expression not in self._known:
            symbol = self.names("c")
            self._known[expression] = symbol
            self.once[symbol] = expression
            self.constants.add(symbol)
        return self._known[expression]


def gradients(
    program: OrderedProgram, expressions: list[sp.Expr], constant: Symbols
) -> tuple[Definitions, list[sp.Expr]]:
    """Derivatives of expressions with respect to the state, row by row, and the step that they read: that of the
    program with the derivatives in it, by the forward chain rule through inputs and step.

    `constant` are symbols in the expressions that do not depend on the state.
    """
    known: dict[sp.Symbol, Definitions] = {y: {y: sp.S.One} for y in program.state}
    names = _names(program, constant)
    definitions: Definitions = {}

    def gradient(expression: sp.Expr) -> Definitions:
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
        slopes: Definitions = {}
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


def _names(program: OrderedProgram, constant: Symbols) -> NameSource:
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
        g = [e + sum(c.matrix[k, i] * force for k, force in enumerate(c.forces)) for i, e in enumerate(g)]
        h = [c.bias[k] + sum(c.matrix[k, i] * accelerations[i] for i in range(n)) for k in range(program.m)]
    definitions, flat = gradients(program, [*g, *program.rates, *h], program.unknowns)
    constants = {*program.parameters, *(s for s, _ in program.once)}
    taken = _names(program, (*program.unknowns, *definitions))
    once, step, flat = share(definitions, flat, constants, taken)
    nq = len(program.rates)
    slopes = sp.ImmutableMatrix(n + nq + len(h), len(program.state), flat)
    return Jacobian((*program.once, *once), step, slopes[:n, :], slopes[n : n + nq, :], slopes[n + nq :, :])
