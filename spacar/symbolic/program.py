"""From equations to an ordered program, and what a program can do: run, be written, be compiled."""

import os
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.collect import definition_order
from spacar.symbolic.compiled_program import CompiledFunction
from spacar.symbolic.derivation import DerivedEquations
from spacar.symbolic.emit import emit
from spacar.symbolic.ordered import UNCONSTRAINED, ConstraintRows, OrderedProgram, plain_symbols
from spacar.symbolic.program_jacobian import Jacobian, NameSource, jacobian_of, share
from spacar.symbolic.simulated_motion import Feeds, make_function, simulate
from spacar.symbolic.transform import DirectionCosines
from spacar.symbolic.unit_vectors import TIME


@dataclass(frozen=True, eq=False)
class EquationProgram(OrderedProgram):
    """A program with what can be done with it."""

    @property
    def jacobian(self) -> Jacobian:
        """The program of ∂g/∂y, see `program_jacobian.py`."""
        return jacobian_of(self)

    def function(
        self, values: dict[str, float], jacobian: bool = False, feeds: Feeds | None = None
    ) -> Any:
        """f(t, y) -> ẏ and f.jac(t, y) in Python for parameter values; see `simulated_motion.py`."""
        return make_function(self, values, jacobian, feeds)

    def compile(
        self, values: dict[str, float], feeds: Feeds | None = None
    ) -> CompiledFunction:
        """The same function in C, compiled here: f(t, y), f.jac, f.outputs; give it to `simulate(function=...)`.

        `feeds`: functions of (t, y) for inputs without law. Raises AnalysisError when there is no C compiler.
        """
        return CompiledFunction(self, values, feeds)

    def simulate(self, values: dict[str, float], start: dict[str, float], **options: Any) -> Any:
        """Integrate the motion; see `simulated_motion.simulate`."""
        return simulate(self, values, start, **options)

    def text(self, language: str, jacobian: bool = False) -> str:
        """Source text in python, c, fortran or latex, with a header: what an exported file holds."""
        return emit(self, language, jacobian)

    def code(self, language: str, jacobian: bool = False) -> str:
        """The same without header, to be executed or compiled here: only names and numbers come from the model."""
        return emit(self, language, jacobian, headed=False)

    def write(self, path: Any, language: str, jacobian: bool = False) -> None:
        """Write the source text to a file; an existing one is replaced as a whole."""
        target = Path(path)
        side = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            side.write_text(self.text(language, jacobian), encoding="utf-8")
            side.replace(target)
        finally:
            side.unlink(missing_ok=True)


def make_program(eq: DerivedEquations, outputs: dict[str, Any]) -> EquationProgram:
    """Order, share and split the assignments of `eq`; see the module."""
    values = {name: eq.scalar(v) for name, v in outputs.items()}
    n, c = len(eq.speeds), eq.constraints or UNCONSTRAINED
    results = {
        "mass": [eq.mass_matrix[i, j] for i in range(n) for j in range(i, n)], "rhs": list(eq.rhs),
        "rates": list(eq.kinematics.values()), "matrix": list(c.matrix), "bias": list(c.bias),
        "velocity": list(c.velocity), "position": list(c.position.values()),
        "turning": [rate.diff(s) for rate in eq.kinematics.values() for s in eq.speeds] if c.names else [],
        "outputs": list(values.values()),
    }  # fmt: skip
    flat = [e for group in results.values() for e in group]
    definitions = definition_order(eq.table.definitions, flat)
    plain = DirectionCosines()
    feeds = {s: None if e is None else eq.scalar(e, plain) for s, e in eq.system.inputs.items()}
    accelerations = [eq.system.accelerations.get(s, sp.Symbol(f"{s.func}_dot", real=True)) for s in eq.speeds]
    solved = [*accelerations, *c.forces]
    later = {*eq.system.accelerations.values(), *c.forces}
    for name, law in feeds.items():
        if law is not None and (found := sorted(map(str, law.free_symbols & later))):
            raise UsageError(f"the law of input {name} reads {found[0]}, which is only known after it", "input")
    known = [*eq.coordinates, *eq.speeds, *solved, *feeds]
    rule = plain_symbols(
        [*definitions, *definitions.values(), *flat, *(e for e in feeds.values() if e is not None), *known]
    )
    states = [rule[s] for s in [*eq.coordinates, *eq.speeds]]
    inputs = {sp.Symbol(s.name, real=True): e.xreplace(rule) if e is not None else None for s, e in feeds.items()}
    # with functions of time as symbols, what still contains t depends on it explicitly
    if any(TIME in e.xreplace(rule).free_symbols for e in (*definitions.values(), *flat)):
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
    rest = iter(flat)
    groups = {key: tuple(islice(rest, len(group))) for key, group in results.items()}
    constraints = eq.constraints and ConstraintRows(
        c.names, sp.ImmutableMatrix(len(c.names), n, groups["matrix"]), groups["bias"], groups["velocity"],
        dict(zip(c.position, groups["position"], strict=True)), tuple(unknowns[n:]), groups["turning"],
    )  # fmt: skip
    return EquationProgram(
        title=eq.system.title, parameters=tuple(parameters), coordinates=tuple(states[: len(eq.coordinates)]),
        speeds=tuple(states[len(eq.coordinates) :]), inputs=inputs, once=once, step=step, mass=groups["mass"],
        rhs=groups["rhs"], rates=groups["rates"],
        outputs=dict(zip(values, groups["outputs"], strict=True)), accelerations=tuple(unknowns[:n]),
        constraints=constraints,
        fields=tuple(rule[s] for beam in eq.system.beams for s in (*beam.coordinates, *beam.speeds)),
        positive=_signs(eq, parameters),
        quaternions=tuple(tuple(map(eq.coordinates.index, e)) for e in eq.system.quaternions), seconds=eq.seconds,
    )  # fmt: skip


def _signs(eq: DerivedEquations, parameters: list[sp.Symbol]) -> tuple[tuple[str, sp.Symbol, bool], ...]:
    """Parameters that must be positive (lengths, True) or not negative (masses, stiffnesses, False)."""
    rows: dict[sp.Symbol, tuple[str, bool]] = {}
    system = eq.system
    for beam in system.beams:
        rows |= {beam.mass: ("mass per length", False), **{f.stiffness: ("stiffness", False) for f in beam.fields}}
        rows[beam.length] = ("length", True)
    rows |= {body.mass: ("mass", False) for body in system.bodies}
    return tuple((what, s, strict) for s, (what, strict) in rows.items() if s in parameters)
