"""Many outputs of one motion in one call of C (`output_block.c`): states at output times, and the frames made of them.

What an output needs besides its step is the same whoever asks for it: the state at its time, evaluated by an evaluator
of its own, and the checks of stored states. C does both as long as the checks surely find nothing; an output at which
they may find something, or that C cannot evaluate, is the last one of its call, and Python looks at it where the
evaluator stands, as if it had come alone.

A call ends after LONGEST, so that outputs are handed on while a run lasts and Ctrl-C is heard. The rows of its outputs
are used by their frames; rows that are left are those of the next call.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from functools import partial
from operator import add, sub
from typing import Any, Protocol

import numpy as np

from spacar.arrays import Array, Index
from spacar.compiled.compiled_model import EXACT, NOT_ANSWERED, CompiledModel, State
from spacar.compiled.element_parameters import GUARD
from spacar.compiled.interface import INTEGER, NUMBER, POINTER, structure
from spacar.compiled.library import WIDTH, address_of
from spacar.frame import Frame, FramesInRows
from spacar.integrators.problem import BlockOfOutputs, Counts, counts
from spacar.integrators.times import EvenTimes
from spacar.kinematics.kinematics import LARGEST_JUMP
from spacar.mechanism.numbering import Numbering

HARMLESS, LOOKED_AT, NOT_SHOWN, SUSPECT = range(4)  # as in output_block.c
LONGEST = 0.05  # s of one call, unless a single step takes longer
ROOM = 50_000  # numbers in the rows of one array, so that a frame that is kept does not keep many others: 0.4 MB
UNLIMITED = 2**31 - 1
NONE: Counts = (0, 0, 0, 0, 0)
COUNTS = 5 * ctypes.sizeof(ctypes.c_int)  # of an output

VALUE = ctypes.CFUNCTYPE(INTEGER, NUMBER, POINTER)


def counted(c: Any, begun: Counts = NONE) -> Counts:
    """What had been counted at the last output of a call, with what was before it."""
    return counts(map(add, begun, c.counted))


class OutputEvaluator(Protocol):
    """What is asked of the evaluator of outputs. `largest_exact`: equations up to which C tells the exact condition."""

    solver: CompiledModel
    state: State
    numbering: Numbering
    n_positions: int
    largest_exact: int

    def frame_in_general(self, t: float, y: Array) -> Frame:
        """That of a state that C could not do."""


class OutputBlock:
    """Outputs at `times` that `shown` evaluates.

    ground    rows of e whose stresses may press but not pull, and have to be looked at when they do
    singular  reciprocal condition of V[E, U] that has to be looked at
    far       steps since the last output beyond which the next one is evaluated from the begin of its step
    """

    def __init__(
        self, shown: OutputEvaluator, times: Sequence[float] | Array, ground: Index, singular: float, far: int
    ) -> None:
        model, n = shown.solver, shown.numbering
        self.shown, self.times = shown, times
        self.sizes = n.nx, n.ne
        self.of_y = 6 * n.nx + 4 * n.ne  # where it begins in a row
        self.width = self.of_y + shown.n_positions + n.nddof
        self.c = c = structure("OutputBlock")(ctypes.addressof(shown.state.c))
        if len(ground):
            self.ground = np.ascontiguousarray(ground, np.int32)  # C points at it
            c.ground = address_of(self.ground)
        c.exact, c.jump, c.singular, c.guard, c.longest = EXACT, LARGEST_JUMP, singular, GUARD, LONGEST
        c.width, c.far, c.n_exact, c.n_ground = self.width, far, shown.largest_exact, len(ground)
        c.foreign = model.slots.has_limits
        self.address = ctypes.addressof(c)
        self.around = np.empty((2, shown.n_positions + n.nddof))  # C points at these two
        x, e = n.x_class["dynamic"], n.e_class["dynamic"]
        of_x, of_e = np.arange(x.start, x.stop) + 2 * n.nx, np.arange(e.start, e.stop) + (6 * n.nx + 2 * n.ne)
        self.rates = np.concatenate((of_x, of_e)).astype(np.int32)
        c.around, c.rates, c.n_rates = address_of(self.around), address_of(self.rates), len(self.rates)
        self.first = self.used = self.end = 0  # output of the first row, rows that have been handed on, rows
        self.held = 0  # outputs of earlier calls that are handed on with those of the next one

    def begin(self, output: int, steps: float = UNLIMITED) -> None:
        """The next call begins with this one of the outputs; it ends at the first one behind so many steps."""
        c, begun = self.c, self.used + self.held
        if begun == self.end or output != self.first + begun:
            n = min(len(self.times) - output, max(1, ROOM // self.width))
            self.first, self.used, self.end = output, 0, n
            begun = 0
            self.rows, self.work = np.empty((n, self.width)), np.zeros((n, 5), np.int32)
            times = self.times
            self.t = (
                times.part(output, output + n) if isinstance(times, EvenTimes) else np.array(times[output : output + n])
            )
            self.at = address_of(self.t), address_of(self.rows), address_of(self.work)
        (t, rows, work) = self.at
        c.t, c.rows, c.work = t + WIDTH * begun, rows + WIDTH * self.width * begun, work + COUNTS * begun
        c.n = self.end - begun
        c.steps = UNLIMITED if steps > UNLIMITED else max(int(steps), 0)
        if not self.held:
            self.shown.solver.slots.outputs.clear()

    def start(self, y: Array) -> list[BlockOfOutputs]:
        """Evaluate the first output, whose state is y: it goes on with those behind it, if these have room and nobody
        has to look at it."""
        self.begin(0)
        self.c.n = 1
        self.rows[0, self.of_y :] = y
        self.shown.solver.engine.show(self.shown.solver.handle, self.address)
        if self.c.last != HARMLESS or self.end == 1:
            return self.outputs()
        self.held, self.c.done = 1, 0
        return []

    def outputs(self, begun: Counts = NONE) -> list[BlockOfOutputs]:
        """Those of the last call; `begun`: what the integrator had counted before it. The last one is on its own when
        it has to be looked at."""
        first, n, now = self.used, self.held + self.c.done, counted(self.c, begun)
        lost = self.shown.solver.slots.outputs
        if lost:  # C asks for them when there have been any
            lost[:0] = [{}] * (n - (self.c.last == NOT_SHOWN) - len(lost))
        self.used, self.held = first + n, 0
        if self.c.last in (HARMLESS, SUSPECT):
            return [self._passed(first, slice(0, n), begun, now)] if n else []
        before = counts(map(sub, now, self.work[first + n - 1].tolist()))
        last = self._passed(first, slice(n - 1, n), before, now)
        last = last._replace(shown=partial(self._last, last.shown, last.y))
        return [last] if n == 1 else [self._passed(first, slice(0, n - 1), begun, before), last]

    def _passed(self, first: int, which: slice, begun: Counts, now: Counts) -> BlockOfOutputs:
        """Some outputs of the last call, whose rows begin with the `first`."""
        at = slice(first + which.start, first + which.stop)
        rows, t = self.rows[at], self.t[at]
        shown = FramesInRows(t, rows, self.sizes, self.shown.solver.slots.outputs[which])
        return BlockOfOutputs(float(t[-1]), rows[-1, self.of_y :], self.work[at], begun, now, shown)

    def _last(self, block: FramesInRows, y: Array) -> FramesInRows:
        """That of the last output of a call, at which Python looks; or what says why there is none."""
        if self.c.last == LOOKED_AT:
            self.shown.solver.slots.interrupted()  # C asks about sentences of an output
        if self.c.last == NOT_SHOWN:
            if self.c.status == NOT_ANSWERED:
                self.shown.solver.slots.raise_error()
            frame = self.shown.frame_in_general(float(block.t[0]), y)
            for name, values in block.variables.items():  # in the row
                values[0] = getattr(frame, name)
            block.lost = [frame.lost]
        return block

    def prescribed(self, y: Array) -> Iterator[BlockOfOutputs]:
        """The outputs of a motion without degrees of freedom, whose state `y` is empty or the same at all times."""
        model, given = self.shown.solver, 0
        while given < len(self.times):
            self.begin(given)
            self.rows[self.used :, self.of_y :] = y
            model.engine.show(model.handle, self.address)
            given += self.c.done
            yield from self.outputs()
