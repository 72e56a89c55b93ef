"""What C and Fortran have in common: the routines of a program with their arguments, reads, body and results."""

from collections.abc import Iterable
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
    system = _into("M", program.inertia) + _into("f", program.rhs)
    c = program.constraints
    filled: tuple[str, ...] = ("M", "f")
    if c is not None:
        system += _into("J", c.matrix) + _into("h", c.bias)
        filled += ("J", "h")
    feed = tuple(("u", i, e) for i, e in enumerate(program.inputs.values()) if e is not None)
    given = ("c", "p", "y", "u")
    solved = ("a",) if program.outputs_need_accelerations else ()

    def routine(
        name: str, arguments: tuple[str, ...], changed: tuple[str, ...], results: Results,
        body: Assignments | None = None,
    ) -> Routine:  # fmt: skip
        """With the assignments of the step that the results need, or with a `body` of its own."""
        body = program.order(e for _, _, e in results) if body is None else body
        used = [*(e for _, e in body), *(e for _, _, e in results)]
        needed = set().union(*(e.free_symbols for e in used)) - {s for s, _ in body}
        reads = [(a, i, s) for s, (a, i) in places.items() if s in needed and a in arguments]
        return Routine(name, arguments, changed, tuple(reads), body, results, internal=name == "slopes")

    routines = [
        routine("once", ("p", "c"), ("c",), _into("c", (s for s, _ in once)), once),
        routine("step", (*given, *filled), filled, system),
        routine("feed", ("t", *given), ("u",), feed, ()),
        routine("rates", (*given, "ydot"), ("ydot",), _into("ydot", program.rates)),
        routine("outputs", (*given, *solved, "out"), ("out",), _into("out", program.outputs.values())),
    ]
    if c is not None:
        results = _into("res", c.residual) + _into("turn", c.turning)
        routines.append(routine("manifold", (*given, "res", "turn"), ("res", "turn"), results))
    if jacobian:
        J = jacobian_of(program)
        entries = [*J.drates, *J.dg, *J.dh]
        assert len(entries) == (ny + program.m) * ny
        body = tuple(definition_order(dict(J.step), entries).items())
        routines.append(routine("slopes", ("t", *given, "a", "J"), ("J",), _into("J", entries), body))
    return once, routines


def sizes(program: OrderedProgram, once: Assignments) -> dict[str, int]:
    """Numbers in the arguments of the routines; J is that of the constraints."""
    n, nq = program.n, len(program.coordinates)
    return {
        "p": len(program.parameters), "c": len(once), "y": len(program.state), "u": len(program.inputs), "M": n * n,
        "f": n, "ydot": nq, "out": len(program.outputs), "J": program.m * n, "h": program.m,
        "a": len(program.unknowns), "turn": nq * n,
        "res": len(program.constraints.residual) if program.constraints else 0,
    }  # fmt: skip


def _into(array: str, entries: Iterable[sp.Expr]) -> Results:
    return tuple((array, i, e) for i, e in enumerate(entries))


def _places(program: OrderedProgram, once: Assignments) -> dict[sp.Symbol, tuple[str, int]]:
    places = {s: ("p", i) for i, s in enumerate(program.parameters)}
    places |= {s: ("a", i) for i, s in enumerate(program.unknowns)}
    places |= {s: ("c", i) for i, (s, _) in enumerate(once)}
    places |= {s: ("y", i) for i, s in enumerate(program.state)}
    return places | {s: ("u", i) for i, s in enumerate(program.inputs)}
