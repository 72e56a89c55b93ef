"""Many cases of one mechanism in C, as the driver integrates them: as many at a time as a vector of the
processor has lanes (2, 4 or 8).

The state is made of blocks of that many cases; a block has all components, each with its lanes, (blocks, components,
lanes). The last block is filled up with copies of the last case. All cases share the steps.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.compiled.compiled_model import CompiledModel
from spacar.compiled.library import lanes_of_processor
from spacar.compiled.numbers import Numbers
from spacar.dynamics.loaded_mechanism import Moving, unexplained
from spacar.errors import AnalysisError
from spacar.kinematics import Kinematics
from spacar.kinematics.kinematics import CONVERGED
from spacar.kinematics.regularity import HALF_TURN, HalfTurns
from spacar.mechanism.mechanism import Mechanism


class CompiledCases:
    """The cases whose numbers are given; `mechanism` is one of them, `start` (cases, components) their state."""

    def __init__(self, mechanism: Mechanism, numbers: Numbers, start: Array) -> None:
        n = mechanism.numbering
        self.n_cases, self.size = start.shape
        self.n_positions = self.size // 2
        self.lanes = lanes = lanes_of_processor()
        of = np.minimum(np.arange(-(-self.n_cases // lanes) * lanes), self.n_cases - 1).reshape(-1, lanes)
        kinematics = Kinematics(mechanism)
        scales, equations = (kinematics.scale, mechanism.deformation_scale), len(kinematics.E)
        self.models = [CompiledModel(n, numbers.take(cases), scales, equations, polynomial=True) for cases in of]
        self.states = [model.state() for model in self.models]
        self.shown = [model.state() for model in self.models]
        self.y0 = np.ascontiguousarray(start[of].transpose(0, 2, 1)).ravel()
        self.lambda0 = HalfTurns(n).lambda0
        self.by_case = (len(of), self.size, lanes)
        self._accepted = [(state.x.copy(), state.e.copy()) for state in self.states]
        self._seen: list[tuple[Moving, Array] | None] = [None] * len(of)  # last accepted state, sign of the determinant
        self._scale = kinematics.scale[:, None]
        self._out = np.zeros_like(self.y0)

    def _addresses(self, array: Array) -> list[int]:
        start, block = array.ctypes.data, 8 * self.size * self.lanes
        return [start + k * block for k in range(len(self.models))]

    def rhs(self, t: float, y: Array, within: float = CONVERGED) -> Array:
        """Time derivative of the state. Raises AnalysisError when a case cannot be evaluated."""
        blocks = zip(self.models, self.states, self._addresses(y), self._addresses(self._out), strict=True)
        for k, (model, state, where, out) in enumerate(blocks):
            if model.rhs(state, t, where, out, within) < 0:
                # a stage of a step that is too long may have led far away: once more from the last accepted state
                state.begin(*self._accepted[k])
                if model.rhs(state, t, where, out, within) < 0:
                    raise _failed(t)
        return self._out

    def stages(
        self, done: int, c: Array, a: Array, t: float, h: float, window: tuple[float, float], y: Array, K: Array,
        within: float = CONVERGED,
    ) -> int:  # fmt: skip
        """Stages of an explicit Runge-Kutta step, see `spacar.integrators.problem.Problem`."""
        stride = self.size * len(self.models)
        reached = len(c)
        at_c, at_a = c.ctypes.data, a.ctypes.data
        blocks = zip(self.models, self.states, self._addresses(y), self._addresses(K), strict=True)
        for model, state, at_y, at_K in blocks:
            one = model.stages(state, done, len(c), at_c, at_a, t, h, window, at_y, at_K, stride, within)
            reached = min(reached, one)
            if reached < len(c):
                break
        return reached

    def component_name(self, i: int) -> str:
        """Name of a component of the state, for messages."""
        block, place = divmod(i, self.size * self.lanes)
        component, lane = divmod(place, self.lanes)
        return f"component {component} of case {min(block * self.lanes + lane, self.n_cases - 1) + 1}"

    def watch(self, t: float, y: Array) -> None:
        """Raises AnalysisError where a case comes to a dead point or half a turn, or its velocities jump (see
        `spacar.forward.continuity`): it has to be followed alone."""
        for block, (model, state) in enumerate(zip(self.models, self.states, strict=True)):
            if (np.abs(state.x[self.lambda0]) < HALF_TURN).any():
                raise _failed(t)
            sign = model.determinant()[0].copy()
            place, xd, xdd = state.of_x.copy()
            now = Moving(float(state.c.t), place, xd, xdd, state.e)
            seen, self._seen[block] = self._seen[block], (now, sign)
            if seen is not None and ((seen[1] != sign).any() or unexplained(seen[0], now, self._scale).any()):
                raise _failed(t)
            x, e = self._accepted[block]
            x[:], e[:] = state.x, state.e

    def rejected(self) -> None:
        """Back to the last accepted step."""
        for state, seen, (_, e) in zip(self.states, self._seen, self._accepted, strict=True):
            if seen is not None:
                at = seen[0]
                state.resume(at.t, np.stack((at.x, at.xd, at.xdd)), e)

    def variables(self, t: float, y: Array) -> dict[str, Array]:
        """What frames have, (nx, cases) and (ne, cases), at a state.

        Raises AnalysisError where a case cannot be evaluated, or an element may be outside the range of its theory:
        the single run says what it is.
        """
        blocks = y.reshape(self.by_case)
        for model, state, own in zip(self.models, self.shown, blocks, strict=True):
            if model.evaluate(state, t, np.ascontiguousarray(own), CONVERGED) < 0 or not model.in_range(state):
                raise _failed(t)

        def joined(arrays: list[Array]) -> Array:
            return np.concatenate(arrays, axis=-1)[:, : self.n_cases]

        found = {name: joined([getattr(s, name) for s in self.shown]) for name in ("x", "xd", "xdd", "e", "ed", "edd")}
        found["sig"] = joined([s.sigma for s in self.shown])
        found["fx"] = joined([m.numbers.force for m in self.models])
        found["fxgrav"] = joined([m.gravity for m in self.models])
        found["fxtot"] = joined([m.total for m in self.models])
        return found


def _failed(t: float) -> AnalysisError:
    return AnalysisError(f"a case of the batch could not be followed at t = {t:.9g}", "study.batch")
