"""Explicit Runge-Kutta codes in fixed steps (130, 140) and variable steps (135, 155, 853).

A step is y+ = y + h b K with the stages K_i = F(t + c_i h, y + h sum_j a_ij K_j); K has one row per stage and
a last row F(t + h, y+), which is the first stage of the next step.
"""

from math import sqrt

import numpy as np

from . import dop853
from .problem import Evaluation, Tolerance
from .tableaus import Tableau


def _largest(value: float | np.ndarray) -> float:
    """Of all cases; `np.max` of a number takes as long as a small evaluation of F."""
    return value if isinstance(value, float) else float(value.max())


class OneStepMethod:
    """State y at the start of a step with F there, the first of the `stages`; y_new at its end with F, the last one.

    controller   exponent denominator, smallest and largest factor of the step
    scaled       components of the error estimate, as multiples of the tolerance
    """

    def __init__(
        self, evaluation: Evaluation, n: int, tolerance: Tolerance, controller: tuple[float, float, float], stages: int
    ) -> None:
        self.evaluation, self.tolerance, self.controller = evaluation, tolerance, controller
        self.stages = np.zeros((stages, n))
        self.y, self.y_new, self.scaled = np.zeros((3, n))
        self.t = self.h = 0.0

    def start(self, t: float, y: np.ndarray) -> np.ndarray:
        """Sets the state and returns F there."""
        self.t = t
        self.y_new[:] = y
        self.stages[-1] = self.evaluation.rhs(t, self.y_new)
        return self.stages[-1]

    def begin(self, t: float) -> None:
        """Makes the end of the last step the start of the next one."""
        self.t = t
        self.y[:] = self.y_new
        self.stages[0] = self.stages[-1]

    def fixed(self, t: float, h: float, y: np.ndarray) -> None:
        """One step from (t, y) into y_new."""
        self.y[:] = y
        self.stages[0] = self.evaluation.rhs(t, self.y)
        self._step(t, h)

    def _step(self, t: float, h: float) -> bool | None:
        """y_new from y and the first stage."""
        raise NotImplementedError

    def attempt(self, h: float) -> float:
        """A trial step; returns the error estimate as a multiple of the tolerance, `scaled` holds its components."""
        raise NotImplementedError

    def finish(self) -> None:
        """Nothing left to evaluate: the last stage is F at the step end."""

    def weights(self, y_new: np.ndarray) -> np.ndarray:
        """Tolerance of each component, from the larger of the values at the two step ends, shape (n,)."""
        return self.tolerance.absolute + self.tolerance.relative * np.maximum(np.abs(self.y), np.abs(y_new))

    def factor(self, error: float) -> float:
        """Next step over the last one, from the error of the last one."""
        exponent, smallest, largest = self.controller
        return min(largest, max(smallest, 0.9 * error ** (-1.0 / exponent))) if error > 0.0 else largest

    def interpolate(self, t: float) -> np.ndarray:
        """y(t) in the last step, shape (n,): cubic Hermite, which for y = (q, v) uses accelerations."""
        h = self.h
        s = (t - self.t) / h
        r = 1.0 - s
        value = (r * r * (1.0 + 2.0 * s)) * self.y + (s * s * (3.0 - 2.0 * s)) * self.y_new
        return value + (h * s * r) * (r * self.stages[0] - s * self.stages[-1])


