"""The method that chooses itself: Adams (code 0), and Radau IIA of order 9 where a vibration of the model that is
faster than its motion limits the steps.

An undamped vibration need not be excited to do so: what rounding and errors leave of it stays at the size of the
tolerance of a step, and the error control keeps h omega below one (Adams methods of order 2 to 12 are stable on hardly
more than a part of that). Radau IIA passes over it. The largest omega is found by power iteration with differences of
F,

    dF_u/dq w -> w,  omega^2 = |dF_u/dq w| / |w|,      and likewise the decay c = |dF_u/du w| / |w|,

q positions, u their rates, after 100, 200, 400 ... accepted steps; the same quotients of the way since the look before,
w = q - q_before, say how fast the motion is: present rates would hold the vibration itself. Where h omega is above
FAST, omega SLOWER times that of the motion, and enough steps of Adams are ahead, the other code is tried. It stays when
its steps are GAIN times as long; when the vibration is the motion itself they are not, and Adams goes on. It also goes
on when the steps of Radau become shorter than LEFT of that later.

So what is not stiff is computed as by code 0, step by step, and a model that is asked in vain loses less than the part
LOST: a trial of TRIAL steps costs less than TRIAL GAIN of Adams, and that many over LOST have to be ahead for each
trial that has been made (12,000 with Adams in C, 4,000 without, the first time). Looks cost less than the part SEEN.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from itertools import islice
from math import sqrt
from typing import Any

import numpy as np

from spacar.errors import AnalysisError

from .adams import Adams
from .problem import Evaluation, Step, Tolerance
from .radau import Radau

FIRST_LOOK = 100  # accepted steps
FAST = 0.1  # h omega above which the vibration may limit the steps
# Radau takes omega h up to about 3 of what it follows, Adams up to about 0.8 or, with tight tolerances, 0.3: its steps
# cannot be longer by more than ten times the frequency of the vibration over that of the motion.
SLOWER = 4.0
TRIAL, LAST = 40, 10  # steps of Radau that are tried, of these the last count
# How many times longer the steps of Radau have to be, Adams in C or not. One of them costs 29 to 16, 6.6 to 4.8 times
# as much as one of Adams (processor time, states of 8 to 128 components); chosen above that, as it has to pay.
GAIN = {True: 30.0, False: 10.0}
LOST = 0.1  # part of the steps ahead that trials in vain may cost
WATCHED, LEFT = 100, 0.5  # steps of Radau over which their mean is watched, and the part of GAIN below which it is left
# A look costs at most LOOK / n steps of Adams in C, or OF_PYTHON without; SEEN: the part of those ahead that looks may
# cost.
LOOK, OF_PYTHON, SEEN = 3000.0, 10.0, 0.02
ITERATIONS, SETTLED = 10, 0.1  # of the power method, or its last relative change: what counts is the size of omega
DIFFERENCE = 1e-7  # of positions and rates: far above what is left of a position, small against its curvature
Rate = Callable[[float, np.ndarray], np.ndarray]
Loop = Callable[[Any, bool], Callable[[float, np.ndarray, float, float], Iterator[Step]]]


class Automatic:
    """Steps of code 0 and, where that pays, of 595.

    Two more members of a problem are used if present: `beside()` gives F(t, y) to rounding for the differences, which
    leaves no trace in the problem, and `switched(t, code, omega)` is called at every change; omega is given when 595 is
    kept.
    """

    passes_start = Adams.passes_start

    def __init__(self, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        self.evaluation, self.n, self.tolerance = evaluation, n, tolerance
        self.explicit = Adams(evaluation, n, tolerance)
        self.implicit: Radau | None = None
        self.stays = False
        marched = evaluation.march is not None
        self.gain = GAIN[marched]
        self.price = LOOK / n if marched else OF_PYTHON  # of a look
        self.looks = self.trials = 0
        self.done = 0  # accepted steps of Adams
        self.look = FIRST_LOOK if evaluation.has_jacobian else 0
        self.omega = self.tried_at = self.size = 0.0
        self.seen = np.zeros(n)  # state of the last look

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
        last, before, self.seen = t, counted.n_steps, y.copy()
        self._halt()
        for step in self.explicit.steps(t, y, t_end, h):
            yield step
            made = counted.n_steps - before
            if self.look and self.done + made >= self.look:
                size = (step.t - last) / made
                self.done, last, before = self.done + made, step.t, counted.n_steps
                self.look = 2 * self.done
                self._halt()
                if step.t < t_end and self._limited(step.t, step.y, size, t_end):
                    self.size, self.tried_at, self.trials = size, step.t, self.trials + 1
                    self.implicit = Radau(5, self.evaluation, self.n, self.tolerance)
                    self._tell(step.t, 595)
                    return
                self.seen = step.y.copy()

    def _halt(self) -> None:
        """Let outputs be passed until the next look."""
        if self.look:
            self.evaluation.halt = self.evaluation.statistics.n_steps + self.look - self.done

    def _implicit(self, one_step: Loop, t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
        """Steps of 595 up to the end, or back to Adams: after a trial, or when they have become short."""
        sizes: deque[float] = deque(maxlen=WATCHED)
        for step in one_step(self.implicit, True)(t, y, t_end, h):
            sizes.append(step.t - t)
            t = step.t
            if t >= t_end and not self.stays:  # the trial was enough; nobody asks for more after the last step
                self.stays = True
                self._tell(self.tried_at, 595, self.omega)
            yield step
            if t >= t_end:
                return
            if not self.stays and len(sizes) == TRIAL:
                self.stays = sum(islice(sizes, TRIAL - LAST, None)) > self.gain * LAST * self.size
                if not self.stays:
                    break
                self._tell(self.tried_at, 595, self.omega)
            elif len(sizes) == WATCHED:
                self.stays = sum(sizes) > LEFT * self.gain * WATCHED * self.size
                if not self.stays:
                    break
        else:
            return
        self.implicit = None
        self._tell(t, 0)

    def _tell(self, t: float, code: int, omega: float | None = None) -> None:
        switched: Callable[..., None] | None = getattr(self.evaluation.problem, "switched", None)
        if switched is not None:
            switched(t, code, omega)

    def _limited(self, t: float, y: np.ndarray, h: float, t_end: float) -> bool:
        """May a vibration limit the steps, and is there enough ahead?"""
        ahead = (t_end - t) / h
        if LOST * ahead < (self.trials + 1) * TRIAL * self.gain or SEEN * ahead < (self.looks + 1) * self.price:
            return False
        self.looks += 1
        try:
            self.omega, motion = self._frequencies(t, y)
        except AnalysisError:
            return False  # next to a place that cannot be evaluated: no time to change
        return h * self.omega > FAST and self.omega > SLOWER * motion

    def _frequencies(self, t: float, y: np.ndarray) -> tuple[float, float]:
        """Highest frequency, or largest rate of decay, and that of the motion [1/s], at the end of the last step."""
        problem, counted = self.evaluation.problem, self.evaluation.statistics
        beside: Callable[[], Rate] | None = getattr(problem, "beside", None)
        exact: Rate = beside() if beside is not None else problem.rhs
        f = exact(t, y).copy()
        n = problem.n_positions
        rates = len(y) - n
        highest = motion = 0.0

        def changed(part: slice, w: np.ndarray) -> tuple[np.ndarray, float]:
            """dF_u w in the size of w, and |dF_u w| / |w|."""
            length = sqrt(float(w @ w))
            if not length > 0.0:
                return w, 0.0
            moved = y.copy()
            size = DIFFERENCE * (1.0 + sqrt(float(y[part] @ y[part])))
            moved[part] += (size / length) * w
            change = (exact(t, moved) - f)[n:]
            counted.n_rhs += 1
            return change, sqrt(float(change @ change)) / size

        for first, power in ((0, 0.5), (n, 1.0)):
            part = slice(first, first + rates)
            w = np.cos(np.arange(1.0, rates + 1.0))  # a vector that is nothing in particular
            size = 0.0
            for _ in range(ITERATIONS):
                before = size
                w, size = changed(part, w)
                if abs(size - before) <= SETTLED * size:
                    break
            highest = max(highest, size**power)
            motion = max(motion, changed(part, (y - self.seen)[:rates])[1] ** power)
        return highest, motion


def _nowhere(t: float) -> np.ndarray:
    raise AssertionError("no step yet")
