"""The method that chooses itself: Adams (code 0), and Radau IIA of order 9 where a vibration of the model that is
faster than its motion limits the steps.

An undamped vibration need not be excited to do so: what rounding and errors leave of it stays at the size of the
tolerance of a step, and the error control keeps h omega below one (Adams methods of order 2 to 12 are stable on hardly
more than a part of that). Radau IIA passes over it. The largest omega is found by power iteration with differences of
F,

    dF_u/dq w -> w,  omega^2 = |dF_u/dq w| / |w|,      and likewise the decay c = |dF_u/du w| / |w|,

q positions, u their rates, after 100, 200, 400 ... accepted steps. How fast the motion is, say the first quotient of
the way since the look before, w = q - q_before (present rates would hold the vibration itself), and, beside decays, the
change of the rates in that time dt, |u - u_before| / (dt max |u|): what decays is over after some 1/c, whatever its
shape, and the rates that are left may lie in the direction of the decay itself. Where h omega is above FAST, omega
SLOWER times that of the motion, and enough steps of Adams are ahead, the other code is tried. It stays when its steps
are `gain` times as long; when the vibration is the motion itself they are not, and Adams goes on. It also goes on when
the steps of Radau become shorter than LEFT of that later. Old vibrations that have to be damped first let its steps
grow slowly: a trial of TRIAL steps goes on up to LONGEST_TRIAL while each LAST of them are GROWING times the ones
before, or PROMISING part of what has to be reached. Where no step of Adams is small enough, Radau is tried at once.

So what is not stiff is computed as by code 0, step by step, and a model that is asked in vain loses less than the part
LOST: what trials have cost and TRIAL more steps of Radau, over LOST, have to be ahead. Looks cost less than SEEN.

What a step of Radau costs in steps of Adams was counted (processor time of whole runs over accepted steps, chains of
trusses, planar and spatial beams; benchmarks/default_method.py): with equations in C (0.2 + 0.005 n) ms over
(1 + 0.4 n) us, n components of the state: 100 for n = 2, 57 for 8, 28 for 32, 19 for 64, and not less beyond, as its
factors grow with n^3; with those of NumPy 3.3 to 4.9, whatever n. A Jacobian takes 1.5 to 3.9 ms, n = 2 to 64.
"""

from __future__ import annotations

from collections import deque
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
# Radau takes omega h up to about 3 of what it follows, Adams up to about 0.8 or, with tight tolerances, 0.3: its steps
# cannot be longer by more than ten times the frequency of the vibration over that of the motion.
SLOWER = 4.0
TRIAL, LAST = 20, 10  # steps of Radau that are tried, of these the last count
LONGEST_TRIAL, GROWING, PROMISING = 160, 1.2, 0.4
C_GAIN, LEAST_C_GAIN, NUMPY_GAIN = 160.0, 18.0, 5.0  # C_GAIN / sqrt(n), at least; without C
JACOBIAN = {True: 8.0, False: 0.4}  # steps of Radau that one costs, with Adams in C or not
LOST = 0.2  # part of the steps ahead that trials in vain may cost
WATCHED, LEFT = 100, 0.5  # steps of Radau over which their mean is watched, and the part below which it is left
# A look costs at most LOOK / n steps of Adams in C (0.7 ms), or OF_PYTHON without; SEEN: the part of those ahead that
# looks may cost.
LOOK, OF_PYTHON, SEEN = 1200.0, 10.0, 0.03
ITERATIONS, SETTLED = 10, 0.1  # of the power method, or its last relative change: what counts is the size of omega
DIFFERENCE = 1e-7  # of positions and rates: far above what is left of a position, small against its curvature
Rate = Callable[[float, np.ndarray], np.ndarray]
Loop = Callable[[Any, bool], Callable[[float, np.ndarray, float, float], Iterator[Step]]]