class ExplicitRungeKutta(OneStepMethod):
    """Fixed and variable steps with a tableau. `attempt` leaves y_new; `finish` leaves F(t + h, y_new)."""

    def __init__(self, tableau: Tableau, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        super().__init__(evaluation, n, tolerance, tableau.controller, len(tableau.c) + 1)
        self.tableau = tableau

    def _step(self, t: float, h: float, end: bool = False) -> bool:
        """All stages and y_new; whether F at the `end`, which is wanted next, is there too."""
        stages, evaluation, tableau = self.stages, self.evaluation, self.tableau
        blocks, c, i = evaluation.blocks, tableau.c, 1
        while i < len(c):
            if blocks is not None:  # does what it can in one call
                asked = tableau.evaluated if end else (c, tableau.a)
                window = evaluation.first, evaluation.last
                reached = blocks.stages(i, *asked, t, h, window, self.y, stages, evaluation.problem.within)
                evaluation.statistics.n_rhs += reached - i
                i = reached
                if i >= len(c):
                    break
            stages[i] = evaluation.rhs(t + c[i] * h, self.y + h * (tableau.a[i, :i] @ stages[:i]))
            i += 1
        self.y_new[:] = self.y + h * (tableau.b @ stages[:-1])
        return i > len(c)

    def coefficients(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """c and A of the stages of a trial step, rows of its error estimates, by how much that is enlarged."""
        assert self.tableau.error is not None
        return *self.tableau.evaluated, self.tableau.error[None], 1.0

    def taken(self, t: float, h: float) -> None:
        """A step of size h from t has been taken elsewhere; its stages and states are in place."""
        self.t, self.h = t, h

    def attempt(self, h: float) -> float:
        self.h = h
        if not self._step(self.t, h, end=True):
            self.stages[-1] = self.evaluation.rhs(self.t + h, self.y_new)
        np.matmul(self.tableau.error, self.stages, self.scaled)  # type: ignore[arg-type]
        np.divide(self.scaled, self.weights(self.y_new), self.scaled)
        return h * sqrt(_largest(self._mean_square(self.scaled)))

    def _mean_square(self, v: np.ndarray) -> float | np.ndarray:
        """Of all components; of a state of many cases that of each case."""
        if (by_case := self.evaluation.problem.by_case) is None:
            return float(v.dot(v)) / len(v)
        cases = v.reshape(by_case)
        return np.einsum("bcl,bcl->bl", cases, cases) / cases.shape[1]

    def interpolate(self, t: float) -> np.ndarray:
        """y(t) in the last step, shape (n,): quartic extension of 155, cubic Hermite otherwise."""
        if self.tableau.dense is None:
            return super().interpolate(t)
        first, last, h = self.stages[0], self.stages[-1], self.h
        s = (t - self.t) / h
        r = 1.0 - s
        rise = self.y_new - self.y
        bend = h * first - rise
        quartic = (h * r) * (self.tableau.dense @ self.stages)
        return self.y + s * (rise + r * (bend + s * (rise - h * last - bend + quartic)))


# Inside a step the continuous extension of 853 errs up to ten times as much as the step itself (measured on
# the driven pendulum). So the steps are held to a quarter of the tolerance: 4^(1/8) = 1.19 times shorter.
OUTPUT_SAFETY = 4.0
TINY = float(np.finfo(float).tiny)


class DormandPrince853(ExplicitRungeKutta):
    """Order 8 with error estimators of orders 5 and 3 and a continuous extension of order 7."""

    def __init__(self, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        super().__init__(dop853.TABLEAU, evaluation, n, tolerance)
        self.extended = np.zeros((dop853.N_EXTENDED, n))
        self.dense: np.ndarray | None = None

    def coefficients(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        errors = np.stack((dop853.ERROR_5, dop853.ERROR_3))
        return self.tableau.c, self.tableau.a, errors, OUTPUT_SAFETY

    def taken(self, t: float, h: float) -> None:
        super().taken(t, h)
        self.dense = None

    def attempt(self, h: float) -> float:
        """The two estimates e5, e3 combine to h e5^2 / sqrt(e5^2 + 0.01 e3^2)."""
        self.h = h
        self._step(self.t, h)
        weight = self.weights(self.y_new)
        low = (dop853.ERROR_3 @ self.stages[:-1]) / weight
        np.divide(dop853.ERROR_5 @ self.stages[:-1], weight, self.scaled)
        e5, e3 = self._mean_square(self.scaled), self._mean_square(low)
        return OUTPUT_SAFETY * h * _largest(e5 / (e5 + 0.01 * e3 + TINY) ** 0.5)

    def finish(self) -> None:
        """F at the step end, first stage of the next step."""
        self.stages[-1] = self.evaluation.rhs(self.t + self.h, self.y_new)
        self.dense = None

    def interpolate(self, t: float) -> np.ndarray:
        """y(t) in the last step; the first call in a step costs three evaluations."""
        if self.dense is None:
            self.dense = self._extension()
        s = (t - self.t) / self.h
        factors = np.empty(len(self.dense))
        factors[::2] = s
        factors[1::2] = 1.0 - s
        np.multiply.accumulate(factors, out=factors)
        return self.y + factors @ self.dense

    def _extension(self) -> np.ndarray:
        """Rows r_j of y(theta) = y + s (r_0 + (1-s) (r_1 + s (r_2 + (1-s) (...)))), shape (7, n)."""
        extended, n_stages, h = self.extended, len(self.stages), self.h
        extended[:n_stages] = self.stages
        for i, (c, row) in enumerate(zip(dop853.C_EXTRA, dop853.A_EXTRA, strict=True), n_stages):
            extended[i] = self.evaluation.rhs(self.t + c * h, self.y + h * (row[:i] @ extended[:i]))
        rise = self.y_new - self.y
        bend = h * self.stages[0] - rise
        twist = rise - h * self.stages[-1] - bend
        return np.vstack([rise, bend, twist, h * (dop853.DENSE @ extended)])
