"""The rates of a loop in C: where one compiled mechanism is the only block with rates of its own, and all that they
depend on besides is affine (affine_blocks.py) or given in time, the stages of a step are one call
(spacar/compiled/loop_stages.py).
"""

from itertools import pairwise

import numpy as np

from spacar.arrays import Array
from spacar.simulation.affine_blocks import AffineRun, Plan
from spacar.simulation.blocks import NONE
from spacar.simulation.diagram import Schedule
from spacar.simulation.evaluated_plant import CompiledPlant
from spacar.simulation.plant import Spasim


class CompiledLoop:
    """`stages` of a problem (integrators/problem.py), of states in the order of stepping.py; `rates`: of one alone."""

    def __init__(self, s: Schedule, plan: Plan, plant: Spasim, motion: CompiledPlant) -> None:
        from spacar.compiled.loop_stages import LoopStages

        self.plant, order = plant, plan.for_rates
        self.sources = [b for b in order.first if b is not plant]
        ends = np.cumsum([0, *(b.n_out for b in self.sources)])
        self.places = [slice(a, b) for a, b in pairwise(ends)]
        n_x = sum(b.n_states for b in s.blocks)
        own, outputs = s.states[plant.name], n_x + s.outputs[plant.name].start
        read, rows = plant.placed
        signals = [n_x + k for b in self.sources for k in range(s.outputs[b.name].start, s.outputs[b.name].stop)]
        others = [k for k in range(n_x) if not own.start <= k < own.stop]
        # what z of the plan is of (1, signals, states of blocks, what is read)
        known = np.array([-1, *signals, *others, *(outputs + read)], np.int64)
        z = np.zeros((n_x + s.wiring.shape[1] + 1, len(known)))
        z[known, np.arange(len(known))] = 1.0
        for run in order.later:
            assert isinstance(run, AffineRun)  # `loop_of` has asked
            z[n_x + run.rows] = run.matrix @ z
        product = plan.matrix @ z
        u, rates = product[: plant.n_in], product[plant.n_in :]
        stresses, forces = motion.stresses, motion.forces
        load = np.concatenate((forces.rows, motion.n.nx + stresses.rows))
        matrix = np.vstack((forces.by @ u, stresses.by @ u, rates))
        self.in_c = LoopStages(motion.evaluator, rows, load, matrix, len(signals))
        self.at, self.found, self.alone = np.zeros(n_x), np.zeros((1, n_x)), (np.zeros(1), np.zeros((1, 1)))

    def rates(self, t: float, y: Array) -> Array | None:
        """F (n,), in an array that is used again; None where C cannot, or finds what is not finite."""
        self.at[:] = y
        done = self(0, *self.alone, t, 0.0, (t, t), self.at, self.found)
        return self.found[0] if done and np.isfinite(self.found[0].dot(self.found[0])) else None

    def __call__(
        self, done: int, c: Array, a: Array, t: float, h: float, window: tuple[float, float], y: Array, K: Array
    ) -> int:
        given = np.empty((len(c), self.in_c.n_given))
        for i in range(done, len(c)):
            time = min(max(t + float(c[i]) * h, window[0]), window[1])
            for b, place in zip(self.sources, self.places, strict=True):
                given[i, place] = b.state_outputs(time, NONE)
        self.plant.forget()
        return self.in_c(done, c, a, t, h, window, given, y, K)


def loop_of(s: Schedule, plan: Plan) -> CompiledLoop | None:
    """For the present modes of the blocks; None where a part has to be asked in Python."""
    order = plan.for_rates
    if len(plan.alone) != 1 or not all(isinstance(part, AffineRun) for part in order.later):
        return None
    plant = plan.alone[0][0]
    if not isinstance(plant, Spasim) or any(b.n_states for b in order.first if b is not plant):
        return None
    motion = plant.motion
    return CompiledLoop(s, plan, plant, motion) if isinstance(motion, CompiledPlant) and not motion.whole else None
