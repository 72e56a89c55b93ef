"""Stages of a simulated loop in one call of C (loop_stages.c): a mechanism and blocks affine in its outputs."""

from __future__ import annotations

import ctypes

import numpy as np

from spacar.arrays import Array, Index
from spacar.compiled.compiled_evaluator import CompiledDynamics
from spacar.compiled.interface import structure
from spacar.compiled.library import address_of
from spacar.kinematics.kinematics import CONVERGED, LARGEST_JUMP


class LoopStages:
    """The evaluation of a loop; its state is (q, states of blocks, v).

    read     rows (n_read,) of the values of the mechanism that blocks read
    load     rows (n_load,) of what inputs drive: forces (nx), behind them stresses (ne)
    matrix   (n_load + n_states, 1 + n_given + n_states + n_read) from (1, given signals, states, what is read)
    """

    def __init__(self, evaluator: CompiledDynamics, read: Index, load: Index, matrix: Array, n_given: int) -> None:
        model, n = evaluator.solver, 2 * evaluator.numbering.nddof
        n_states = len(matrix) - len(load)
        self.engine, self.evaluator = model.engine, evaluator
        self.read, self.load = np.ascontiguousarray(read, np.int32), np.ascontiguousarray(load, np.int32)
        self.matrix, self.n_given = np.array(matrix, float, order="C"), n_given
        own = model.force[:, 0], model.preload[:, 0]
        assert all(part.flags.c_contiguous for part in own)  # one behind the other
        self.matrix[: len(load), 0] += np.concatenate((model.numbers.force, model.numbers.preload))[load, 0]
        self.memory = np.zeros(self.matrix.shape[1] + 2 * n + n + n_states)
        first = address_of(self.memory)
        own_at = first + 8 * self.matrix.shape[1]
        self.stage = own_at + 16 * n
        shared = (array.ctypes.data for array in (self.read, self.load, self.matrix))
        self.c = structure("Loop")(
            model.handle, evaluator.state.address, *shared, first, own_at, own_at + 8 * n,
            len(self.read), len(self.load), n_given, n_states, CONVERGED, LARGEST_JUMP,
        )  # fmt: skip
        self.address = ctypes.addressof(self.c)

    def __call__(
        self, done: int, c: Array, a: Array, t: float, h: float, window: tuple[float, float], given: Array, y: Array,
        K: Array,
    ) -> int:  # fmt: skip
        """Stages from `done` on, see `spacar.integrators.problem.Problem`; `given` (stages, n_given) at their times."""
        at_c, at_a, at_given, at_y, at_K = map(address_of, (c, a, given, y, K))
        reached = int(self.engine.loop_stages(
            self.address, done, len(c), at_c, at_a, t, h, *window, at_given, at_y, at_K, len(y), self.stage
        ))  # fmt: skip
        if reached < len(c):
            self.evaluator.solver.slots.interrupted()
        return reached
