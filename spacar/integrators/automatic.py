"""The method that chooses itself: explicit Runge-Kutta 8(5,3), and Radau IIA of order 9 where a vibration of the
model that is faster than its motion limits the steps.

An undamped vibration need not be excited to do so: what rounding and errors leave of it stays at the size of the
tolerance of a step, and the error control keeps h omega near 1 (measured on crankfl with 2 to 16 elements: 0.9; the
limit of stability on the imaginary axis is 5.96). Radau IIA passes over it. The largest omega is found by power
iteration with differences of F,

    dF_u/dq w -> w,  omega^2 = |dF_u/dq w| / |w|,      and likewise the decay c = |dF_u/du w| / |w|,

q positions, u their rates, after 20, 40, 80, ... accepted steps. Above FAST the other code is tried for TRIAL steps,
if there are more than WORTH steps of the explicit one ahead. It stays when its steps are GAIN times as long; when
the vibration is the motion itself they are not, and the explicit code goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import sqrt
from typing import Any

import numpy as np

from spacar.errors import AnalysisError

from .problem import Evaluation, Step, Tolerance
from .radau import Radau
from .runge_kutta import DormandPrince853

FIRST_LOOK = 20  # accepted steps
FAST = 0.4  # h omega above which the vibration may limit the steps
WORTH = 1000  # steps ahead below which a Jacobian and a new start do not pay
TRIAL, LAST = 40, 10  # steps of Radau that are tried, of these the last count
GAIN = 8.0  # a step of Radau, its share of Jacobians and factors included, costs as much as some steps of 853
ITERATIONS = 10  # of the power method: what counts is the size of omega
DIFFERENCE = 1e-7  # of positions and rates: far above what is left of a position, small against its curvature
Loop = Callable[[Any, bool], Callable[[float, np.ndarray, float, float], Iterator[Step]]]


class Automatic:
    """Steps of 853 and, where that pays, of 595.

    Two more members of a problem are used if present: `exact(t, y)`, F to rounding for the differences, and
    `switched(t, code, omega)`, called at every change; omega is given when the change is a final one.
    """

    def __init__(self, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        self.evaluation, self.n, self.tolerance = evaluation, n, tolerance
        evaluation.march = None  # every step is looked at
        self.explicit = DormandPrince853(evaluation, n, tolerance)
        self.implicit: Radau | None = None
        self.stays = False
        self.done = 0  # accepted steps of 853
        self.look = FIRST_LOOK if evaluation.has_jacobian else 0
        self.omega = self.tried_at = self.size = 0.0

    def loop(self, one_step: Loop, estimate: bool) -> Callable[[float, np.ndarray, float, float], Iterator[Step]]:
        """The step loop; `one_step` makes that of a code, and says whether it estimates its first step."""

        def run(t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
            first = estimate
            while True:
                part = self._implicit if self.implicit is not None else self._explicit
                end = Step(t, y, _nowhere)
                for step in part(one_step, first, t, y, t_end, h):
                    end = step
                    yield step
                t, y = end.t, end.y.copy()
                if t >= t_end:
                    return
                first, h = (True, t_end - t) if self.implicit is not None else (False, min(self.size, t_end - t))

        return run

    def _explicit(self, one_step: Loop, first: bool, t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
        """Steps of 853 up to the end or to a change."""
        for step in one_step(self.explicit, first)(t, y, t_end, h):
            size, t = step.t - t, step.t
            yield step
            self.done += 1
            if self.done == self.look:
                self.look *= 2
                if t < t_end and self._limited(t, size, t_end):
                    self.size, self.tried_at = size, t
                    self.implicit = Radau(5, self.evaluation, self.n, self.tolerance)
                    self._tell(t, 595)
                    return

    def _implicit(self, one_step: Loop, first: bool, t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
        """Steps of 595 up to the end, or back to 853 after a trial."""
        sizes: list[float] = []
        for step in one_step(self.implicit, first)(t, y, t_end, h):
            sizes.append(step.t - t)
            t = step.t
            yield step
            if not self.stays and len(sizes) == TRIAL and t < t_end:
                self.stays = sum(sizes[-LAST:]) > GAIN * LAST * self.size
                if not self.stays:
                    self.implicit = None
                    self._tell(t, 853)
                    return
                self._tell(self.tried_at, 595, self.omega)

    def _tell(self, t: float, code: int, omega: float | None = None) -> None:
        switched: Callable[..., None] | None = getattr(self.evaluation.problem, "switched", None)
        if switched is not None:
            switched(t, code, omega)

    def _limited(self, t: float, h: float, t_end: float) -> bool:
        """May a vibration limit the steps, and is there enough ahead?"""
        if (t_end - t) / h < WORTH:
            return False
        try:
            self.omega = self._highest(t)
        except AnalysisError:
            return False  # next to a place that cannot be evaluated: no time to change
        return h * self.omega > FAST

    def _highest(self, t: float) -> float:
        """Highest frequency, or largest rate of decay [1/s], at the end of the last step."""
        y, exact = self.explicit.y_new, getattr(self.evaluation.problem, "exact", self.evaluation.problem.rhs)
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