class Automatic:
    """Steps of code 0 and, where that pays, of 595.

    Two more members of a problem are used if present: `rhs_for_differences()` gives F(t, y) to rounding for the
    differences, which leaves no trace in the problem, and `switched(t, code, omega)` is called at every change;
    omega is given when 595 is kept.
    """

    passes_start = Adams.passes_start

    def __init__(self, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        self.evaluation, self.n, self.tolerance = evaluation, n, tolerance
        self.explicit = Adams(evaluation, n, tolerance)
        self.implicit: Radau | None = None
        self.stays = False
        in_blocks = evaluation.take_steps is not None
        self.gain = max(LEAST_C_GAIN, C_GAIN / sqrt(n)) if in_blocks else NUMPY_GAIN
        self.of_jacobian = JACOBIAN[in_blocks]
        self.price = LOOK / n if in_blocks else OF_PYTHON  # of a look
        self.looks = 0
        self.lost = 0.0  # by trials in vain, in steps of Adams
        self.done = 0  # accepted steps of Adams
        self.look = FIRST_LOOK if evaluation.has_jacobian else 0
        self.omega = self.tried_at = self.size = 0.0
        self.seen, self.seen_at = np.zeros(n), 0.0  # state and time of the last look

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
        last, before, self.seen, self.seen_at = t, counted.n_steps, y.copy(), t
        self._halt()
        try:
            for step in self.explicit.steps(t, y, t_end, h):
                yield step
                made = counted.n_steps - before
                if self.look and self.done + made >= self.look:
                    size = (step.t - last) / made
                    self.done, last, before = self.done + made, step.t, counted.n_steps
                    self.look = 2 * self.done
                    self._halt()
                    if step.t < t_end and self._limited(step.t, step.y, size, t_end):
                        self._try(step.t, size)
                        return
                    self.seen, self.seen_at = step.y.copy(), step.t
        except AnalysisError as error:
            if error.code != "integrator.step-too-small" or not self.look:
                raise
            self.omega = 1.0 / error.data["step"]
            self._try(error.data["t"], error.data["step"])

    def _try(self, t: float, size: float) -> None:
        """Go on with Radau; `size` of the steps of Adams."""
        self.size, self.tried_at = size, t
        self.implicit = Radau(5, self.evaluation, self.n, self.tolerance)
        self._tell(t, 595)

    def _halt(self) -> None:
        """Let outputs be passed until the next look."""
        if self.look:
            self.evaluation.halt = self.evaluation.statistics.n_steps + self.look - self.done

    def _implicit(self, one_step: Loop, t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
        """Steps of 595 up to the end, or back to Adams: after a trial, or when they have become short."""
        counted = self.evaluation.statistics
        begun = counted.n_jacobian
        way: deque[tuple[float, int]] = deque([(t, begun)], WATCHED + 1)  # times, and Jacobians so far

        def worth(k: int) -> float:
            """The last k steps over the steps of Adams that cost as much."""
            (a, before), (b, now) = way[-1 - k], way[-1]
            return (b - a) / (self.size * self.gain * (k + self.of_jacobian * (now - before)))

        made = 0
        for step in one_step(self.implicit, True)(t, y, t_end, h):
            made += 1
            way.append((step.t, counted.n_jacobian))
            t = step.t
            if t >= t_end and not self.stays:  # the trial was enough; nobody asks for more after the last step
                self.stays = True
                self._tell(self.tried_at, 595, self.omega)
            yield step
            if t >= t_end:
                return
            if not self.stays and made >= TRIAL and made % LAST == 0:
                good = worth(LAST)
                self.stays = good > 1.0
                (a, _), (b, _) = way[-1 - 2 * LAST], way[-1 - LAST]
                if self.stays:
                    self._tell(self.tried_at, 595, self.omega)
                elif made >= LONGEST_TRIAL or (t - b < GROWING * (b - a) and good < PROMISING):
                    break
            elif self.stays and made >= WATCHED and worth(WATCHED) < LEFT:
                self.stays = False
                break
        else:
            return
        self.implicit = None
        cost = self.gain * (made + self.of_jacobian * (counted.n_jacobian - begun))
        self.lost += max(0.0, cost - (t - self.tried_at) / self.size)
        self._tell(t, 0)

    def _tell(self, t: float, code: int, omega: float | None = None) -> None:
        switched: Callable[..., None] | None = getattr(self.evaluation.problem, "switched", None)
        if switched is not None:
            switched(t, code, omega)

    def _limited(self, t: float, y: np.ndarray, h: float, t_end: float) -> bool:
        """May a vibration limit the steps, and is there enough ahead?"""
        ahead = (t_end - t) / h
        if LOST * ahead < self.lost + TRIAL * self.gain or SEEN * ahead < (self.looks + 1) * self.price:
            return False
        self.looks += 1
        try:
            found = self._frequencies(t, y)
        except AnalysisError:
            return False  # next to a place that cannot be evaluated: no time to change
        self.omega = max((fast for fast, slow in found if fast > SLOWER * slow), default=0.0)
        return h * self.omega > FAST

    def _frequencies(self, t: float, y: np.ndarray) -> tuple[tuple[float, float], tuple[float, float]]:
        """Highest frequency and largest rate of decay, each with the speed of the motion [1/s], after the last step."""
        problem, counted = self.evaluation.problem, self.evaluation.statistics
        rhs_for_differences: Callable[[], Rate] | None = getattr(problem, "rhs_for_differences", None)
        exact: Rate = rhs_for_differences() if rhs_for_differences is not None else problem.rhs
        f = exact(t, y).copy()
        n = problem.n_positions
        rates = len(y) - n

        def changed(part: slice, w: np.ndarray) -> tuple[np.ndarray, float]:
            """dF_u w in the size of w, and |dF_u w| / |w|."""
            length = norm(w)
            if not length > 0.0:
                return w, 0.0
            moved = y.copy()
            size = DIFFERENCE * (1.0 + norm(y[part]))
            moved[part] += (size / length) * w
            change = (exact(t, moved) - f)[n:]
            counted.n_rhs += 1
            return change, norm(change) / size

        found = []
        for first, power in ((0, 0.5), (n, 1.0)):
            part = slice(first, first + rates)
            w = np.cos(np.arange(1.0, rates + 1.0))  # a vector that is nothing in particular
            size = 0.0
            for _ in range(ITERATIONS):
                before = size
                w, size = changed(part, w)
                if abs(size - before) <= SETTLED * size:
                    break
            found.append(size**power)
        moved = sqrt(changed(slice(0, rates), (y - self.seen)[:rates])[1])
        largest = max(norm(y[n:]), norm(self.seen[n:]))
        turned = norm((y - self.seen)[n:]) / ((t - self.seen_at) * largest) if largest > 0.0 else 0.0
        return (found[0], moved), (found[1], turned)


def norm(v: np.ndarray) -> float:
    return sqrt(float(v @ v))


def _nowhere(t: float) -> np.ndarray:
    raise AssertionError("no step yet")
