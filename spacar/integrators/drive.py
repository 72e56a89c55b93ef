"""From an initial state to a stream of outputs: segments between discontinuities, fixed steps, dense output.

Fixed steps are shortened until an integer number of them fits between two outputs (or breaks), so fixed-step codes need
no interpolation. Variable steps are made by `steps` of a method, or by the loop of one-step codes.

Jumps of F that nobody has declared: seen at outputs, located, restarted.

Step control sees a jump only if an evaluation of a step falls behind it; a pulse between two evaluations is missed, and
an output inside it shows an acceleration that the motion does not have. So at every output inside a step the rate that
F gives for the interpolated state is compared with the derivative p' of the interpolation,

    d = |h (F(t, y(t)) - p'(t)) / weight|,   weight = absolute + relative |y|,  h the step,

which is about the error of the step over its tolerance where F is smooth. Above SUSPECT the last time that agrees (of
the step and its outputs) and the first that does not are halved down to rounding. When F changes there by CHANGED of
the difference it is a jump: the step ends before it, and a new start is made behind it. When it does not, d is error of
the interpolation (a vibration that the method passes over), and only more than MORE times as much is suspect from then
on, so that smooth motions are located a few times at most. Steps of Adams in C are compared there (output_block.c).
"""

from collections.abc import Iterator, Sequence
from functools import cached_property, partial
from itertools import pairwise
from math import ceil, sqrt
from operator import sub
from typing import Any

import numpy as np

from spacar.arrays import EPS
from spacar.errors import AnalysisError, UsageError

from .failures import STIFF_ADVICE, not_evaluated
from .methods import AUTOMATIC, METHODS, method
from .one_step import one_step
from .problem import Counts, Evaluation, Output, Problem, Rate, Step, Tolerance
from .times import EvenTimes

DEFAULT_MAX_STEPS = 1_000_000
# A fixed step not given: this part of the output step.
STEPS_PER_OUTPUT = 10
# codes of one step and one order with an error estimate of the state
SINGLE_STEP = tuple(m.code for m in METHODS.values() if m.variable_step and m.order and m.code != 225)
SUSPECT = 100.0  # a hundredth of ERROR is the tolerance of a step of mechanisms: an error of ERROR
CHANGED = 0.5
MORE = 10.0
DIFFERENCE = 1e-4  # of the step, for p': far above rounding of y, far below its curvature
Segment = tuple[float, float, float, float]  # start, end, first time, last time of evaluation [s]


def integrate(
    problem: Problem, y0: np.ndarray, times: Sequence[float] | np.ndarray, code: int = 0,
    atol: float | np.ndarray = 1e-5, rtol: float = 1e-4, step: float | None = None,
    max_steps: int = DEFAULT_MAX_STEPS, breaks: Sequence[float] = (),
) -> Iterator[Output]:  # fmt: skip
    """Integrates from times[0] and yields the state at every time of `times`, the first included.

    y0        initial state (positions, velocities), shape (n,)
    times     output times in s, increasing, at least two; the problem is never evaluated outside of them
    code      a key of METHODS
    atol      absolute error, of each component (n,) or of all; for 410, 420, 430 the tolerance of the Newton
              iteration; > 0
    rtol      relative error of the variable-step codes, >= 0
    step      step of fixed-step codes (default a tenth of the output step), first step of the others, in s
    max_steps largest number of steps between two outputs
    breaks    times of discontinuities of F: a step ends and a new start is made at each; the values used on
              either side are those four rounding units of the time away from it

    Raises UsageError for wrong arguments and AnalysisError (codes `integrator.*`, or the code of the error raised by
    the problem) when the integration fails. The arguments are checked at the call, not at the first output.
    """
    row = method(code)
    state = np.array(y0, dtype=float)
    output_times = times if isinstance(times, EvenTimes) else np.asarray(times, dtype=float)
    absolute = float(atol) if not np.ndim(atol) else np.array(atol, float)
    _check(state, output_times, absolute, rtol, step)
    first, last = float(output_times[0]), float(output_times[-1])
    if row.needs_jacobian and problem.jacobian is None:
        raise UsageError(f"INTEGRAT: {row.name} needs the Jacobian of the problem", "integrator.jacobian")
    evaluation = Evaluation(problem, first, last)
    evaluation.times = output_times
    if row.code == AUTOMATIC and problem.jacobian is None:
        row = METHODS[0]  # nothing to change to
    integrator = row.build(evaluation, len(state), Tolerance(absolute, float(rtol)))
    segments = _segments(first, last, breaks)
    loop = _variable if row.variable_step else _fixed
    return _outputs(loop(integrator, evaluation, state, segments, step), state, evaluation, max_steps)


