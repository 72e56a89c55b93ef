"""Spasim: the non-linear mechanism as a block with inputs u and outputs y (input-language.md section 9).

States are the degrees of freedom and their rates. Inputs are driving stresses (INPUTS, positive when they do positive
work on the rate of their deformation) and forces (INPUTF). Outputs that are accelerations depend directly on the
inputs, the others do not.

Where the mechanism is for a state and inputs is found by NumPy, or by the compiled engine. A simulation asks for
positions and rates first, from which controllers make the inputs, and then for the accelerations. Inputs are stresses
and forces that are added to those of the model. Values are read by rows of one vector, in which `first` finds those of
elements (ne,) and of coordinates (nx,).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array, Index
from spacar.calls import Source, deck_of
from spacar.dynamics.array_evaluator import Dynamics, component_name
from spacar.dynamics.evaluator import Evaluator
from spacar.dynamics.limits import Limits
from spacar.errors import Report, UsageError
from spacar.frame import Frame
from spacar.linearization.signals import DRIVING_SIGN, signals
from spacar.mechanism import build
from spacar.mechanism.mechanism import Mechanism, UserForces
from spacar.simulation.blocks import Block

POSITION, RATE, ACCELERATION = range(3)
INPUT_KINDS = ("INPUTS", "INPUTF")
OUTPUT_KINDS = ("OUTE", "OUTEP", "OUTEDP", "OUTX", "OUTXP", "OUTXDP")
QUANTITY = {
    "OUTE": POSITION, "OUTX": POSITION, "OUTEP": RATE, "OUTXP": RATE, "OUTEDP": ACCELERATION, "OUTXDP": ACCELERATION,
}  # fmt: skip


class Driven(NamedTuple):
    """Rows (n,) of deformations or coordinates that inputs drive, and what each input gives them, (n, inputs)."""

    rows: Index
    by: Array


@dataclass
class ArrayPlant:
    """By NumPy. Order of the calls: `start`, then `place` for each state and `accelerate` for each of its inputs."""

    mechanism: Mechanism
    stresses: Driven
    forces: Driven
    x_parts = 3  # of nx numbers each, before those of elements

    def __post_init__(self) -> None:
        self.n = n = self.mechanism.numbering
        self.sigma, self.force = np.zeros(n.ne), np.zeros(n.nx)
        self._zero = np.zeros(n.ne), np.zeros(n.nx)
        self._values = np.zeros(3 * (n.nx + n.ne))
        self._begin()

    def _begin(self) -> None:
        self.report = Report()  # what was said of frames since the start
        self._limits: Limits | None = None

    def _within(self, evaluator: Evaluator, frame: Frame) -> Frame:
        self._limits = self._limits or Limits(evaluator, self.report)
        self._limits.check_elements(evaluator, frame)
        return frame

    @cached_property
    def dynamics(self) -> Dynamics:
        return Dynamics(replace(self.mechanism, user_signal=self._user))

    def _user(self, t: float, e: Array, ed: Array, x: Array, xd: Array) -> UserForces:
        """The inputs, added to what a user function of the file gives."""
        ze, zx = self._zero
        if self.mechanism.user_signal is None:
            return UserForces(self.sigma.copy(), self.force.copy(), ze, ze, zx, zx)
        found = self.mechanism.user_signal(t, e, ed, x, xd)
        return replace(found, sigma=found.sigma + self.sigma, force=found.force + self.force)

    def start(self) -> tuple[Array, str | None]:
        """The start state, and the doubt of an `Evaluator` there."""
        self._begin()
        return self.dynamics.start(), self.dynamics.doubt

    def push(self, u: Array) -> None:
        self.sigma[self.stresses.rows] = self.stresses.by @ u
        self.force[self.forces.rows] = self.forces.by @ u

    def place(self, t: float, y: Array) -> None:
        self._t, self._drive = t, self.dynamics.place(t, y)
        d, nx, ne = self.dynamics, self.n.nx, self.n.ne
        self._values[: 2 * nx] = np.concatenate((d.kinematics.x, d.xd))
        self._values[3 * nx : 3 * nx + 2 * ne] = np.concatenate((d.sweep.e, d.sweep.rate(d.xd)))

    def accelerate(self) -> None:
        xdd, _, convective = self.dynamics.accelerate(self._t, self._drive)
        nx, ne = self.n.nx, self.n.ne
        self._values[2 * nx : 3 * nx] = xdd
        self._values[3 * nx + 2 * ne :] = self.dynamics.sweep.rate(xdd) + convective

    def forget(self) -> None:
        """Neither what has been evaluated nor the inputs are there any more."""

    def first(self, quantity: int, of_elements: bool) -> int:
        """Row of the first position, rate or acceleration."""
        return self.x_parts * self.n.nx + quantity * self.n.ne if of_elements else quantity * self.n.nx

    def read(self, rows: Index) -> Array:
        """Values (rows,): positions and rates after `place`, accelerations after `accelerate`."""
        return self._values[rows]

    def frame(self, t: float, y: Array) -> Frame:
        """The whole state, as mode 1 gives it, within the limits that it knows; their warnings are in the report."""
        return self._within(self.dynamics, self.dynamics.frame(t, y))


@dataclass
class CompiledPlant(ArrayPlant):
    """In C, for mechanisms in which `why_general` finds no obstacle. A state that C cannot do is left to NumPy, which
    explains failures.

    One evaluation gives everything. `place` makes it with the inputs of the last `push`; if the next inputs are the
    same, as between the samples of a controller, `accelerate` does not make it again. `whole`: rates and accelerations
    of other deformations than the degrees of freedom are read, which takes twice as long.
    """

    whole: bool
    x_parts = 6

    def __post_init__(self) -> None:
        from spacar.compiled import CompiledDynamics

        super().__post_init__()
        self.evaluator = CompiledDynamics(self.mechanism)
        self._values = self.evaluator.state.together
        self._known = False
        self._pushed: bytes | None = None  # the inputs that C has

    def start(self) -> tuple[Array, str | None]:
        self._known = False
        self._begin()
        return self.evaluator.start(), self.evaluator.doubt

    def push(self, u: Array) -> None:
        if self._known and u.tobytes() == self._pushed:
            return
        self._known, self._pushed = False, u.tobytes()
        super().push(u)
        self.evaluator.solver.push(self.sigma, self.force)

    def place(self, t: float, y: Array) -> None:
        self._at = t, y.copy()
        self._evaluate()

    def accelerate(self) -> None:
        if not self._known:
            self._evaluate()

    def _evaluate(self) -> None:
        if not self.evaluator.reach(*self._at, self.whole):
            self._explain()
        self._known = True

    def _explain(self) -> None:
        """By NumPy, with its values where those of C are read."""
        in_c, nx = self._values, self.n.nx
        self._values = np.zeros(3 * (nx + self.n.ne))
        self.dynamics.stand(self.evaluator.placement())
        try:
            super().place(*self._at)
            super().accelerate()
            self.evaluator.stand(self.dynamics.placement())
            in_c[: 3 * nx] = self._values[: 3 * nx]
            in_c[6 * nx : 6 * nx + 3 * self.n.ne] = self._values[3 * nx :]
        finally:
            self._values = in_c

    def forget(self) -> None:
        self._known, self._pushed = False, None

    def frame(self, t: float, y: Array) -> Frame:
        self._known = False
        if self.evaluator.reach(t, y, True):
            return self._within(self.evaluator, self.evaluator.frame(t, y))
        self.dynamics.stand(self.evaluator.placement())
        found = super().frame(t, y)
        self.evaluator.stand(self.dynamics.placement())
        return found


class Spasim(Block):
    """A mechanism from a file name, a Deck, a Model or a Mechanism.

    Raises InputError for a wrong file, UsageError without dynamic degrees of freedom; its methods raise ValueError for
    vectors of wrong size.
    """

    def __init__(self, model: Source | Mechanism, name: str = "plant") -> None:
        mechanism = model if isinstance(model, Mechanism) else build(deck_of(model, "simulation"), 1)
        n = mechanism.numbering
        if not n.nddof:
            text = f"{mechanism.deck.source}: a simulation needs dynamic degrees of freedom (DYNX, DYNE)"
            raise UsageError(text, "simulation.no-states")
        self.mechanism, self.numbering = mechanism, n
        self.u_signals, self.y_signals = signals(mechanism, INPUT_KINDS), signals(mechanism, OUTPUT_KINDS)
        super().__init__(name, [s.name for s in self.u_signals], [s.name for s in self.y_signals])
        self.direct = np.array([QUANTITY[s.kind] == ACCELERATION for s in self.y_signals], bool)
        self.choose(mechanism.settings.compiled)
        self.breaks = tuple(mechanism.drive.breaks)
        self.states = tuple(component_name(n, i) for i in range(2 * n.nddof + n.nk))
        self.x0 = self.start()

    def choose(self, compiled: bool) -> None:
        """Take the compiled engine where it is available and wanted, else NumPy.

        `engine` becomes ("compiled", its level) or ("general", the reason).
        """
        from spacar.compiled import level, why_general

        settings = replace(self.mechanism.settings, compiled=compiled)
        reason = why_general(replace(self.mechanism, settings=settings))
        self.engine = ("compiled", level()) if reason is None else ("general", reason)
        driven = self._driven("INPUTS", -DRIVING_SIGN), self._driven("INPUTF", 1.0)
        n = self.numbering
        of_dynamic = set(range(n.e_class["dynamic"].start, n.e_class["dynamic"].stop))
        whole = n.nk > 0 or any(s.kind in ("OUTEP", "OUTEDP") and s.index not in of_dynamic for s in self.y_signals)
        if reason is None:
            self.motion: ArrayPlant = CompiledPlant(self.mechanism, *driven, whole)
        else:
            self.motion = ArrayPlant(self.mechanism, *driven)
        self._at: tuple[float, bytes] | None = None
        self._solved: bytes | None = None
        first = self.motion.first
        rows = np.array([first(QUANTITY[s.kind], s.kind[:4] == "OUTE") + s.index for s in self.y_signals], np.int64)
        # outputs (n,) that are positions and rates, and the rows (n,) in which the motion has them
        self.placed, self._accelerated = ((k, rows[k]) for k in map(np.flatnonzero, (~self.direct, self.direct)))
        changing = [
            first(quantity, of_elements) + np.arange(part.start, part.stop)
            for quantity, kind in ((RATE, "kinematic"), (ACCELERATION, "dynamic"))
            for of_elements, part in ((False, n.x_class[kind]), (True, n.e_class[kind]))
        ]
        self._changing = np.concatenate(changing)

    def _driven(self, kind: str, sign: float) -> Driven:
        chosen = [(k, s.index) for k, s in enumerate(self.u_signals) if s.kind == kind]
        rows = sorted({row for _, row in chosen})
        by = np.zeros((len(rows), len(self.u_signals)))
        for k, row in chosen:
            by[rows.index(row), k] = sign
        return Driven(np.array(rows, np.int64), by)

    def start(self) -> Array:
        self._at = self._solved = None
        self.motion.push(np.zeros(self.n_in))
        x0, self.doubt = self.motion.start()
        return x0

    def forget(self) -> None:
        """The mechanism has been elsewhere."""
        self._at = self._solved = None
        self.motion.forget()

    # -- the mechanism --------------------------------------------------------------------------------------------
    def _place(self, t: float, x: Array) -> None:
        key = (t, x.tobytes())
        if key != self._at:
            self._at = self._solved = None
            self.motion.place(t, x)
            outputs, rows = self.placed
            self._of_state = np.zeros(self.n_out)
            self._of_state[outputs] = self.motion.read(rows)
            self._at = key

    def _solve(self, t: float, x: Array, u: Array) -> None:
        """Accelerations for these inputs; what is already known is not computed again."""
        self._place(t, x)
        key = u.tobytes()
        if key != self._solved:
            self.motion.push(u)
            self.motion.accelerate()
            self._solved = key

    def _check(self, x: Array, u: Array | None) -> None:
        if x.shape != self.x0.shape:
            raise ValueError(f"{self.name}: the state has the shape {x.shape}, expected {self.x0.shape}")
        if u is not None and u.shape != (self.n_in,):
            raise ValueError(f"{self.name}: the input has the shape {u.shape}, expected ({self.n_in},)")

    # -- the block ------------------------------------------------------------------------------------------------
    def state_outputs(self, t: float, x: Array) -> Array:
        """Outputs that are positions and rates; accelerations are left zero."""
        self._check(x, None)
        self._place(t, x)
        return self._of_state

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        self._check(x, u)
        y = self.state_outputs(t, x).copy()
        outputs, rows = self._accelerated
        if len(outputs):
            self._solve(t, x, u)
            y[outputs] = self.motion.read(rows)
        return y

    def derivative(self, t: float, x: Array, u: Array) -> Array:
        self._check(x, u)
        self._solve(t, x, u)
        n = self.numbering.nddof
        return np.concatenate((x[-n:], self.motion.read(self._changing)))

    def frame(self, t: float, x: Array, u: Array) -> Frame:
        """The whole state of the mechanism for these inputs, as mode 1 gives it.

        Raises AnalysisError for an element outside the range of its theory and for a wheel that lifts off.
        """
        self._check(x, u)
        self._at = self._solved = None
        self.motion.push(u)
        return self.motion.frame(t, x)
