"""The method that chooses itself (`method_choice`): Adams (code 0), or Radau IIA of order 9 (595).

The largest omega is found by power iteration with differences of F,

    dF_u/dq w -> w,  omega^2 = |dF_u/dq w| / |w|,      and likewise the decay c = |dF_u/du w| / |w|,

q positions, u their rates. How fast the motion is, say the first quotient of the way since the look before,
w = q - q_before (present rates would hold the vibration itself), and, beside decays, the change of the rates in that
time dt, |u - u_before| / (dt max |u|): what decays is over after some 1/c, whatever its shape, and the rates that are
left may lie in the direction of the decay itself. Only what is SLOWER times faster than the motion counts.

What a step of Radau costs in steps of Adams was counted (processor time of whole runs over accepted steps, chains of
trusses, planar and spatial beams; benchmarks/default_method.py): with equations in C (0.2 + 0.005 n) ms over
(1 + 0.4 n) us, n components of the state: 100 for n = 2, 57 for 8, 28 for 32, 19 for 64, and not less beyond, as its
factors grow with n^3; with those of NumPy 3.3 to 4.9, whatever n. A Jacobian takes 1.5 to 3.9 ms, n = 2 to 64.
"""

from collections.abc import Iterator
from math import sqrt

import numpy as np

from spacar.errors import AnalysisError

from .adams import Adams
from .method_choice import MethodChoice
from .one_step import one_step
from .problem import Evaluation, Step, Tolerance
from .radau import Radau

FAST = 0.1  # h omega: Adams methods of order 2 to 12 are stable up to about 0.8 or, with tight tolerances, 0.3
# Radau takes omega h up to about 3 of what it follows: its steps cannot be longer by more than ten times the frequency
# of the vibration over that of the motion.
SLOWER = 4.0
C_GAIN, LEAST_C_GAIN, NUMPY_GAIN = 160.0, 18.0, 5.0  # C_GAIN / sqrt(n), at least; without C
JACOBIAN = {True: 8.0, False: 0.4}  # steps of Radau that one costs, with Adams in C or not
LOOK, OF_PYTHON = 1200.0, 10.0  # a look costs at most LOOK / n steps of Adams in C (0.7 ms), or OF_PYTHON without
ITERATIONS, SETTLED = 10, 0.1  # of the power method, or its last relative change: what counts is the size of omega
DIFFERENCE = 1e-7  # of positions and rates: far above what is left of a position, small against its curvature


class Automatic:
    """Steps of code 0 and, where that pays, of 595."""

    def __init__(self, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        self.evaluation, self.n, self.tolerance = evaluation, n, tolerance
        self.explicit = Adams(evaluation, n, tolerance)
        in_blocks = evaluation.stepper is not None
        self.of_jacobian = JACOBIAN[in_blocks]
        gain = max(LEAST_C_GAIN, C_GAIN / sqrt(n)) if in_blocks else NUMPY_GAIN
        self.choice = MethodChoice(gain, LOOK / n if in_blocks else OF_PYTHON, FAST, self._largest)
        self.done = 0  # accepted steps of Adams
        self.seen, self.seen_at = np.zeros(n), 0.0  # state and time of the last look

    def steps(self, t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
        """As `Adams.steps`."""
        while True:
            trying = self.choice.trying
            part = self._implicit(t, y, t_end, h) if trying else self._explicit(t, y, t_end, h)
            for step in part:
                t, y = step.t, step.y
                yield step
            y, h = y.copy(), t_end - t
            if t >= t_end:
                return
            if not self.choice.trying:
                h = min(self.choice.size, h)

    def _explicit(self, t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
        """Steps of Adams up to the end or to a change."""
        counted, choice = self.evaluation.statistics, self.choice
        other = counted.n_steps - self.done  # steps of Radau
        self.seen, self.seen_at = y.copy(), t
        choice.begin(t, self.done)
        self.evaluation.halt = other + choice.look  # outputs are passed until the next look
        try:
            for step in self.explicit.steps(t, y, t_end, h):
                yield step
                self.done = counted.n_steps - other
                if self.done >= choice.look:
                    limited = choice.limited(step.t, step.y, self.done, t_end)
                    self.evaluation.halt = other + choice.look
                    if limited:
                        self._try(step.t)
                        return
                    self.seen, self.seen_at = step.y.copy(), step.t
        except AnalysisError as error:
            if error.code != "integrator.step-too-small":
                raise
            choice.size = error.data["step"]
            choice.omega = 1.0 / choice.size
            self._try(error.data["t"])

    @property
    def _work(self) -> float:
        """Of all steps of Radau, in steps of Adams."""
        counted = self.evaluation.statistics
        return self.choice.gain * (counted.n_steps - self.done + self.of_jacobian * counted.n_jacobian)

    def _try(self, t: float) -> None:
        """Go on with Radau."""
        self.choice.attempt(t, self._work)
        self.evaluation.problem.switched(t, 595, None)

    def _implicit(self, t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
        """Steps of 595 up to the end, or back to Adams."""
        choice = self.choice
        for step in one_step(Radau(5, self.evaluation, self.n, self.tolerance), t, y, t_end, h, True):
            t, stood = step.t, choice.stays
            if t >= t_end and not stood:  # the trial was enough; nobody asks for more after the last step
                choice.stays = True
                self.evaluation.problem.switched(choice.tried_at, 595, choice.omega)
            yield step
            if t >= t_end:
                return
            if not choice.goes_on(t, self._work):
                self.evaluation.problem.switched(t, 0, None)
                return
            if choice.stays and not stood:
                self.evaluation.problem.switched(choice.tried_at, 595, choice.omega)

    def _largest(self, t: float, y: np.ndarray) -> float:
        """Of the highest frequency and the largest rate of decay what is faster than the motion [1/s]."""
        return max((fast for fast, slow in self._frequencies(t, y) if fast > SLOWER * slow), default=0.0)

    def _frequencies(self, t: float, y: np.ndarray) -> tuple[tuple[float, float], tuple[float, float]]:
        """Highest frequency and largest rate of decay, each with the speed of the motion [1/s], after the last step."""
        problem, counted = self.evaluation.problem, self.evaluation.statistics
        exact = problem.rhs_for_differences()
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
