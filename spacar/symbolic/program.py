"""From equations to an ordered program: assignments done once per run, assignments done at every step, results.

Parameter-only factors move to the `once` part, then `sympy.cse` runs on definitions and results together; no Z is
ever inlined. Source: `symbolic.md`, sections 4.2 and 5.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import sympy as sp
from sympy.core.function import AppliedUndef

from spacar.errors import UsageError
from spacar.symbolic.collect import definition_order
from spacar.symbolic.transform import DirectionCosines
from spacar.symbolic.units import TIME

if TYPE_CHECKING:
    from spacar.symbolic.constraints import ConstraintRows
    from spacar.symbolic.equations import Equations

Assignments = tuple[tuple[sp.Symbol, sp.Expr], ...]


@dataclass(frozen=True, eq=False)
class Constrained:
    """The constraints of a program, m rows: `matrix` J (m·n, row by row), `bias` γ, `velocity` e, `forces` λ (m each).

    `position` g of the rows `closed`; `turning` ∂q̇/∂s (row by row), which turns displacements into coordinates.
    """

    names: tuple[str, ...]
    matrix: tuple[sp.Expr, ...]
    bias: tuple[sp.Expr, ...]
    velocity: tuple[sp.Expr, ...]
    forces: tuple[sp.Symbol, ...]
    position: tuple[sp.Expr, ...]
    closed: tuple[int, ...]
    turning: tuple[sp.Expr, ...]

    @property
    def equations(self) -> list[sp.Expr]:
        """J and γ."""
        return [*self.matrix, *self.bias]

    @property
    def residual(self) -> list[sp.Expr]:
        """e and g."""
        return [*self.velocity, *self.position]


@dataclass(frozen=True, eq=False)
class Program:
    """An evaluation order for I, f, q̇ and named outputs.

    `parameters` p, `coordinates` and `speeds` (the state is y = (q, s)), `inputs` {symbol: expression or None};
    `once` reads p; `step` reads p, once, y and inputs. `mass` holds the upper triangle row by row, `rhs` f, `rates`
    q̇, all short expressions in the assigned symbols. Outputs may read the `accelerations` ṡ and the forces of the
    `constraints`; `fields` are the states of beam fields. `seconds` is the time of the derivation.
    """

    title: str
    parameters: tuple[sp.Symbol, ...]
    coordinates: tuple[sp.Symbol, ...]
    speeds: tuple[sp.Symbol, ...]
    inputs: dict[sp.Symbol, sp.Expr | None]
    once: Assignments
    step: Assignments
    mass: tuple[sp.Expr, ...]
    rhs: tuple[sp.Expr, ...]
    rates: tuple[sp.Expr, ...]
    outputs: dict[str, sp.Expr]
    accelerations: tuple[sp.Symbol, ...] = ()
    constraints: Constrained | None = None
    fields: tuple[sp.Symbol, ...] = ()
    positive: tuple[tuple[str, sp.Symbol, bool], ...] = ()
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
    def unknowns(self) -> tuple[sp.Symbol, ...]:
        """ṡ and λ, what a step solves for."""
        return self.accelerations + (self.constraints.forces if self.constraints else ())

    @property
    def system(self) -> list[sp.Expr]:
        """I (upper triangle), f, J and γ."""
        return [*self.mass, *self.rhs, *(self.constraints.equations if self.constraints else [])]

    @property
    def outputs_need_accelerations(self) -> bool:
        solved = set(self.unknowns)
        results = list(self.outputs.values())
        return any(e.free_symbols & solved for e in [*results, *(e for _, e in self.order(results))])

    @property
    def state(self) -> tuple[sp.Symbol, ...]:
        return self.coordinates + self.speeds

    def counts(self) -> dict[str, int]:
        """Operations per step and once per run for I and f (SymPy `count_ops`), outputs not counted."""
        results = self.system
        return {
            "step": sum(_ops(e) for _, e in self.order(results)) + sum(_ops(e) for e in results),
            "once": sum(_ops(e) for _, e in self.once),
        }

    def order(self, results: Iterable[sp.Expr]) -> Assignments:
        """The step assignments that some results need, in order."""
        definitions = dict(self.step)
        return tuple((s, definitions[s]) for s in definition_order(definitions, results))

    @cached_property
    def digest(self) -> str:
        """A short fingerprint of the equations, written into generated files."""
        content = repr((self.parameters, self.state, self.inputs, self.once, self.step, self.system, self.rates))
        return hashlib.sha256(content.encode()).hexdigest()[:16]

    @cached_property
    def jacobian(self) -> Any:
        """The program of ∂g/∂y, see `jacobian.py`."""
        from spacar.symbolic.jacobian import make_jacobian

        return make_jacobian(self)

    def evaluate(self, values: dict[str, Any], digits: int = 30) -> dict[str, Any]:
        """I, f, q̇ and outputs with many digits (SymPy numbers); `values` names parameters, states, inputs."""
        known: dict[sp.Symbol, sp.Expr] = {}
        for s in [*self.parameters, *self.state, *self.inputs]:
            if s.name in values:
                known[s] = sp.Float(values[s.name], digits + 10)
        for s, expression in self.inputs.items():
            if s not in known and expression is not None:
                known[s] = sp.N(expression.xreplace(known), digits + 10)

        def number(expression: sp.Expr) -> sp.Expr:
            return sp.N(expression.xreplace(known), digits + 10)

        for s, expression in [*self.once, *self.step]:
            known[s] = number(expression)
        upper = iter(number(e) for e in self.mass)
        I = sp.zeros(self.n, self.n)
        for i in range(self.n):
            for j in range(i, self.n):
                I[i, j] = I[j, i] = next(upper)
        f = sp.Matrix([number(e) for e in self.rhs])
        if self.outputs_need_accelerations:
            known |= self._solved(I, f, number)
        return {
            "mass": I, "rhs": f, "rates": [number(e) for e in self.rates],
            "outputs": {name: number(e) for name, e in self.outputs.items()},
        }  # fmt: skip

    def _solved(self, I: sp.Matrix, f: sp.Matrix, number: Callable[[sp.Expr], sp.Expr]) -> dict[sp.Symbol, sp.Expr]:
        """ṡ and λ in many digits."""
        if self.constraints is None:
            return dict(zip(self.accelerations, I.LUsolve(f), strict=True))
        J = sp.Matrix(self.m, self.n, [number(e) for e in self.constraints.matrix])
        g = sp.Matrix([number(e) for e in self.constraints.bias])
        both = sp.BlockMatrix([[I, -J.T], [J, sp.zeros(self.m)]]).as_explicit()
        return dict(zip(self.unknowns, both.LUsolve(f.col_join(-g)), strict=True))

    def function(self, values: dict[str, float], jacobian: bool = True) -> Any:
        """f(t, y) -> ẏ and f.jac(t, y) in Python for parameter values; see `run.py`."""
        from spacar.symbolic.run import make_function

        return make_function(self, values, jacobian)

    def simulate(self, values: dict[str, float], start: dict[str, float], **options: Any) -> Any:
        """Integrate the motion; see `run.simulate`."""
        from spacar.symbolic.run import simulate

        return simulate(self, values, start, **options)

    def text(self, language: str, jacobian: bool = False) -> str:
        """Source text in python, c, fortran or latex."""
        from spacar.symbolic.emit import emit

        return emit(self, language, jacobian)

    def write(self, path: Any, language: str, jacobian: bool = False) -> None:
        """Write the source text to a file."""
        from pathlib import Path

        Path(path).write_text(self.text(language, jacobian), encoding="utf-8")


def _ops(expression: sp.Expr) -> int:
    return int(sp.count_ops(expression))


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


def make_program(eq: Equations, outputs: dict[str, Any]) -> Program:
    """Order, share and split the assignments of `eq`; see the module."""
    values = {name: eq.scalar(v) for name, v in outputs.items()}
    n, c = len(eq.speeds), eq.constraints
    results = {
        "mass": [eq.mass_matrix[i, j] for i in range(n) for j in range(i, n)],
        "rhs": list(eq.rhs),
        "rates": list(eq.kinematics.values()),
        "matrix": list(c.matrix) if c else [],
        "bias": list(c.bias) if c else [],
        "velocity": list(c.velocity) if c else [],
        "position": list(c.position.values()) if c else [],
        "turning": [rate.diff(s) for rate in eq.kinematics.values() for s in eq.speeds] if c else [],
        "outputs": list(values.values()),
    }
    flat = [e for group in results.values() for e in group]
    order = definition_order(eq.table.definitions, flat)
    definitions = {z: eq.table.definitions[z] for z in order}
    plain = DirectionCosines()
    feeds = {s: None if e is None else eq.scalar(e, plain) for s, e in eq.system.inputs.items()}
    accelerations = [eq.system.accelerations.get(s, sp.Symbol(f"{s.func}_dot", real=True)) for s in eq.speeds]
    solved = [*accelerations, *(c.forces if c else ())]
    _check_laws(feeds, {*eq.system.accelerations.values(), *(c.forces if c else ())})
    known = [*eq.coordinates, *eq.speeds, *solved, *feeds]
    rule = plain_symbols(
        [*definitions, *definitions.values(), *flat, *(e for e in feeds.values() if e is not None), *known]
    )
    states = [rule[s] for s in [*eq.coordinates, *eq.speeds]]
    inputs = {sp.Symbol(s.name, real=True): e.xreplace(rule) if e is not None else None for s, e in feeds.items()}
    if any(TIME in e.free_symbols for e in _timeless([*definitions.values(), *flat], rule)):
        # prescribed motion: time enters I and f as an input, so that accel(p, y, u) stays complete
        clock = sp.Symbol("time", real=True)
        if clock in (*states, *inputs):
            raise UsageError("the name 'time' is needed for prescribed motion: rename the coordinate, speed or input")
        rule[TIME], inputs[clock] = clock, TIME
    definitions = {rule[z]: e.xreplace(rule) for z, e in definitions.items()}
    flat = [e.xreplace(rule) for e in flat]
    laws = [e for e in inputs.values() if e is not None]
    used = set().union(*(e.free_symbols for e in [*definitions.values(), *flat, *laws]))
    unknowns = [rule[s] for s in solved]
    fixed = used - set(states) - set(inputs) - set(definitions) - set(unknowns) - {TIME}
    parameters = sorted(fixed, key=lambda s: s.name)
    names = NameSource([*parameters, *states, *inputs, *definitions, *unknowns])
    once, step, flat = share(definitions, flat, set(parameters), names)
    groups: dict[str, list[sp.Expr]] = {}
    start = 0
    for key, group in results.items():
        groups[key] = flat[start : start + len(group)]
        start += len(group)
    return Program(
        title=eq.system.title,
        parameters=tuple(parameters),
        coordinates=tuple(states[: len(eq.coordinates)]),
        speeds=tuple(states[len(eq.coordinates) :]),
        inputs=inputs,
        once=once,
        step=step,
        mass=tuple(groups["mass"]),
        rhs=tuple(groups["rhs"]),
        rates=tuple(groups["rates"]),
        outputs=dict(zip(values, groups["outputs"], strict=True)),
        accelerations=tuple(unknowns[:n]),
        constraints=_constrained(c, groups, tuple(unknowns[n:])) if c else None,
        fields=tuple(rule[s] for beam in eq.system.beams for s in (*beam.coordinates, *beam.speeds)),
        positive=_signs(eq, parameters),
        seconds=eq.seconds,
    )


def _constrained(rows: ConstraintRows, groups: dict[str, list[sp.Expr]], forces: tuple[sp.Symbol, ...]) -> Constrained:
    matrix, bias, velocity, position, turning = (
        tuple(groups[k]) for k in ("matrix", "bias", "velocity", "position", "turning")
    )
    return Constrained(rows.names, matrix, bias, velocity, forces, position, tuple(rows.position), turning)


def _check_laws(feeds: dict[sp.Symbol, sp.Expr | None], forbidden: set[sp.Symbol]) -> None:
    for name, law in feeds.items():
        found = sorted(str(s) for s in law.free_symbols & forbidden) if law is not None else []
        if found:
            raise UsageError(f"the law of input {name} reads {found[0]}, which is only known after it", "input")


def _timeless(expressions: Iterable[sp.Expr], rule: dict[sp.Basic, sp.Symbol]) -> Iterable[sp.Expr]:
    """The expressions with functions of time as symbols: what still contains t depends on it explicitly."""
    return (e.xreplace(rule) for e in expressions)


def _signs(eq: Equations, parameters: list[sp.Symbol]) -> tuple[tuple[str, sp.Symbol, bool], ...]:
    """Parameters that must be positive (lengths, True) or not negative (masses, stiffnesses, False)."""
    rows: dict[sp.Symbol, tuple[str, bool]] = {}
    system = eq.system
    for beam in system.beams:
        rows |= {beam.mass: ("mass per length", False), **{f.stiffness: ("stiffness", False) for f in beam.fields}}
        rows[beam.length] = ("length", True)
    rows |= {body.mass: ("mass", False) for body in system.bodies}
    return tuple((what, s, strict) for s, (what, strict) in rows.items() if s in parameters)


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
    return {s: everything[s] for s in order if s not in alias}, list(results)


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
