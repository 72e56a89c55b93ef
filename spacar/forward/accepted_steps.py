"""The accepted steps of a motion: which of them are remembered, and what is watched after each.

Watched are half turns of nodes, the charts of those that may pass them, and the continuity of the motion at dead
points. Remembered are the steps from which outputs are placed and to which rejected steps go back.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.evaluator import Evaluator
from spacar.dynamics.limits import Limits
from spacar.dynamics.loaded_mechanism import ALWAYS, AT_DETERMINANTS, AT_VELOCITIES, NEVER, Accepted, Moving
from spacar.errors import AnalysisError, Report
from spacar.forward.charts import ChartWatch
from spacar.forward.continuity import FAR_APART, HALF, INSIDE, WIDE, Continuity
from spacar.frame import Frame
from spacar.integrators import METHODS
from spacar.kinematics.regularity import HalfTurns

FAR = 8  # steps between outputs beyond which an output is not placed from the one before
# Codes of errors that may be those of a dead point
ENDED = ("integrator.step-too-small", "integrator.too-many-steps", "integrator.newton", "position.no-convergence")
CAUSE = 0.1  # chosen: lambda0 of a node below which a dead point is its half turn, 11 degrees


def at_time(evaluator: Evaluator, t: float, y: Array) -> Frame:
    """The frame of a state; failures say the time."""
    try:
        return evaluator.frame(t, y)
    except AnalysisError as error:
        fail_at(t, error)


def fail_at(t: float, error: AnalysisError) -> NoReturn:
    """Raise the failure with its time; one that says it goes on with its own cause."""
    if "t" in error.data:
        raise error
    raise AnalysisError(f"at t = {t:.9g}: {error}", error.code, t=t, **error.data) from error


@dataclass(frozen=True)
class SingularityMonitor:
    """Half turns of nodes, the charts of those that may pass them, and the continuity of the motion at dead points."""

    evaluator: Evaluator
    half_turns: HalfTurns
    continuity: Continuity | None
    charts: ChartWatch | None

    def __call__(self, t: float, y: Array) -> None:
        if self.charts is not None:
            self.charts.check(t, y, self.evaluator.placement().x)
        if self.half_turns.nodes:
            self.half_turns.check(t, self.evaluator.placement().x)
        if self.continuity is not None:
            try:
                self.continuity.check(t, y)
            except AnalysisError as error:
                # A beam that is bent too far for one element is the cause rather than the choice of coordinates.
                Limits(self.evaluator, Report()).check(self.evaluator, at_time(self.evaluator, t, y))
                self.half_turns.check(t, self.evaluator.placement().x, CAUSE)
                fail_at(t, error)


def singularity_monitor(
    evaluator: Evaluator, report: Report, charts: ChartWatch | None = None
) -> SingularityMonitor | None:
    """What is watched after every accepted step; None where there is nothing."""
    mechanism, matrix = evaluator.model.mechanism, evaluator.position_matrix()
    half_turns = HalfTurns(mechanism.numbering, without=charts.chart.dependent if charts else ())
    settings = mechanism.settings
    resolved = not METHODS[settings.integrator].needs_jacobian
    errors = settings.atol, settings.rtol
    continuity = None
    if not (matrix.is_empty or matrix.regular_everywhere()):
        continuity = Continuity(evaluator, matrix, report, errors, resolved)
    if not half_turns.nodes and continuity is None and charts is None:
        return None
    return SingularityMonitor(evaluator, half_turns, continuity, charts)


class StepHistory:
    """The accepted steps of one motion that are remembered; of two at least, of more where continuity is watched.

    Outputs inside the last step are placed from the begin of that step. The output before may lie many turns earlier:
    the way from there would be long and could be another one. Where only a few steps lie between outputs, each output
    is placed from the one before: a determinant that changes its sign along this way tells of a dead point at which
    steps that are too long have turned back. `require_time` is `Run.require_time`.
    """

    def __init__(
        self, evaluator: Evaluator, watch: SingularityMonitor | None, require_time: Callable[[float | None], None]
    ) -> None:
        self.evaluator, self.watch, self.require_time = evaluator, watch, require_time
        self.continuity = None if watch is None else watch.continuity
        self.steps: deque[Accepted] = deque(maxlen=2) if self.continuity is None else self.continuity.steps
        self.elsewhere: Callable[[int], list[Accepted]] | None = None  # gives the last k steps that were made at a time
        self.begin: Moving | None = None  # of the last step, where steps are made one by one
        self.n = 0  # steps since the last output

    # -- of many steps at a time: `spacar.compiled.compiled_stepper.StepMonitor` -----------------------------------
    half, inside, wide, far = HALF, INSIDE, WIDE, FAR_APART

    @property
    def capacity(self) -> int:
        return self.steps.maxlen or 0

    @property
    def back(self) -> bool:
        return self.continuity is not None

    @property
    def look(self) -> int:
        """Which of them are looked at closer, see `spacar.forward.continuity`."""
        watch, c = self.watch, self.continuity
        if watch is not None and (watch.half_turns.nodes or watch.charts is not None):
            return ALWAYS
        if c is None:
            return NEVER
        return AT_DETERMINANTS if c.matrix.has_determinant else AT_VELOCITIES

    def closer(
        self, t: float, y: Array, peak: float, before: list[Accepted] | None
    ) -> tuple[float, bool, Accepted | None]:
        c = self.continuity
        if c is not None and before is not None:
            c.resume(before, peak)
        if self.watch is not None:
            self.watch(t, y)
        if c is None:
            return peak, False, None
        seen = c.steps[-1] if c.steps and not (before and c.steps[-1] is before[-1]) else None
        return c.peak, c.entered is not None, seen

    def passed(self, last: Callable[[int], list[Accepted]]) -> None:
        """Steps have been made; `last(k)` gives the last k of them."""
        self.elsewhere = last
        self.require_time(None)

    def _fetch(self) -> None:
        """Take over what was remembered elsewhere, before a step is made here."""
        if self.elsewhere is not None:
            steps = self.elsewhere(self.capacity)
            self.elsewhere = None
            if self.continuity is not None:
                self.continuity.resume(steps, max((p.size for p in steps), default=-np.inf))
            else:
                self.steps.clear()
                self.steps.extend(steps)

    def started(self, t: float, y: Array) -> Accepted | None:
        """Remember the start state, where the evaluator stands. Returns the last step, None when it is not known."""
        if not self.steps:
            self._keep(t, y)
        return self.steps[-1] if self.steps else None

    def _keep(self, t: float, y: Array) -> None:
        if self.continuity is not None:
            self.continuity.check(t, y)
            return
        at = self.evaluator.moving()
        if at is not None:
            self.steps.append(Accepted(y.copy(), at, 1.0, 0.0))

    def ended(self, error: AnalysisError) -> None:
        """Raises AnalysisError 'position.singular' where it is a dead point that has ended the integration so."""
        if self.continuity is not None and error.code in ENDED:
            self._fetch()
            self.continuity.ended(error)

    # -- of steps one by one ---------------------------------------------------------------------------------------
    def accepted(self, t: float, y: Array) -> None:
        self.require_time(t)
        self.n += 1
        self._fetch()
        self.begin = self.steps[-1].at if self.steps else None
        if self.continuity is None:
            self._keep(t, y)
        if self.watch is not None:
            self.watch(t, y)

    def rejected(self) -> None:
        """After a rejected step: its last stages may stand on another branch, which matters where it is watched."""
        if self.continuity is None:
            return
        self.evaluator.sampled()
        self._fetch()
        if self.steps:
            self.evaluator.resume(self.steps[-1].at)

    def lead(self, shown: Evaluator) -> None:
        """Let the evaluator of outputs go on from the begin of the last step, if its last output was long before it."""
        if self.n > FAR:
            begin = self.begin
            if self.elsewhere is not None:
                last = self.elsewhere(2)
                begin = last[0].at if len(last) == 2 else None
            if begin is not None:
                shown.resume(begin)
        self.n = 0