def steps(
    problem: Problem, start: float, y: np.ndarray, end: float, window: tuple[float, float], code: int,
    tolerance: Tolerance, first: float | None = None, longest: float = float("inf"),
) -> Iterator[Step]:  # fmt: skip
    """The accepted steps of a variable one-step code through one smooth piece, for those who look into every step.

    start, end  of the piece [s];  window  times between which the problem is evaluated;  y (n,) state at its start
    code        155, 853, 553 ...;  tolerance  of a step
    first       size of the first step, None: estimated;  longest  step allowed [s]

    Raises UsageError for a code with fixed steps or of variable order, AnalysisError as `integrate`.
    """
    row = method(code)
    if row.code not in SINGLE_STEP:
        known = ", ".join(map(str, SINGLE_STEP))
        raise UsageError(f"method {code} cannot be used here; choose {known}", "integrator.code")
    integrator = row.build(Evaluation(problem, *window), len(y), tolerance)
    size = end - start if first is None else min(first, end - start)
    return one_step(integrator, start, y, end, size, first is None, longest)


def _check(
    y0: np.ndarray, times: np.ndarray | EvenTimes, atol: float | np.ndarray, rtol: float, step: float | None
) -> None:
    """Raises UsageError that says what is wrong with the arguments of `integrate`."""
    if y0.ndim != 1 or not len(y0) or not np.isfinite(y0).all():
        raise UsageError("the initial state must be a non-empty vector of finite numbers", "integrator.state")
    if not isinstance(times, EvenTimes):  # which has checked its times when it was made
        if times.ndim != 1 or len(times) < 2 or not np.isfinite(times).all():
            text = "the integration needs a start time and at least one later output time"
            raise UsageError(text, "integrator.times")
        bad = np.flatnonzero(np.diff(times) <= 0.0)
        if len(bad):
            a, b = times[bad[0]], times[bad[0] + 1]
            raise UsageError(f"output times must increase: {b:.9g} s follows {a:.9g} s", "integrator.times")
    positive = atol > 0.0 if isinstance(atol, float) else atol.shape == y0.shape and (atol > 0.0).all()
    if not (positive and rtol >= 0.0):
        text = f"the absolute error must be positive and the relative one not negative, not {atol} and {rtol}"
        raise UsageError(f"ERROR: {text}", "integrator.tolerance")
    if step is not None and not step > 0.0:
        raise UsageError(f"INTEGRAT: the step size must be positive, not {step}", "integrator.step")


def _segments(first: float, last: float, breaks: Sequence[float]) -> list[Segment]:
    """(start, end, first time, last time of evaluation) of the smooth pieces of the interval."""
    shift = 4.0 * EPS * max(abs(first), abs(last), last - first)
    inner: list[float] = []
    for b in sorted(map(float, breaks)):
        if min(b - first, last - b) > 2.0 * shift and (not inner or b - inner[-1] > 4.0 * shift):
            inner.append(b)
    at_first, at_last = (any(abs(b - t) <= 2.0 * shift for b in breaks) for t in (first, last))
    ends = [first, *inner, last]
    return [
        (a, b, a + shift if i or at_first else a, b - shift if i < len(inner) or at_last else b)
        for i, (a, b) in enumerate(pairwise(ends))
    ]


def _outputs(steps: Iterator[Step], y0: np.ndarray, evaluation: Evaluation, max_steps: int) -> Iterator[Output]:
    """Dense output from a stream of steps; y0 (n,): state at the first time."""
    statistics, times = evaluation.statistics, evaluation.times
    yield Output(float(times[0]), y0.copy(), Counts())
    i, n = 1, len(times)
    before = statistics.counts()
    step_start, limit = evaluation.first, max_steps
    for t, y, interpolate, _, passed in steps:
        for outputs in passed or ():
            if outputs.begun != before:
                outputs.work[0] += np.subtract(outputs.begun, before)
            now = outputs.now
            yield Output(outputs.t, outputs.y, Counts(*map(sub, now, before)), outputs)
            before, limit = now, now[0] + max_steps
            i += len(outputs.work)
        while passed is None and i < n and (at := float(times[i])) <= t:
            result = y.copy() if at == t else interpolate(at)
            now = statistics.counts()
            yield Output(at, result, Counts(*map(sub, now, before)))
            before, limit = now, now[0] + max_steps
            i += 1
        if i == n:
            return
        if statistics.n_steps >= limit:
            raise AnalysisError(
                f"more than {max_steps} integration steps between two output times at t = {t:.9g} s "
                f"(step size {t - step_start:.3g} s). {STIFF_ADVICE}",
                "integrator.too-many-steps", t=t, step=t - step_start,
            )  # fmt: skip
        step_start = t


