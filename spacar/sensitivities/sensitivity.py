"""Derivatives of stationary quantities with respect to numbers of the deck: the call, and what it returns.

One analysis: the path to the load steps is walked as in modes 7 to 10, and at every step that is asked for the state,
the linearized equations and the stresses are differentiated along all parameters (docs/sensitivity.md).

Numbers of the deck by the names that parameter studies use (spacar.studies.assignments), and directions along them.

    ESTIFF.3[EI]   X.2[x]   SECTION.leaf[dimension 2]   INPUTX.4.1 & INPUTX.5.1   XF.*[2]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.calls import Source, deck_of, frames, texts
from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.directed import DirectedDeck, nothing_lost
from spacar.deck.length_unit import shown_in
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.limits import Limits
from spacar.errors import UsageError
from spacar.expressions import Dimensions, unit_text
from spacar.expressions.evaluation import Value
from spacar.expressions.grammar import ALIASES, indices, parse
from spacar.kinematics.constraint_condition import condition_number
from spacar.linear.linear_modes import say_lost_digits
from spacar.linearization.matrices import linearize
from spacar.mechanism import Mechanism
from spacar.mechanism.build import along
from spacar.modes import registered
from spacar.sensitivities.expression_derivatives import derivative, steps_of, variables
from spacar.sensitivities.state_derivatives import state_derivatives
from spacar.sensitivities.step_quantities import (
    LINEAR,
    STRESS_INDICES,
    STRESSES,
    LinearQuantities,
    Variable,
    check_variable,
    step_quantity,
    stress_derivatives,
)
from spacar.stationary import LoadProgram, StationarySolver
from spacar.stream import Run
from spacar.studies.assignments import Setting, change, parameters_of, setting
from spacar.studies.runs.quantities import Quantity, quantity
from spacar.summary import counted

COLUMNS = ("quantity", "value", "unit", "parameter", "at", "unit of parameter", "derivative", "relative")
SHOWN, MOST_LINES = 4, 8  # parameters in a line of a summary, lines
MODE = 10  # vibration and buckling about the stationary states
WITH_WHEELS = 7


@dataclass(frozen=True, repr=False)
class Sensitivity:
    """values (quantities,) and derivatives (quantities, parameters) of quantities by parameters.

    parameters, quantities   their names;  parameter_values (parameters,) in the unit of the file
    parameter_units, quantity_units   as text; a derivative is in the unit of its quantity per unit of its parameter
    notes   the lines of the report of the analysis, among them its warnings

    >>> import spacar
    >>> found = spacar.sensitivity("data/plbeam5.dat", ["EM.1"], ["frequency[1]@end"])
    >>> found.values.shape
    (1,)
    """

    parameters: tuple[str, ...]
    quantities: tuple[str, ...]
    values: Array
    derivatives: Array
    parameter_values: Array
    parameter_units: tuple[str, ...]
    quantity_units: tuple[str, ...]
    notes: tuple[str, ...] = ()

    @property
    def relative(self) -> Array:
        """(quantities, parameters) relative change of the quantity by relative change of the parameter, p/q dq/dp; nan
        where the quantity is zero."""
        with np.errstate(all="ignore"):
            found = self.derivatives * self.parameter_values / self.values[:, None]
        return np.where(self.values[:, None] != 0.0, found, np.nan)

    def __repr__(self) -> str:
        n, m = self.derivatives.shape
        lines = [f"Sensitivity of {counted(n, 'quantity')} by {counted(m, 'parameter')}"]
        for q, value, unit, row in zip(
            self.quantities, self.values, self.quantity_units, self.derivatives, strict=True
        ):
            rates = ", ".join(f"{rate:.6g} by {p}" for p, rate in zip(self.parameters[:SHOWN], row, strict=False))
            lines.append(f"  {q} = {value:.6g} {unit}".rstrip() + f": {rates}{', ...' * (len(row) > SHOWN)}")
        if len(lines) > MOST_LINES:
            lines[MOST_LINES:] = [f"  ... {len(lines) - MOST_LINES} more"]
        return "\n".join([*lines, "  .derivatives, .relative, .of(quantity, parameter), .plot(), .to_pandas()"])

    def plot(self, path: str | Path | None = None) -> Any:
        """A matplotlib figure of the relative changes, also written to `path`."""
        return registered("sensitivity_plot")(self, path)

    def to_pandas(self) -> Any:
        """A pandas.DataFrame, a row for each quantity and parameter. Raises UsageError without pandas
        (`pip install 'spacar[tables]'`)."""
        return registered("frame_of_rows")([dict(zip(COLUMNS, row, strict=True)) for row in self.rows()])

    def rows(self) -> list[tuple[str | float, ...]]:
        """A row for each quantity and parameter, in the order of COLUMNS."""
        relative = self.relative
        return [
            (
                q, float(self.values[i]), self.quantity_units[i], p, float(self.parameter_values[j]),
                self.parameter_units[j], float(self.derivatives[i, j]), float(relative[i, j]),
            )
            for i, q in enumerate(self.quantities)
            for j, p in enumerate(self.parameters)
        ]  # fmt: skip

    def of(self, name: str, parameter: str) -> float:
        """The derivative of a quantity by a parameter, both by name. Raises UsageError for unknown names."""
        for word, known in ((name, self.quantities), (parameter, self.parameters)):
            if word not in known:
                raise UsageError(f"'{word}' is not among {', '.join(known)}", "sensitivity.name")
        return float(self.derivatives[self.quantities.index(name), self.parameters.index(parameter)])


def sensitivity(
    model: Source, parameters: str | Sequence[str], quantities: str | Sequence[str], *,
    at: Sequence[float] | None = None, **options: Any,
) -> Sensitivity:  # fmt: skip
    """Exact derivatives of stationary quantities with respect to numbers of the deck, from one analysis.

    model        path of an input file, a Deck or a Model
    parameters   numbers of the deck as `spacar sweep --set` names them: 'ESTIFF.3[EI]', 'X.2[2] & X.5[2]',
                 'SECTION.leaf[t]'; in the unit of the file (UNITS)
    quantities   expressions (`spacar help expressions`), 'NAME: EXPRESSION' too, that come to one number: 'x[5,1]@end',
                 'frequency[1]', 'abs(sig[1,2])', 'lmult[1]', 'xcompl[5,1]', 'mises[3]', 'Mz[3,1]'; in SI
    at           numbers that the parameters are given first
    options      what overrides the deck, as for `run`

    Raises UsageError for names that the model does not have and for models whose derivatives are not followed (linear
    quantities of wheels), and AnalysisError as modes 7 to 10 and 'sensitivity.singular' at critical states.

    >>> import spacar
    >>> found = spacar.sensitivity("data/plbeam5.dat", ["XF.11[3]"], ["x[11,2]@end"])
    >>> found.derivatives.shape
    (1, 1)
    """
    names = texts("parameters", parameters)
    wanted = [quantity(q, STRESS_INDICES) for q in texts("quantities", quantities)]
    if "mode" in options:
        raise UsageError("sensitivity takes no mode: all stationary quantities are asked at once", "sensitivity.mode")
    deck, numbers = deck_numbers(_read(model), names)
    if at is not None:
        if len(at) != len(numbers):
            raise UsageError(f"{len(at)} numbers for {len(numbers)} parameters", "sensitivity.parameter")
        deck = change(deck, [n.setting for n in numbers], [float(v) for v in at])
        deck, numbers = deck_numbers(deck, names)
    return _Analysis(frames(_mode(deck), deck, **options), deck, numbers, wanted).run()


def _mode(deck: Deck) -> int:
    """The mode that is run: without buckling and compliances for models with wheels, which have none."""
    return WITH_WHEELS if any(ELEMENT_TYPES[s.keyword].slips for s in deck.of(*ELEMENT_TYPES, block=1)) else MODE


def _read(model: Source) -> Deck:
    if isinstance(model, Deck):
        return model
    deck = deck_of(model, WITH_WHEELS)
    return deck if _mode(deck) == WITH_WHEELS else deck.for_mode(MODE)


class _Analysis:
    """One walk through the load steps."""

    def __init__(self, run: Run, deck: Deck, numbers: list[DeckNumber], wanted: list[Quantity]) -> None:
        self.prepared, self.numbers, self.wanted = run, numbers, wanted
        self.steps = run.mechanism.settings.stored_levels
        self.expressions = [parse(q.text, STRESS_INDICES) for q in wanted]
        self.needed: dict[Variable, set[int]] = {}
        for expression in self.expressions:
            places = steps_of(expression, self.steps)
            for node in variables(expression.tree):
                variable = self._variable(node)
                check_variable(variable, run.mechanism.numbering)
                self.needed.setdefault(variable, set()).update(places)
        if not run.mechanism.numbering.holonomic and any(name in LINEAR for name, _ in self.needed):
            text = f"{run.mechanism.deck.source}: no derivatives of models with wheels for eigenvalues, multipliers and"
            text += " compliances; positions, deformations, forces, stresses have them"
            raise UsageError(text, "sensitivity.model")
        self.directions = directions(run.mechanism, deck, numbers)
        kinds = {v: complex if v[0] == "eigval" else float for v in self.needed}
        shapes = (self.steps,), (self.steps, len(numbers))
        self.found = {v: [np.full(shape, np.nan, kind) for shape in shapes] for v, kind in kinds.items()}

    @staticmethod
    def _variable(node: Any) -> Variable:
        name = node.value.id
        return ALIASES.get(name, name), indices(node, name, STRESS_INDICES)

    def run(self) -> Sensitivity:
        self._walk()
        moving = [derivative(e, self._leaf, self.steps, len(self.numbers)) for e in self.expressions]
        for q, found in zip(self.wanted, moving, strict=True):
            if found.values.size == 1 and np.iscomplexobj(found.values):
                raise UsageError(f"{q.text} is complex; take its abs(), real() or imag()", "sensitivity.quantity")
            q.single(found.values, "sensitivity.quantity")
        shape = (len(moving), len(self.numbers))
        return Sensitivity(
            parameters=tuple(n.setting.name for n in self.numbers),
            quantities=tuple(q.name for q in self.wanted),
            values=np.array([float(np.ravel(m.values)[0]) for m in moving]),
            derivatives=np.array([m.rates.reshape(-1) for m in moving]).reshape(shape),
            parameter_values=np.array([n.value for n in self.numbers]),
            parameter_units=tuple(n.unit for n in self.numbers),
            quantity_units=tuple(unit_text(m.unit) for m in moving),
            notes=tuple(self.prepared.report.lines),
        )

    def _leaf(self, node: Any) -> Value:
        name, numbers = variable = self._variable(node)
        value, rate = self.found[variable]
        dimensions = Dimensions.of(self.prepared.mechanism.numbering, True)
        return Value(value, STRESSES[name] if name in STRESSES else dimensions(name, numbers), rate)

    def _require_determined(self, d: Dynamics, step: int) -> None:
        """The linearized equations need degrees of freedom that determine the configuration. Raises AnalysisError."""
        header = self.prepared.header
        if "condition" not in header:
            header["condition"] = condition_number(d.kinematics)
            say_lost_digits(self.prepared, reduced=False)
        matrix = d.position_matrix()
        if len(matrix.columns):
            matrix.check(float(step))

    def _walk(self) -> None:
        from spacar.compiled import mechanism_of

        mechanism, report = self.prepared.mechanism, self.prepared.report
        last = max((k for steps in self.needed.values() for k in steps), default=-1)
        names = {name for name, _ in self.needed}
        stresses = stress_derivatives(mechanism, self.directions, MODE) if names & STRESSES.keys() else None
        solver = StationarySolver(mechanism_of(self.prepared), report)
        stored, limits = 0, None
        for level in LoadProgram(mechanism.settings):
            if stored > last:
                return
            with np.errstate(all="ignore"):
                solver.solve(level)
            if not level.store:
                continue
            here = [v for v, steps in self.needed.items() if stored in steps]
            if here:
                d, state = solver.dynamics, solver.solution
                frame = solver.frame(stored)
                limits = limits or Limits(d, report)
                limits.check_elements(d, frame)
                states = state_derivatives(solver, level, self.directions)
                linear = None
                if any(name in LINEAR for name, _ in here):
                    self._require_determined(d, stored)
                    linear = LinearQuantities(d, linearize(d, state.xdd, state.sigma), states, report, solver.moving)
                for v in here:
                    values, rates = self.found[v]
                    n = mechanism.numbering
                    values[stored], rates[stored] = step_quantity(v, frame, n, states, linear, stresses)
            stored += 1


@dataclass(frozen=True)
class DeckNumber:
    """A number of the deck: its setting, present value in the unit of the file, and that unit; places: statements,
    numbers of arguments (from 1), and what a unit of the number is in SI."""

    setting: Setting
    value: float
    unit: str
    places: tuple[tuple[Statement, int, float], ...]


def deck_numbers(deck: Deck, names: Sequence[str]) -> tuple[Deck, list[DeckNumber]]:
    """The numbers with these names. Arguments that were left out stand in the deck that is returned.

    Raises UsageError for names that the deck does not have, and for several places with different numbers.
    """
    settings = [setting(name) for name in names]
    for given in settings:
        missing = [(s, p) for t in given.targets for s, p in t.places(deck) if p > len(s.values)]
        if missing:
            s, p = missing[0]
            default = parameters_of(deck, s)[p - 1].default
            if default not in (None, 0.0):
                text = f"{s.subject}: argument {p} is left out; write its value into the file"
                raise UsageError(text, "sensitivity.parameter")
            deck = change(deck, [given], [0.0])
    directed = DirectedDeck(deck)
    return deck, [_number(deck, directed, given) for given in settings]


def _number(deck: Deck, directed: DirectedDeck, given: Setting) -> DeckNumber:
    values, places, unit = [], [], ""
    for target in given.targets:
        for s, p in target.places(deck):
            deck.require_written(s)
            parameters = parameters_of(deck, s)
            if parameters[p - 1].kind != "real":
                text = f"{given.name} is no real number; derivatives are with respect to real numbers"
                raise UsageError(text, "sensitivity.parameter")
            places.append((s, p, directed.factor(s, p, parameters)))
            values.append(float(s.values[p - 1]) / places[-1][2])
            unit = shown_in(parameters[p - 1].unit, deck.metre)[1]
    if max(values) - min(values) > 1e-12 * max(map(abs, values)):
        listed = ", ".join(f"{v:.9g}" for v in values[:4])
        text = f"{given.name} stands for {len(values)} different numbers ({listed}); make them equal, or name one"
        raise UsageError(text, "sensitivity.parameter")
    return DeckNumber(given, values[0], unit, tuple(places))


def directions(mechanism: Mechanism, deck: Deck, numbers: Sequence[DeckNumber]) -> list[Mechanism]:
    """The mechanism with each of the numbers of a deck moved by a complex step; its beams may be divisions of those of
    the deck (option `elements`). Raises UsageError for a number whose derivative is not followed."""
    pieces = {}
    for beam, parts in mechanism.deck.divided.items():
        before = deck.divided.get(beam, (beam,))
        pieces.update(dict.fromkeys(before, len(parts) // len(before)))
    directed = DirectedDeck(deck, pieces)
    found = []
    with nothing_lost():
        for number in numbers:
            try:
                found.append(along(mechanism, directed.along(number.places)))
            except (TypeError, RuntimeWarning) as error:
                text = f"derivatives with respect to {number.setting.name} are not followed ({error})"
                raise UsageError(text, "sensitivity.parameter") from None
    return found
