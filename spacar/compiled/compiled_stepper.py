"""Steps of an integrator in C, from output to output, or through many of them (`OutputBlock`).

The methods stay those of `spacar.integrators`: C works on the arrays of their objects and with their coefficients, so
that interpolation, failures and messages are theirs too. Python is called back where C cannot give a derivative, and
at the accepted steps that have to be looked at (`StepMonitor`).
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Protocol

import numpy as np

from spacar.arrays import Array
from spacar.compiled.interface import INTEGER, NUMBER, POINTER, structure
from spacar.compiled.library import WIDTH, address_of
from spacar.compiled.methods_in_c import (
    ARRIVED,
    INTERRUPTED,
    NOT_EVALUATED,
    PAUSED,
    TOO_SMALL,
    AdamsInC,
    RungeKuttaInC,
    address_of_call,
    vector,
)
from spacar.compiled.output_block import SUSPECT, BatchOutputBlock, OutputBlock, not_followed
from spacar.dynamics.loaded_mechanism import ALWAYS, NEVER, NOISE, SHARE, STILL, Accepted, Moving
from spacar.errors import AnalysisError
from spacar.integrators.adams import Adams
from spacar.integrators.failures import LAST_STRETCH, MAX_REDUCTIONS, REDUCTION, not_evaluated, step_too_small
from spacar.integrators.problem import Evaluation, IntegrationStatistics, Step
from spacar.integrators.runge_kutta import ExplicitRungeKutta
from spacar.kinematics.kinematics import LARGEST_JUMP
from spacar.kinematics.regularity import HALF_TURN, HalfTurns

MOST, COMPONENTS = 1000, 20_000  # steps in one call, and steps times components of x and e, so that Ctrl-C is heard

ASK = ctypes.CFUNCTYPE(INTEGER, NUMBER, POINTER, POINTER)


class StepMonitor(Protocol):
    """Who looks at accepted steps (`spacar.forward.driver`); as it is here nobody does. Of determinants there are
    logarithms."""

    look: int = NEVER  # which of them: NEVER, AT_DETERMINANTS, AT_VELOCITIES, ALWAYS
    back: bool = True  # whether the state goes back to the last accepted step after a rejected one
    half: float = 0.0  # a minimum of the determinant below its last maximum that is looked at
    inside: float = 0.0  # the same of a state inside a step below both of its ends
    wide: float = 0.0  # the same of a state below the larger end of a step in which a coordinate goes beyond `far`
    far: float = 0.0  # rad, or lengths of the model
    capacity: int = 2  # how many steps are remembered
    n: int = 0  # steps since the last output, which is counted on here

    def closer(
        self, t: float, y: Array, peak: float, before: list[Accepted] | None
    ) -> tuple[float, bool, Accepted | None]:
        """Look at the step to t, where the evaluator stands; peak of the determinants and the steps `before` it (None:
        all have been shown here). Returns peak, whether to look at the next one too, and the step (None: not known).
        Raises AnalysisError.
        """
        return peak, False, None

    def started(self, t: float, y: Array) -> Accepted | None:
        """The start of the motion, unless it has begun before: then the last step of it; None: not known."""
        return None

    def passed(self, last: Callable[[int], list[Accepted]]) -> None:
        """Steps have been made; `last(k)` gives the last k of them, fewer if fewer are known."""
        return None


class CompiledStepper:
    """The steps of one motion, by CompiledDynamics or InLanes. `output_block`: outputs that are passed many at a time;
    None: a call ends at each."""

    def __init__(
        self, evaluator: Any, monitor: StepMonitor, output_block: OutputBlock | BatchOutputBlock | None = None
    ) -> None:
        model = evaluator.solver
        self.lanes = lanes = model.cases
        nx, ne = evaluator.numbering.nx * lanes, evaluator.numbering.ne * lanes
        n = (evaluator.n_positions + evaluator.numbering.nddof) * lanes
        self.evaluator, self.monitor, self.output_block = evaluator, monitor, output_block
        self.engine = model.engine
        self.shape = n, nx
        width, capacity = 4 + n + 3 * nx + ne, monitor.capacity
        memory = np.empty(capacity * width + n)
        self.records, self.atol = memory[:-n].reshape(-1, width), memory[-n:]  # a row is read after it is written
        self.scale = evaluator.model.mechanism.scale
        first = address_of(memory)
        self.error: BaseException | None = None
        self.most = max(1, min(MOST, COMPONENTS // (nx + ne)))
        self.c = structure("Stepper")(
            model.handle, evaluator.state.address, None, first, address_of(self.scale),
            first + WIDTH * capacity * width, n, capacity, width, monitor.look, monitor.back, self.most,
            MAX_REDUCTIONS, REDUCTION, LAST_STRETCH, jump=LARGEST_JUMP, share=SHARE, noise=NOISE, still=STILL,
            half=monitor.half, inside=monitor.inside, wide=monitor.wide, far=monitor.far,
        )  # fmt: skip
        if lanes > 1:
            self.near = np.ascontiguousarray(HalfTurns(evaluator.numbering).lambda0, np.int32)
            self.c.lambda0, self.c.n_lambda0, self.c.half_turn = self.near.ctypes.data, len(self.near), HALF_TURN
        self.address = ctypes.addressof(self.c)

    def anew(self) -> None:
        """Another motion begins."""
        self.c.recorded = self.c.entered = self.c.reductions = 0

    def steps(
        self, method: Adams | ExplicitRungeKutta, t: float, t_end: float, h: float, longest: float
    ) -> Iterator[Step]:
        """Steps of a method that has been started at t, at least those with an output or where a block ends, up to
        t_end."""
        c, evaluation, output_block = self.c, method.evaluation, self.output_block
        self.atol[:], c.rtol = method.tolerance
        c.t, c.t_end, c.h, c.longest = t, t_end, h, longest
        c.earliest, c.latest = evaluation.first, evaluation.last
        c.sizes[0] = c.sizes[1] = 0.0
        c.n_steps = c.n_rhs = c.n_rejected = 0
        # C points at it while this goes on; it holds this object, and is let go at its end
        call = ASK(partial(self._ask, evaluation)) if self.lanes == 1 else None
        c.ask = None if call is None else address_of_call(call)
        by = (
            AdamsInC(self.engine, self.address, method) if isinstance(method, Adams)
            else RungeKuttaInC(self.engine, c, method, partial(self._answered, evaluation.statistics))
        )  # fmt: skip
        counted = evaluation.statistics
        output, status, first = evaluation.next_output(t), PAUSED, not c.recorded
        try:
            begun = by.begin()
            if begun:
                self._failed(NOT_EVALUATED if begun == 1 else INTERRUPTED, method, started=False)
            c.converged = evaluation.problem.within  # the start of the motion is solved to rounding
            if not (first and c.recorded):
                self._go_on(self.monitor.started(t, by.y))
            while status != ARRIVED:
                ahead = evaluation.halt - counted.n_steps
                c.most = max(1, int(min(self.most, ahead)))
                if output_block is None:
                    c.until = float(evaluation.times[evaluation.next_output(c.t)])
                    status = by.take_steps(None)
                else:
                    output_block.begin(output, ahead)
                    output_block.c.since, output_block.c.suspect = self.monitor.n, evaluation.suspect
                    status = by.take_steps(output_block)
                    output += output_block.c.done
                by.taken(status)
                known, failed = counted.counts(), status in (TOO_SMALL, NOT_EVALUATED, INTERRUPTED)
                if failed and (output_block is None or not output_block.c.done):
                    self._failed(status, method)
                here = (c.n_steps, c.n_rhs, 0, c.n_rejected)
                made = output_block.c.counted if failed and output_block is not None else here
                c.n_steps = c.n_rhs = c.n_rejected = 0
                counted.n_steps += made[0]
                counted.n_rhs += made[1]
                counted.n_rejected += made[3]
                self.monitor.n = self.monitor.n + made[0] if output_block is None else output_block.c.since
                self.monitor.passed(self._last)
                passed = None if output_block is None else output_block.outputs(known)
                evaluation.suspected = output_block is not None and output_block.c.last == SUSPECT
                yield Step(c.t, by.y, by.value, (c.sizes[1], c.sizes[0]), passed)
                if failed:  # behind the outputs that came before it
                    self._failed(status, method)
        finally:
            c.ask = None

    def _go_on(self, before: Accepted | None) -> None:
        """Go on behind the start, or the last of steps that were made elsewhere, if these are the last ones."""
        c = self.c
        if before is not None and not (c.recorded and self._seen(c.recorded - 1).at.t >= before.at.t):
            self._record(0, before)
            c.recorded, c.peak = 1, before.size

    def _failed(self, status: int, method: Any, started: bool = True) -> None:
        """Raise what ended a call."""
        c, evaluation = self.c, method.evaluation
        error, self.error = self.error, None
        if status == TOO_SMALL:
            raise step_too_small(evaluation, c.t, c.h, c.error, method.scaled)
        if error is None:  # of several cases
            self.evaluator.solver.slots.interrupted()
            error = not_followed(c.t)
        if status == NOT_EVALUATED and started:
            assert isinstance(error, AnalysisError)
            raise not_evaluated(error, c.t, c.h, c.reductions) from error
        raise error

    # -- called by C ----------------------------------------------------------------------------------------------
    def _ask(self, evaluation: Evaluation, t: float, y: int, out: int | None) -> int:
        """Answer C with a derivative that it cannot compute, or look at a step for it."""
        if out is None:
            return self._seen_closer(t, y)
        return self._answered(evaluation.statistics, partial(self._derivative, evaluation), t, y, out)

    def _derivative(self, evaluation: Evaluation, t: float, y: int, out: int) -> None:
        self.evaluator.solver.slots.interrupted()
        n = self.shape[0]
        vector(out, n)[:] = evaluation.rhs(t, vector(y, n))

    def _answered(self, counted: IntegrationStatistics, answer: Callable[..., None], *question: Any) -> int:
        """Let a question of C be answered, and C count the derivatives that this takes: it knows at which output."""
        before = counted.n_rhs
        try:
            answer(*question)
        except AnalysisError as error:
            self.error = error
            return 1
        except BaseException as error:  # nothing may pass through C
            self.error = error
            return 2
        finally:
            self.c.n_rhs += counted.n_rhs - before
            counted.n_rhs = before
        return 0

    def _seen_closer(self, t: float, y: int) -> int:
        """Look at a step for C."""
        c = self.c
        try:
            before = None
            if self.monitor.look != ALWAYS:
                first = max(0, c.recorded - self.monitor.capacity)
                before = [self._seen(k) for k in range(first, c.recorded - 1)]
            c.peak, c.entered, seen = self.monitor.closer(t, vector(y, self.shape[0]).copy(), c.peak, before)
            if seen is None and not self.evaluator.state.c.known:
                c.recorded -= 1
            elif seen is not None:
                self._record(c.recorded - 1, seen)
        except BaseException as error:
            self.error = error
            return 2
        return 0

    def _record(self, k: int, seen: Accepted) -> None:
        at = seen.at
        row = self.records[k % len(self.records)]
        row[:] = np.concatenate(((at.t, seen.sign, seen.size, 1.0), seen.y, at.x, at.xd, at.xdd, at.e))

    def _seen(self, k: int) -> Accepted:
        """A recorded step."""
        n, nx = self.shape
        row = self.records[k % len(self.records)].copy()
        x, xd, xdd = row[4 + n : 4 + n + 3 * nx].reshape(3, nx)
        return Accepted(row[4 : 4 + n], Moving(float(row[0]), x, xd, xdd, row[4 + n + 3 * nx :]), row[1], row[2])

    def _last(self, k: int) -> list[Accepted]:
        """The last k steps; only those behind the last one that is not known."""
        recorded, found = self.c.recorded, []
        for i in range(recorded - 1, max(-1, recorded - 1 - min(k, len(self.records))), -1):
            if not self.records[i % len(self.records), 3]:
                break
            found.append(self._seen(i))
        return found[::-1]