def _variable(
    integrator: Any, evaluation: Evaluation, y0: np.ndarray, segments: list[Segment], step: float | None
) -> Iterator[Step]:
    """Steps of a variable-step code through all segments."""
    run = integrator.steps if hasattr(integrator, "steps") else partial(one_step, integrator, estimate=step is None)
    y = y0.copy()
    # Nothing is known beyond the first output: a longer first step could jump over a short pulse of an input.
    h = step if step is not None else float(evaluation.times[1]) - evaluation.first
    jumps = Jumps(evaluation, integrator.tolerance) if evaluation.problem.may_jump else None
    for begin, end, evaluation.first, evaluation.last in segments:
        start = begin
        while True:
            t, before, size, jump = start, 0.0, 0.0, None
            for taken in run(start, y, end, min(h, end - start)):
                before, size = taken.sizes or (size, taken.t - t)
                if jumps is not None and (jump := jumps.within(taken.t - size, taken)) is not None:
                    taken = Step(jump[0], taken.interpolate(jump[0]), taken.interpolate, None, taken.passed)
                t = taken.t
                yield taken
                if jump is not None:
                    break
            # After a break not longer than before it; the last step may have been shortened to end there.
            y, h = taken.y.copy(), max(before, size)
            if jump is None:
                break
            start = evaluation.first = jump[1]


def _fixed(
    integrator: Any, evaluation: Evaluation, y0: np.ndarray, segments: list[Segment], step: float | None
) -> Iterator[Step]:
    """Equal steps from output to output and from break to break."""
    y, times = y0.copy(), evaluation.times
    i = 1
    for start, end, evaluation.first, evaluation.last in segments:
        integrator.start(start, y)
        a = start
        while a < end:
            wanted = step if step is not None else float(times[i] - times[i - 1]) / STEPS_PER_OUTPUT
            b = min(float(times[i]), end)
            n = max(1, ceil((b - a) / wanted - 1e-9))
            h = (b - a) / n
            for j in range(n):
                t = a + j * h
                try:
                    integrator.fixed(t, h, y)
                except AnalysisError as cause:
                    if cause.code.startswith("integrator.") and cause.code != "integrator.not-finite":
                        raise
                    raise not_evaluated(cause, t, h) from cause
                y = integrator.y_new.copy()
                t = b if j == n - 1 else a + (j + 1) * h
                evaluation.step_accepted(t, y)
                yield Step(t, y, _never)
            a = b
            if b == times[i]:
                i += 1


def _never(t: float) -> np.ndarray:
    raise AssertionError(f"a fixed-step code has an output inside a step, t = {t}")


class Jumps:
    """Looks at the steps of one integration with outputs."""

    def __init__(self, evaluation: Evaluation, tolerance: Tolerance) -> None:
        self.evaluation, self.times, self.tolerance = evaluation, evaluation.times, tolerance
        evaluation.suspect = SUSPECT
        self.next = 1  # output

    @cached_property
    def rhs_for_differences(self) -> Rate:
        return self.evaluation.problem.rhs_for_differences()

    def within(self, before: float, step: Step) -> tuple[float, float] | None:
        """The times before and behind the first jump that an output in the step from `before` shows, None: none."""
        self.before, self.step = before, step
        if step.passed is not None:
            self.next += sum(len(outputs.work) for outputs in step.passed)
            return self._seen(before) if self.evaluation.suspected else None
        good = before
        while self.next < len(self.times) and (at := float(self.times[self.next])) < step.t:
            if at > before:
                found = self._seen(good)
                if found is not None:
                    return found
                good = at
            self.next += 1
        return None

    def _seen(self, good: float) -> tuple[float, float] | None:
        """The same at the next output, where `good` is the last time that agrees."""
        at = float(self.times[self.next])
        difference = self._difference(at)
        if difference is None:
            return None
        first = self.evaluation.problem.n_positions
        weight = self.tolerance.absolute + self.tolerance.relative * np.abs(self.step.interpolate(at))
        scaled = (self.step.t - self.before) * difference / weight[first:]
        size = sqrt(float(scaled @ scaled))  # d
        if not size > self.evaluation.suspect and not self.evaluation.suspected:
            return None
        found = self._located(good, at)
        if found is None:
            self.evaluation.suspect = MORE * max(size, self.evaluation.suspect)
        return found

    def _difference(self, t: float) -> np.ndarray | None:
        """F - p' at a time inside the step; None where there is no F."""
        before, step = self.before, self.step
        h = step.t - before
        low, high = max(before, t - DIFFERENCE * h), min(step.t, t + DIFFERENCE * h)
        slope = (np.array(step.interpolate(high)) - step.interpolate(low)) / (high - low)
        first, window = self.evaluation.problem.n_positions, (self.evaluation.first, self.evaluation.last)
        try:
            rate = self.rhs_for_differences(min(max(t, window[0]), window[1]), step.interpolate(t))
            return np.asarray((rate - slope)[first:])
        except AnalysisError:
            return None

    def _located(self, good: float, bad: float) -> tuple[float, float] | None:
        """The jump between a time that agrees and one that does not, None when F is smooth there."""
        right, left = map(self._difference, (bad, good))
        if left is None or right is None:
            return None
        low, high, first = good, bad, np.linalg.norm(right)
        while high - low > 4.0 * EPS * max(abs(good), abs(bad)):
            middle = 0.5 * (low + high)
            now = self._difference(middle)
            if now is None:
                return None
            if np.linalg.norm(now - left) < np.linalg.norm(now - right):
                low, left = middle, now
            else:
                high, right = middle, now
        return (low, high) if np.linalg.norm(right - left) > CHANGED * first else None
