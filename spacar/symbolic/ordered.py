"""An ordered program as data: assignments done once per run, assignments done at every step, results.

Source: `symbolic.md`, section 5.
"""

import hashlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from spacar.errors import UsageError
from spacar.symbolic.collect import definition_order
from spacar.symbolic.unit_vectors import TIME, Definitions, Scalars

Symbols = tuple[sp.Symbol, ...]
Assignments = tuple[tuple[sp.Symbol, sp.Expr], ...]


@dataclass(frozen=True, eq=False)
class ConstraintRows:
    """The constraints of a system or of a program, one row each.

    `matrix` J (m, n) and `bias` γ (m) of J ṡ + γ = 0; `velocity` e (m) = J s + c; `position` {row: g}; `forces` λ (m);
    `names` (m); of a program `turning` ∂q̇/∂s (row by row), which turns displacements into coordinates.
    """

    names: tuple[str, ...]
    matrix: sp.Matrix
    bias: Scalars
    velocity: Scalars
    position: dict[int, sp.Expr]
    forces: Symbols
    turning: Scalars = ()

    @property
    def residual(self) -> list[sp.Expr]:
        """e and g."""
        return [*self.velocity, *self.position.values()]


UNCONSTRAINED = ConstraintRows((), sp.Matrix(0, 0, []), (), (), {}, ())


@dataclass(frozen=True, eq=False)
class OrderedProgram:
    """An evaluation order for I, f, q̇ and named outputs.

    `parameters` p, `coordinates` and `speeds` (the state is y = (q, s)), `inputs` {symbol: expression or None};
    `once` reads p; `step` reads p, once, y and inputs. `mass` holds the upper triangle row by row, `rhs` f, `rates`
    q̇, all short expressions in the assigned symbols. Outputs may read the `accelerations` ṡ and the forces of the
    `constraints`; `fields` are the states of beam fields, `quaternions` the places in the state of the coordinates of
    unit length. `seconds` is the time of the derivation.
    """

    title: str
    parameters: Symbols
    coordinates: Symbols
    speeds: Symbols
    inputs: dict[sp.Symbol, sp.Expr | None]
    once: Assignments
    step: Assignments
    mass: Scalars
    rhs: Scalars
    rates: Scalars
    outputs: dict[str, sp.Expr]
    accelerations: Symbols = ()
    constraints: ConstraintRows | None = None
    fields: Symbols = ()
    positive: tuple[tuple[str, sp.Symbol, bool], ...] = ()
    quaternions: tuple[tuple[int, ...], ...] = ()
    seconds: float = 0.0

    @property
    def n(self) -> int:
        """Number of speeds, the size of I."""
        return len(self.speeds)

    @property
    def m(self) -> int:
        """Number of constraints."""
        return len(self.constraints.names) if self.constraints else 0

    @property
    def unknowns(self) -> Symbols:
        """ṡ and λ, what a step solves for."""
        return self.accelerations + (self.constraints.forces if self.constraints else ())

    @property
    def inertia(self) -> sp.Matrix:
        return symmetric(self.mass, self.n)

    @property
    def system(self) -> list[sp.Expr]:
        """I (upper triangle), f, J and γ."""
        c = self.constraints
        return [*self.mass, *self.rhs, *((*c.matrix, *c.bias) if c else ())]

    @property
    def outputs_need_accelerations(self) -> bool:
        solved = set(self.unknowns)
        results = list(self.outputs.values())
        return any(e.free_symbols & solved for e in [*results, *(e for _, e in self.order(results))])

    @property
    def state(self) -> Symbols:
        return self.coordinates + self.speeds

    @property
    def names(self) -> dict[str, list[str]]:
        """Of parameters, state, inputs and outputs."""
        symbols = {"parameters": self.parameters, "state": self.state, "inputs": tuple(self.inputs)}
        return {what: [s.name for s in group] for what, group in symbols.items()} | {"outputs": list(self.outputs)}

    def counts(self) -> dict[str, int]:
        """Operations per step and once per run for I and f (SymPy `count_ops`), outputs not counted."""
        results = self.system
        groups = {"step": [*(e for _, e in self.order(results)), *results], "once": [e for _, e in self.once]}
        return {name: sum(int(sp.count_ops(e)) for e in group) for name, group in groups.items()}

    def order(self, results: Iterable[sp.Expr]) -> Assignments:
        """The step assignments that some results need, in order."""
        return tuple(definition_order(dict(self.step), results).items())

    @cached_property
    def digest(self) -> str:
        """A short fingerprint of the equations, written into generated files."""
        content = repr((self.parameters, self.state, self.inputs, self.once, self.step, self.system, self.rates))
        return hashlib.sha256(content.encode()).hexdigest()[:16]

    def evaluate(self, values: dict[str, Any], digits: int = 30) -> dict[str, Any]:
        """I, f, q̇ and outputs with many digits (SymPy numbers); `values` names parameters, states, inputs."""
        given = [s for s in (*self.parameters, *self.state, *self.inputs) if s.name in values]
        known: Definitions = {s: sp.Float(values[s.name], digits + 10) for s in given}

        def number(expression: sp.Expr) -> sp.Expr:
            return sp.N(expression.xreplace(known), digits + 10)

        for s, expression in [*self.inputs.items(), *self.once, *self.step]:
            if s not in known and expression is not None:
                known[s] = number(expression)
        I = symmetric(map(number, self.mass), self.n)
        f = sp.Matrix([number(e) for e in self.rhs])
        if self.outputs_need_accelerations:
            known |= self._solved(I, f, number)
        return {
            "mass": I, "rhs": f, "rates": [number(e) for e in self.rates],
            "outputs": {name: number(e) for name, e in self.outputs.items()},
        }  # fmt: skip

    def _solved(self, I: sp.Matrix, f: sp.Matrix, number: Callable[[sp.Expr], sp.Expr]) -> Definitions:
        """ṡ and λ in many digits."""
        if self.constraints is None:
            return dict(zip(self.accelerations, I.LUsolve(f), strict=True))
        J = self.constraints.matrix.applyfunc(number)
        g = sp.Matrix([number(e) for e in self.constraints.bias])
        both = sp.BlockMatrix([[I, -J.T], [J, sp.zeros(self.m)]]).as_explicit()
        return dict(zip(self.unknowns, both.LUsolve(f.col_join(-g)), strict=True))


def symmetric(upper: Iterable[sp.Expr], n: int) -> sp.Matrix:
    """The symmetric matrix of an upper triangle, row by row."""
    entries, found = iter(upper), sp.zeros(n, n)
    for i in range(n):
        for j in range(i, n):
            found[i, j] = found[j, i] = next(entries)
    return found


def plain_symbols(expressions: Iterable[Any]) -> dict[sp.Basic, sp.Symbol]:
    """Functions of time and symbols of any assumption to real symbols of the same name.

    UsageError when a function of time and a symbol have one name: a parameter named like a coordinate.
    """
    rule: dict[sp.Basic, sp.Symbol] = {}
    moving: dict[str, bool] = {}
    for e in expressions:
        for a in e.atoms(AppliedUndef, sp.Symbol):
            if a != TIME:
                name = a.name if isinstance(a, sp.Symbol) else str(a.func)
                if moving.setdefault(name, isinstance(a, AppliedUndef)) != isinstance(a, AppliedUndef):
                    raise UsageError(f"{name} is a function of time and also a parameter: rename one of them", "name")
                rule[a] = sp.Symbol(name, real=True)
    return rule
