"""Many outputs of several cases in one call of C (`output_block.c`), into rows that are given.

Outputs at which somebody has to look, or that C cannot evaluate, end the motion: a single run says what it is.
"""

from __future__ import annotations

import ctypes

import numpy as np

from spacar.arrays import Array
from spacar.compiled.compiled_model import EXACT, NOT_ANSWERED, CompiledModel, State
from spacar.compiled.element_parameters import GUARD
from spacar.compiled.interface import structure
from spacar.compiled.library import WIDTH, address_of
from spacar.compiled.output_block import COUNTS, HARMLESS, LONGEST, NONE, NOT_SHOWN, UNLIMITED, counted
from spacar.errors import AnalysisError
from spacar.integrators.problem import BlockOfOutputs, Counts
from spacar.kinematics.kinematics import LARGEST_JUMP

SHOWN = "shown"  # of outputs that stand in their rows


class BatchOutputBlock:
    """Outputs of the lanes of a model at `times` (n,), evaluated by `shown`, into `rows` (n, 6 nx + 4 ne, lanes);
    the first one is the start, which stands in `begun`. `size`: numbers of a state of the integrators."""

    def __init__(self, solver: CompiledModel, begun: State, shown: State, size: int) -> None:
        self.solver, self.begun, self.shown = solver, begun, shown
        self.y = np.empty(size)
        self.c = c = structure("OutputBlock")(ctypes.addressof(shown.c))
        c.y, c.exact, c.jump, c.guard, c.longest = self.y.ctypes.data, EXACT, LARGEST_JUMP, GUARD, LONGEST
        c.foreign = solver.slots.has_limits
        self.address = ctypes.addressof(c)
        self.times, self.work = np.zeros(0), np.zeros((0, 5), np.int32)
        self.at, self.output, self.held = (0, 0, 0), 0, 0

    def into(self, times: Array, rows: Array, far: int) -> None:
        """The outputs to come go there; behind more than `far` steps they are evaluated from the begin of a step."""
        self.times, self.work, self.held = times, np.zeros((len(times), 5), np.int32), 0
        self.at = address_of(times), address_of(rows), address_of(self.work)
        self.c.width, self.c.far = rows[0].size, far

    def begin(self, output: int, steps: float = UNLIMITED) -> None:
        """The next call begins with this one of the outputs; it ends at the first one behind so many steps."""
        c, (t, rows, work) = self.c, self.at
        self.output = output
        c.t, c.rows, c.work = t + WIDTH * output, rows + WIDTH * c.width * output, work + COUNTS * output
        c.n = len(self.times) - output
        c.steps = int(min(max(steps, 0), UNLIMITED))

    def outputs(self, begun: Counts = NONE) -> list[BlockOfOutputs]:
        """Those of the last call; `begun`: what the integrator had counted before it. Raises AnalysisError, and what a
        user function raised."""
        self._check()
        first, end = self.output - self.held, self.output + self.c.done
        self.held = 0
        if first == end:
            return []
        work, now = self.work[first:end], counted(self.c, begun)
        return [BlockOfOutputs(float(self.times[end - 1]), self.y, work, begun, now, SHOWN)]

    def start(self, y: Array) -> list[BlockOfOutputs]:
        """The first output, whose state is y; it is handed on with those behind it. Raises as `outputs`."""
        self.show(0, y)
        self.output = self.held = 1
        self.c.done = 0
        return []

    def show(self, output: int, y: Array) -> None:
        """A single output, whose state is y. Raises as `outputs`."""
        self.begin(output)
        self.c.n = 1
        self.y[:] = y
        at = self.shown if output else self.begun
        self.c.shown = at.address
        self.solver.engine.show(self.solver.handle, self.address)
        self.c.shown = self.shown.address
        self._check()
        if at is not self.shown:
            self.shown.resume(float(at.c.t), at.x, at.xd, at.xdd, at.e)

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
