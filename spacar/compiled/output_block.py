"""Many outputs of one motion in one call of C (`output_block.c`): states at output times, and the frames made of them.

What an output needs besides its step is the same whoever asks for it: the state at its time, evaluated by an evaluator
of its own, and the checks of stored states. C does both as long as the checks surely find nothing; an output at which
they may find something, or that C cannot evaluate, is the last one of its call, and Python looks at it where the
evaluator stands, as if it had come alone.

A call ends after LONGEST, so that outputs are handed on while a run lasts and Ctrl-C is heard. The rows of its outputs
are used by their frames; rows that are left are those of the next call. Of several cases at a time rows are given, and
an output at which somebody has to look ends the motion: a single run says what it is.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from functools import partial
from operator import add, sub
from typing import Any

import numpy as np

from spacar.arrays import Array, Index
from spacar.compiled.compiled_model import EXACT, NOT_ANSWERED, CompiledModel, State
from spacar.compiled.interface import INTEGER, NUMBER, POINTER, constants, structure
from spacar.compiled.library import WIDTH, address_of
from spacar.elements.family import GUARD
from spacar.errors import AnalysisError
from spacar.frame import FramesInRows
from spacar.integrators.problem import BlockOfOutputs, Counts
from spacar.integrators.times import EvenTimes
from spacar.kinematics.kinematics import LARGEST_JUMP

HARMLESS, LOOKED_AT, NOT_SHOWN, SUSPECT = constants("HARMLESS", "LOOKED_AT", "NOT_SHOWN", "SUSPECT")
LONGEST = 0.05  # s of one call, unless a single step takes longer
ROOM = 50_000  # numbers in the rows of one array, so that a frame that is kept does not keep many others: 0.4 MB
UNLIMITED = 2**31 - 1
NONE = Counts()
COUNTS = 5 * ctypes.sizeof(ctypes.c_int)  # of an output

VALUE = ctypes.CFUNCTYPE(INTEGER, NUMBER, POINTER)
SHOWN = "shown"  # of outputs that stand in their rows


def counted(c: Any, begun: Counts = NONE) -> Counts:
    """What had been counted at the last output of a call, with what was before it."""
    return Counts(*map(add, begun, c.counted))


class OutputRows:
    """Outputs that the state `shown` evaluates, in rows of `width` numbers: `at` are the addresses of times, rows and
    counts, those of the next call begin with a place among them."""

    def __init__(self, solver: CompiledModel, shown: State, width: int, far: int) -> None:
        self.solver = solver
        self.c = structure("OutputBlock")(
            shown.address, exact=EXACT, jump=LARGEST_JUMP, guard=GUARD, longest=LONGEST, width=width, far=far,
            foreign=solver.slots.has_limits,
        )  # fmt: skip
        self.address = ctypes.addressof(self.c)
        self.at = 0, 0, 0

    def _next(self, place: int, end: int, steps: float) -> None:
        """The next call has the places up to `end`; it ends at the first output behind so many steps."""
        c, (t, rows, work) = self.c, self.at
        c.t, c.rows, c.work = t + WIDTH * place, rows + WIDTH * c.width * place, work + COUNTS * place
        c.n, c.steps = end - place, int(min(max(steps, 0), UNLIMITED))

    def _show(self) -> None:
        self.solver.engine.show(self.solver.handle, self.address)


class OutputBlock(OutputRows):
    """Outputs at `times` that `shown` evaluates (CompiledDynamics).

    ground    rows of e whose stresses may press but not pull, and have to be looked at when they do
    singular  reciprocal condition of V[E, U] that has to be looked at
    far       steps since the last output beyond which the next one is evaluated from the begin of its step
    """

    def __init__(self, shown: Any, times: Sequence[float] | Array, ground: Index, singular: float, far: int) -> None:
        model, n = shown.solver, shown.numbering
        self.shown, self.times = shown, times
        self.sizes = n.nx, n.ne
        self.of_y = 6 * n.nx + 4 * n.ne  # where it begins in a row
        self.width = self.of_y + shown.n_positions + n.nddof
        super().__init__(model, shown.state, self.width, far)
        c = self.c
        if len(ground):
            self.ground = np.ascontiguousarray(ground, np.int32)  # C points at it
            c.ground = address_of(self.ground)
        c.singular, c.n_exact, c.n_ground = singular, shown.largest_exact, len(ground)
        self.around = np.empty((2, shown.n_positions + n.nddof))  # C points at these two
        x, e = n.x_class["dynamic"], n.e_class["dynamic"]
        of_x, of_e = np.arange(x.start, x.stop) + 2 * n.nx, np.arange(e.start, e.stop) + (6 * n.nx + 2 * n.ne)
        self.rates = np.concatenate((of_x, of_e)).astype(np.int32)
        c.around, c.rates, c.n_rates = address_of(self.around), address_of(self.rates), len(self.rates)
        self.first = self.used = self.end = 0  # output of the first row, rows that have been handed on, rows

    def begin(self, output: int, steps: float = UNLIMITED) -> None:
        """The next call begins with this one of the outputs; it ends at the first one behind so many steps."""
        if self.used == self.end or output != self.first + self.used:
            n = min(len(self.times) - output, max(1, ROOM // self.width))
            self.first, self.used, self.end = output, 0, n
            self.rows, self.work = np.empty((n, self.width)), np.zeros((n, 5), np.int32)
            times = self.times
            self.t = (
                times.part(output, output + n) if isinstance(times, EvenTimes) else np.array(times[output : output + n])
            )
            self.at = address_of(self.t), address_of(self.rows), address_of(self.work)
        self._next(self.used, self.end, steps)
        self.solver.slots.outputs.clear()

    def outputs(self, begun: Counts = NONE) -> list[BlockOfOutputs]:
        """Those of the last call; `begun`: what the integrator had counted before it. The last one is on its own when
        it has to be looked at."""
        first, n, now = self.used, self.c.done, counted(self.c, begun)
        lost = self.solver.slots.outputs
        if lost:  # C asks for them when there have been any
            lost[:0] = [{}] * (n - (self.c.last == NOT_SHOWN) - len(lost))
        self.used = first + n
        if self.c.last in (HARMLESS, SUSPECT):
            return [self._passed(first, slice(0, n), begun, now)] if n else []
        before = Counts(*map(sub, now, self.work[first + n - 1].tolist()))
        last = self._passed(first, slice(n - 1, n), before, now)
        last = last._replace(shown=partial(self._last, last.shown, last.y))
        return [last] if n == 1 else [self._passed(first, slice(0, n - 1), begun, before), last]

    def _passed(self, first: int, which: slice, begun: Counts, now: Counts) -> BlockOfOutputs:
        """Some outputs of the last call, whose rows begin with the `first`."""
        at = slice(first + which.start, first + which.stop)
        rows, t = self.rows[at], self.t[at]
        shown = FramesInRows(t, rows, self.sizes, self.solver.slots.outputs[which])
        return BlockOfOutputs(float(t[-1]), rows[-1, self.of_y :], self.work[at], begun, now, shown)

    def _last(self, block: FramesInRows, y: Array) -> FramesInRows:
        """That of the last output of a call, at which Python looks; or what says why there is none."""
        if self.c.last == LOOKED_AT:
            self.solver.slots.interrupted()  # C asks about sentences of an output
        if self.c.last == NOT_SHOWN:
            if self.c.status == NOT_ANSWERED:
                self.solver.slots.raise_error()
            frame = self.shown.frame_in_general(float(block.t[0]), y)
            for name, values in block.variables.items():  # in the row
                values[0] = getattr(frame, name)
            block.lost = [frame.lost]
        return block

    def prescribed(self, y: Array) -> Iterator[BlockOfOutputs]:
        """The outputs of a motion without degrees of freedom, whose state `y` is empty or the same at all times."""
        given = 0
        while given < len(self.times):
            self.begin(given)
            self.rows[self.used :, self.of_y :] = y
            self._show()
            given += self.c.done
            yield from self.outputs()


class BatchOutputBlock(OutputRows):
    """Outputs of the lanes of a model at `times` (n,), evaluated by `shown`, into `rows` (n, 6 nx + 4 ne, lanes);
    the first one is the start, which stands in `begun`. `size`: numbers of a state of the integrators."""

    def __init__(self, solver: CompiledModel, begun: State, shown: State, size: int) -> None:
        super().__init__(solver, shown, 0, 0)
        self.begun, self.shown, self.y = begun, shown, np.empty(size)
        self.c.y = self.y.ctypes.data
        self.times, self.work, self.output = np.zeros(0), np.zeros((0, 5), np.int32), 0

    def into(self, times: Array, rows: Array, far: int) -> None:
        """The outputs to come go there; behind more than `far` steps they are evaluated from the begin of a step."""
        self.times, self.work = times, np.zeros((len(times), 5), np.int32)
        self.at = address_of(times), address_of(rows), address_of(self.work)
        self.c.width, self.c.far = rows[0].size, far

    def begin(self, output: int, steps: float = UNLIMITED) -> None:
        """The next call begins with this one of the outputs; it ends at the first one behind so many steps."""
        self.output = output
        self._next(output, len(self.times), steps)

    def outputs(self, begun: Counts = NONE) -> list[BlockOfOutputs]:
        """Those of the last call; `begun`: what the integrator had counted before it. Raises AnalysisError, and what a
        user function raised."""
        self._check()
        first, end = self.output, self.output + self.c.done
        if first == end:
            return []
        work, now = self.work[first:end], counted(self.c, begun)
        return [BlockOfOutputs(float(self.times[end - 1]), self.y, work, begun, now, SHOWN)]

    def show(self, output: int, y: Array) -> None:
        """A single output, whose state is y. Raises as `outputs`."""
        self.begin(output)
        self.c.n = 1
        self.y[:] = y
        at = self.shown if output else self.begun
        self.c.shown = at.address
        self._show()
        self.c.shown = self.shown.address
        self._check()
        if at is not self.shown:
            self.shown.resume(at.moving())

    def _check(self) -> None:
        """Raise what is wrong with the last output."""
        c = self.c
        if c.last == HARMLESS:
            return
        if c.last == NOT_SHOWN and c.status == NOT_ANSWERED:
            self.solver.slots.raise_error()
        self.solver.slots.interrupted()  # C asks about sentences of an output
        raise not_followed(float(self.times[self.output + c.done - 1]))


def not_followed(t: float) -> AnalysisError:
    """A case has to be run alone."""
    return AnalysisError(f"a case of the batch could not be followed at t = {t:.9g}", "study.batch")
