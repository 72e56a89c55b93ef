"""Jumps of F that nobody has declared: seen at outputs, located, restarted.

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

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np

from spacar.errors import AnalysisError

from .problem import Evaluation, Rate, Step, Tolerance

SUSPECT = 100.0  # a hundredth of ERROR is the tolerance of a step of mechanisms: an error of ERROR
CHANGED = 0.5
MORE = 10.0
DIFFERENCE = 1e-4  # of the step, for p': far above rounding of y, far below its curvature
EPS = float(np.finfo(float).eps)


class Jumps:
    """Looks at the steps of one integration with outputs at `times`."""

    def __init__(self, evaluation: Evaluation, times: Sequence[float] | np.ndarray, tolerance: Tolerance) -> None:
        self.evaluation, self.times, self.tolerance = evaluation, times, tolerance
        evaluation.suspect = SUSPECT
        self.next = 1  # output
        self.rhs_for_differences: Rate | None = None

    def within(self, before: float, step: Step) -> tuple[float, float] | None:
        """The times before and behind the first jump that an output in the step from `before` shows, None: none."""
        if step.passed is not None:
            self.next += sum(len(outputs.work) for outputs in step.passed)
            return self._seen(before, before, step) if self.evaluation.suspected else None
        good = before
        while self.next < len(self.times) and (at := float(self.times[self.next])) < step.t:
            if at > before:
                found = self._seen(good, before, step)
                if found is not None:
                    return found
                good = at
            self.next += 1
        return None

    def _seen(self, good: float, before: float, step: Step) -> tuple[float, float] | None:
        """The same at the next output, where `good` is the last time that agrees."""
        at = float(self.times[self.next])
        difference = self._difference(at, before, step)
        if difference is None:
            return None
        size = self._size(difference, at, before, step)
        if not size > self.evaluation.suspect and not self.evaluation.suspected:
            return None
        found = self._located(good, at, before, step)
        if found is None:
            self.evaluation.suspect = MORE * max(size, self.evaluation.suspect)
        return found

    def _difference(self, t: float, before: float, step: Step) -> np.ndarray | None:
        """F - p' at a time inside the step; None where there is no F."""
        h = step.t - before
        low, high = max(before, t - DIFFERENCE * h), min(step.t, t + DIFFERENCE * h)
        slope = (np.array(step.interpolate(high)) - step.interpolate(low)) / (high - low)
        if self.rhs_for_differences is None:
            self.rhs_for_differences = self.evaluation.problem.rhs_for_differences()
        first, window = self.evaluation.problem.n_positions, (self.evaluation.first, self.evaluation.last)
        try:
            rate = self.rhs_for_differences(min(max(t, window[0]), window[1]), step.interpolate(t))
            return np.asarray((rate - slope)[first:])
        except AnalysisError:
            return None

    def _size(self, difference: np.ndarray, t: float, before: float, step: Step) -> float:
        """d."""
        weight = self.tolerance.absolute + self.tolerance.relative * np.abs(step.interpolate(t))
        scaled = (step.t - before) * difference / weight[self.evaluation.problem.n_positions :]
        return sqrt(float(scaled @ scaled))

    def _located(self, good: float, bad: float, before: float, step: Step) -> tuple[float, float] | None:
        """The jump between a time that agrees and one that does not, None when F is smooth there."""
        first = self._difference(bad, before, step)
        resolution = 4.0 * EPS * max(abs(good), abs(bad))
        low, high, left, right = good, bad, self._difference(good, before, step), first
        while left is not None and right is not None and high - low > resolution:
            middle = 0.5 * (low + high)
            now = self._difference(middle, before, step)
            if now is None:
                return None
            if np.linalg.norm(now - left) < np.linalg.norm(now - right):
                low, left = middle, now
            else:
                high, right = middle, now
        if first is None or left is None or right is None:
            return None
        return (low, high) if np.linalg.norm(right - left) > CHANGED * np.linalg.norm(first) else None
