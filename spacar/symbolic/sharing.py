"""What assignments have in common: parts of parameters only are done once, equal parts are done once a step.

Parameter-only factors move to the `once` part, then `sympy.cse` runs on definitions and results together; no Z is
ever inlined. Source: `symbolic.md`, sections 4.2 and 5.
"""

from collections.abc import Callable, Iterable

import sympy as sp

from spacar.symbolic.collect import definition_order
from spacar.symbolic.ordered import Assignments


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
    definitions: dict[sp.Symbol, sp.Expr], results: list[sp.Expr], constants: set[sp.Symbol], names: NameSource
) -> tuple[Assignments, Assignments, list[sp.Expr]]:
    """Split into once and step, share common subexpressions in both; returns (once, step, results)."""
    once: dict[sp.Symbol, sp.Expr] = {}
    step: dict[sp.Symbol, sp.Expr] = {}
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
    definitions: dict[sp.Symbol, sp.Expr], results: list[sp.Expr], names: NameSource, keep: Iterable[sp.Symbol] = ()
) -> tuple[dict[sp.Symbol, sp.Expr], list[sp.Expr]]:
    shared, rewritten = sp.cse([*definitions.values(), *results], symbols=iter(names, None), order="none")
    everything = dict(shared)
    everything |= dict(zip(definitions, rewritten, strict=False))
    results = rewritten[len(definitions) :]
    alias: dict[sp.Symbol, sp.Expr] = {}
    kept = set(keep)
    for s in definition_order(everything, [*results, *kept]):
        everything[s] = everything[s].xreplace(alias)
        if s not in kept and (everything[s].is_Atom or (-everything[s]).is_Atom):
            alias[s] = everything[s]
    results = [e.xreplace(alias) for e in results]
    order = definition_order(everything, [*results, *sorted(kept, key=str)])
    return {s: e for s, e in order.items() if s not in alias}, list(results)


class Hoist:
    """Move every maximal part of an expression that depends on constants only into `once`."""

    def __init__(
        self, constants: set[sp.Symbol], once: dict[sp.Symbol, sp.Expr], names: Callable[[str], sp.Symbol]
    ) -> None:
        self.constants, self.once, self.names = constants, once, names
        self._known: dict[sp.Expr, sp.Symbol] = {}

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
