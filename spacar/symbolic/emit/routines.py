"""What C and Fortran have in common: the routines of a program with their arguments, reads, body and results."""

from dataclasses import dataclass

import sympy as sp

from spacar.symbolic.collect import definition_order
from spacar.symbolic.ordered import Assignments, OrderedProgram
from spacar.symbolic.program_jacobian import jacobian_of
from spacar.symbolic.unit_vectors import TIME

Results = tuple[tuple[str, int, sp.Expr], ...]


@dataclass(frozen=True)
class Routine:
    """A routine: `reads` (array, index, symbol) come first, then `body`, then `results` (array, index, expression).

    `changed` are the arguments that are written; `known` all symbols, in the order in which names are given;
    `internal` routines are not seen from outside.
    """

    name: str
    arguments: tuple[str, ...]
    changed: tuple[str, ...]
    reads: tuple[tuple[str, int, sp.Symbol], ...]
    body: Assignments
    results: Results
    internal: bool = False

    @property
    def known(self) -> list[sp.Symbol]:
        return [*(s for _, _, s in self.reads), *(s for s, _ in self.body)]

    @property
    def unused(self) -> list[str]:
        """Arguments that this model does not need: the interface is the same for all models."""
        read, written = ({a for a, _, _ in rows} for rows in (self.reads, self.results))
        timed = any(TIME in e.free_symbols for e in [*(e for _, e in self.body), *(e for _, _, e in self.results)])
        found = [a for a in self.arguments if a not in self.changed and a != "t" and a not in read]
        found += ["t"] if "t" in self.arguments and not timed else []
        return found + [a for a in self.changed if a not in written]


def compiled_routines(program: OrderedProgram, jacobian: bool = False) -> tuple[Assignments, list[Routine]]:
    """The once assignments, and the routines once, step, feed, rates, outputs, manifold and (on request) slopes.

    With constraints the step also gives J and h = γ, and `manifold` the residuals e, g and ∂q̇/∂s. `a` holds ṡ and λ.
    """
    once = jacobian_of(program).once if jacobian else program.once
    places = _places(program, once)
    ny = len(program.state)
    system: Results = tuple(("M", i, e) for i, e in enumerate(program.inertia))
    system += tuple(("f", i, e) for i, e in enumerate(program.rhs))
    c = program.constraints
    filled: tuple[str, ...] = ("M", "f")
    if c is not None:
        system += tuple(("J", i, e) for i, e in enumerate(c.matrix)) + tuple(("h", i, e) for i, e in enumerate(c.bias))
        filled += ("J", "h")
    feed = tuple(("u", i, e) for i, e in enumerate(program.inputs.values()) if e is not None)
    rates = tuple(("ydot", i, e) for i, e in enumerate(program.rates))
    given = ("c", "p", "y", "u")

    def routine(
        name: str, arguments: tuple[str, ...], changed: str | tuple[str, ...], body: Assignments, results: Results
    ) -> Routine:
        changed = (changed,) if isinstance(changed, str) else changed
        used = [*(e for _, e in body), *(e for _, _, e in results)]
        needed = set().union(*(e.free_symbols for e in used)) - {s for s, _ in body}
        reads = [(a, i, s) for s, (a, i) in places.items() if s in needed and a in arguments]
        return Routine(name, arguments, changed, tuple(reads), body, results, internal=name == "slopes")

    stored = tuple(("c", i, s) for i, (s, _) in enumerate(once))
    routines = [
        routine("once", ("p", "c"), "c", once, stored),
        routine("step", (*given, *filled), filled, program.order(e for _, _, e in system), system),
        routine("feed", ("t", *given), "u", (), feed),
        routine("rates", (*given, "ydot"), "ydot", program.order(program.rates), rates),
        routine(
            "outputs", (*given, *(("a",) if program.outputs_need_accelerations else ()), "out"), "out",
            program.order(program.outputs.values()),
            tuple(("out", i, e) for i, e in enumerate(program.outputs.values())),
        ),
    ]  # fmt: skip
    if c is not None:
        results = tuple(("res", i, e) for i, e in enumerate(c.residual))
        results += tuple(("turn", i, e) for i, e in enumerate(c.turning))
        body = program.order(e for _, _, e in results)
        routines.append(routine("manifold", (*given, "res", "turn"), ("res", "turn"), body, results))
    if jacobian:
        J = jacobian_of(program)
        entries = [*J.drates, *J.dg, *J.dh]
        results = tuple(("J", k, e) for k, e in enumerate(entries))
        assert len(entries) == (ny + program.m) * ny
        body = tuple(definition_order(dict(J.step), entries).items())
        routines.append(routine("slopes", ("t", *given, "a", "J"), "J", body, results))
    return once, routines


def _places(program: OrderedProgram, once: Assignments) -> dict[sp.Symbol, tuple[str, int]]:
    places = {s: ("p", i) for i, s in enumerate(program.parameters)}
    places |= {s: ("a", i) for i, s in enumerate(program.unknowns)}
    places |= {s: ("c", i) for i, (s, _) in enumerate(once)}
    places |= {s: ("y", i) for i, s in enumerate(program.state)}
    return places | {s: ("u", i) for i, s in enumerate(program.inputs)}
