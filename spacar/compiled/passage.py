"""Many outputs of one motion in one call of C (`passage.c`): states at output times, and the frames made of them.

What an output needs besides its step is the same whoever asks for it: the state at its time, evaluated by an evaluator
of its own, and the checks of stored states. C does both as long as the checks surely find nothing; an output at which
they may find something, or that C cannot evaluate, is the last one of its call, and Python looks at it where the
evaluator stands, as if it had come alone.

A call ends after LONGEST, so that outputs are handed on while a run lasts and Ctrl-C is heard. The rows of its outputs
are used by their frames; rows that are left are those of the next call.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array, Index
from spacar.compiled.compiled_model import EXACT, NOT_ANSWERED
from spacar.compiled.element_parameters import GUARD
from spacar.compiled.library import DOUBLES, INTEGER, INTEGERS, NUMBER, POINTER
from spacar.frame import Frame
from spacar.integrators.problem import Counts, Passed
from spacar.kinematics.kinematics import LARGEST_JUMP

if TYPE_CHECKING:
    from spacar.compiled.compiled_evaluator import CompiledDynamics

HARMLESS, LOOKED_AT, NOT_SHOWN = range(3)  # as in passage.c
LONGEST = 0.05  # s of one call, unless a single step takes longer
ROOM = 50_000  # numbers in the rows of one array, so that a frame that is kept does not keep many others: 0.4 MB
UNLIMITED = 2**31 - 1

VALUE = ctypes.CFUNCTYPE(INTEGER, NUMBER, POINTER)


class CPassage(ctypes.Structure):
    """`Passage` of passage.c."""

    _fields_ = [
        ("shown", POINTER), ("t", DOUBLES), ("rows", DOUBLES), ("work", INTEGERS), ("row", DOUBLES),
        ("column", DOUBLES), ("ground", INTEGERS), ("value", POINTER),
        *((name, NUMBER) for name in ("exact", "jump", "singular", "guard", "longest")),
        *((name, INTEGER) for name in (
            "n", "done", "width", "since", "far", "n_exact", "n_ground", "foreign", "steps", "last", "status",
        )),
    ]  # fmt: skip


class Passage:
    """Outputs at `times` that `shown` evaluates.

    ground   rows of e whose stresses may press but not pull, and have to be looked at when they do
    far      steps since the last output beyond which the next one is evaluated from the begin of its step
    """

    def __init__(self, shown: CompiledDynamics, times: Sequence[float] | Array, ground: Index, far: int) -> None:
        model, n = shown.solver, shown.numbering
        self.shown, self.times = shown, times
        self.nx, self.ne = n.nx, n.ne
        self.n_y = shown.n_positions + n.nddof
        self.width = 6 * n.nx + 4 * n.ne + self.n_y
        matrix = shown.position_matrix()
        self.kept = np.ascontiguousarray(ground, np.int32), matrix.rows, matrix.columns  # what C points at
        self.c = c = CPassage(shown.state.address.value)
        c.ground, c.row, c.column = (values.ctypes.data for values in self.kept)
        c.exact, c.jump, c.singular, c.guard, c.longest = EXACT, LARGEST_JUMP, matrix.zero, GUARD, LONGEST
        c.width, c.far, c.n_exact, c.n_ground = self.width, far, shown.largest_exact, len(ground)
        c.foreign = model.slots.has_limits
        self.address = ctypes.c_void_p(ctypes.addressof(c))
        self.first = self.used = self.end = 0  # output of the first row, rows that have one, rows
        self.rows, self.t, self.work = np.zeros((0, self.width)), np.zeros(0), np.zeros((0, 3), np.int32)

    def begin(self, output: int, steps: float = UNLIMITED) -> None:
        """The next call begins with this one of the outputs; it ends at the first one behind so many steps."""
        c = self.c
        if self.used == self.end or output != self.first + self.used:
            n = min(len(self.times) - output, max(1, ROOM // self.width))
            self.first, self.used, self.end = output, 0, n
            self.rows, self.work = np.empty((n, self.width)), np.empty((n, 3), np.int32)
            self.t = np.array(self.times[output : output + n])
        c.t, c.rows, c.work = self.t[self.used :].ctypes.data, self.rows[self.used :].ctypes.data, self.work.ctypes.data
        c.n = self.end - self.used
        c.steps = int(min(max(steps, 0), UNLIMITED))
        self.shown.solver.slots.outputs.clear()

    def outputs(self, before: Counts = (0, 0, 0, 0, 0)) -> Iterator[Passed]:
        """Those of the last call; `before`: what the integrator had counted before it."""
        c, shown, nx, ne = self.c, self.shown, self.nx, self.ne
        used, n, lost = self.used, self.c.done, list(shown.solver.slots.outputs)
        last, status = c.last, c.status
        self.used += n
        rows, times = self.rows[used : used + n], self.t[used : used + n].tolist()
        of_x, of_e = rows[:, : 6 * nx].reshape(n, 6, nx), rows[:, 6 * nx : 6 * nx + 4 * ne].reshape(n, 4, ne)
        states, work = rows[:, 6 * nx + 4 * ne :], self.work[:n].tolist()
        steps, rhs, jacobians, rejected, iterations = before
        for k, (t, (x, xd, xdd, applied, gravity, total), (e, ed, edd, sigma), y) in enumerate(
            zip(times, of_x, of_e, states, strict=True)
        ):
            made = work[k]
            counts = steps + made[0], rhs + made[1], jacobians, rejected + made[2], iterations
            if last == NOT_SHOWN and k == n - 1:
                yield Passed(t, y, counts, self._explained(t, y, status))
                return
            frame = Frame(t, x, xd, xdd, e, ed, edd, sigma, applied, gravity, total)
            if lost:
                frame.lost = lost[k]
            looked_at = last == LOOKED_AT and k == n - 1
            yield Passed(t, y, counts, (lambda frame=frame: frame) if looked_at else frame)

    def _explained(self, t: float, y: Array, status: int) -> Callable[[], Frame]:
        """What gives the frame of an output that C could not evaluate, or says why."""

        def frame() -> Frame:
            if status == NOT_ANSWERED:
                self.shown.solver.slots.raise_error()
            return self.shown.frame_in_general(t, y)

        return frame

    def made(self) -> tuple[int, int, int]:
        """Steps, derivatives and rejected steps of the last call up to its last output."""
        steps, rhs, rejected = self.work[self.c.done - 1].tolist()
        return steps, rhs, rejected

    def prescribed(self, y: Array) -> Iterator[Passed]:
        """The outputs of a motion without degrees of freedom, whose state `y` is empty or the same at all times."""
        model, given = self.shown.solver, 0
        while given < len(self.times):
            self.begin(given)
            self.rows[self.used :, 6 * self.nx + 4 * self.ne :] = y
            model.engine.show(model.handle, self.address)
            given += self.c.done
            yield from self.outputs()
