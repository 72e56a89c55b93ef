"""The method that chooses itself: Adams (code 0), and Radau IIA of order 9 where a vibration of the model that is
faster than its motion limits the steps.

An undamped vibration need not be excited to do so: what rounding and errors leave of it stays at the size of the
tolerance of a step, and the error control keeps h omega below one (Adams methods of order 2 to 12 are stable on hardly
more than a part of that). Radau IIA passes over it. The largest omega is found by power iteration with differences of
F,

    dF_u/dq w -> w,  omega^2 = |dF_u/dq w| / |w|,      and likewise the decay c = |dF_u/du w| / |w|,

q positions, u their rates, after 100, 200, 400, ... accepted steps. Above FAST the other code is tried, if there are
enough steps of Adams ahead. It stays when its steps are GAIN times as long; when the vibration is the motion
itself they are not, and Adams goes on. So what is not stiff is computed as by code 0, step by step, and a model that
is asked in vain loses less than the part LOST: a trial of TRIAL steps costs less than TRIAL GAIN of Adams, and that
many over LOST have to be ahead (16,000 with Adams in C, else 4,000).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import sqrt
from typing import Any

import numpy as np

from spacar.errors import AnalysisError

from .adams import Adams
from .problem import Evaluation, Step, Tolerance
from .radau import Radau

FIRST_LOOK = 100  # accepted steps
FAST = 0.1  # h omega above which the vibration may limit the steps
TRIAL, LAST = 40, 10  # steps of Radau that are tried, of these the last count
# How many times longer the steps of Radau have to be, Adams in C or not. One of them costs 29 to 23, 6.6 to 4.8 times
# as much as one of Adams (processor time, cantilevers of 4 to 32 beams); chosen above that, as it has to pay.
GAIN = {True: 40.0, False: 10.0}
LOST = 0.1  # part of the steps ahead that a trial in vain may cost
ITERATIONS = 10  # of the power method: what counts is the size of omega
DIFFERENCE = 1e-7  # of positions and rates: far above what is left of a position, small against its curvature
Loop = Callable[[Any, bool], Callable[[float, np.ndarray, float, float], Iterator[Step]]]


class Automatic:
    """Steps of code 0 and, where that pays, of 595.

    Two more members of a problem are used if present: `exact(t, y)`, F to rounding for the differences, and
    `switched(t, code, omega)`, called at every change; omega is given when the change is a final one.
    """

    def __init__(self, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        self.evaluation, self.n, self.tolerance = evaluation, n, tolerance
        self.explicit = Adams(evaluation, n, tolerance)
        self.implicit: Radau | None = None
        self.stays = False
        self.gain = GAIN[evaluation.march is not None]
        self.worth = TRIAL * self.gain / LOST  # steps ahead
        self.done = 0  # accepted steps of Adams
        self.look = FIRST_LOOK if evaluation.has_jacobian else 0
        self.omega = self.tried_at = self.size = 0.0

    def loop(self, one_step: Loop) -> Callable[[float, np.ndarray, float, float], Iterator[Step]]:
        """The step loop; `one_step` makes that of Radau, and says whether it estimates its first step."""

        def run(t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
            while True:
                radau = self.implicit is not None
                part = self._implicit(one_step, t, y, t_end, h) if radau else self._explicit(t, y, t_end, h)
                end = Step(t, y, _nowhere)
                for step in part:
                    end = step
                    yield step
                t, y, h = end.t, end.y.copy(), t_end - end.t
                if t >= t_end:
                    return
                if self.implicit is None:
                    h = min(self.size, h)

        return run

    def _explicit(self, t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
        """Steps of Adams up to the end or to a change."""
        counted = self.evaluation.statistics
        last, before = t, counted.n_steps
        for step in self.explicit.steps(t, y, t_end, h):
            yield step
            made = counted.n_steps - before
            if self.look and self.done + made >= self.look:
                size = (step.t - last) / made
                self.done, last, before = self.done + made, step.t, counted.n_steps
                self.look = 2 * self.done
                if step.t < t_end and self._limited(step.t, step.y, size, t_end):
                    self.size, self.tried_at = size, step.t
                    self.implicit = Radau(5, self.evaluation, self.n, self.tolerance)
                    self._tell(step.t, 595)
                    return

    def _implicit(self, one_step: Loop, t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
        """Steps of 595 up to the end, or back to Adams after a trial."""
        sizes: list[float] = []
        for step in one_step(self.implicit, True)(t, y, t_end, h):
            sizes.append(step.t - t)
            t = step.t
            yield step
            if not self.stays and len(sizes) == TRIAL and t < t_end:
                self.stays = sum(sizes[-LAST:]) > self.gain * LAST * self.size
                if not self.stays:
                    self.implicit = None
                    self._tell(t, 0)
                    return
                self._tell(self.tried_at, 595, self.omega)

    def _tell(self, t: float, code: int, omega: float | None = None) -> None:
        switched: Callable[..., None] | None = getattr(self.evaluation.problem, "switched", None)
        if switched is not None:
            switched(t, code, omega)

    def _limited(self, t: float, y: np.ndarray, h: float, t_end: float) -> bool:
        """May a vibration limit the steps, and is there enough ahead?"""
        if (t_end - t) / h < self.worth:
            return False
        try:
            self.omega = self._highest(t, y)
        except AnalysisError:
            return False  # next to a place that cannot be evaluated: no time to change
        return h * self.omega > FAST

    def _highest(self, t: float, y: np.ndarray) -> float:
        """Highest frequency, or largest rate of decay [1/s], at the end of the last step."""
        exact = getattr(self.evaluation.problem, "exact", self.evaluation.problem.rhs)
        f = exact(t, y).copy()
        n = self.evaluation.problem.n_positions
        rates = len(y) - n
        largest = 0.0
        for first, power in ((0, 0.5), (n, 1.0)):
            part = slice(first, first + rates)
            w: np.ndarray = np.random.default_rng(1).standard_normal(rates)
            size = 0.0
            for _ in range(ITERATIONS):
                w *= DIFFERENCE * (1.0 + sqrt(float(y[part] @ y[part]))) / sqrt(float(w @ w))
                moved = y.copy()
                moved[part] += w
                change = (exact(t, moved) - f)[n:]
                self.evaluation.statistics.n_rhs += 1
                size = sqrt(float(change @ change) / float(w @ w))
                if not size > 0.0:
                    break
                w = change
            largest = max(largest, size**power)
        return largest


def _nowhere(t: float) -> np.ndarray:
    raise AssertionError("no step yet")
