"""Codes 220 and 225: two-stage explicit Runge-Kutta method for q'' = f(t, q, q').

Formulas: theory-system.md section 9; a member of the Nystrom family, E. J. Nystrom, Acta Soc. Sci. Fenn. 50
(1925), see Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", section II.14.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from .failures import second_order_needed
from .problem import Evaluation, Tolerance
from .runge_kutta import hermite, weights


class RungeKuttaNystrom:
    """Fixed (220) and variable (225) steps for y = (q, v); same duties as ExplicitRungeKutta.

    Raises AnalysisError `integrator.second-order` when there are not as many velocities as positions.
    """

    controller = (2.0, 0.3, 3.0)

    def __init__(self, code: int, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        self.n = evaluation.problem.n_positions
        if n != 2 * self.n:
            raise second_order_needed(code, self.n, n - self.n)
        self.evaluation, self.tolerance = evaluation, tolerance
        self.y, self.y_new, self.f, self.f_new, self.work, self.scaled = np.zeros((6, n))
        self.t = self.h = 0.0

    def start(self, t: float, y: np.ndarray) -> np.ndarray:
        """Sets the state and returns F there."""
        self.t = t
        self.y_new[:] = y
        self.f_new[:] = self.evaluation.rhs(t, self.y_new)
        return self.f_new

    def begin(self, t: float) -> None:
        """Makes the end of the last step the start of the next one."""
        self.t = t
        self.y[:] = self.y_new
        self.f[:] = self.f_new

    def _step(self, t: float, h: float) -> None:
        """y_new from y and f; leaves the simple prediction (q*, v + h a0) in `work`."""
        n, y, work = self.n, self.y, self.work
        a0 = self.f[n:]
        np.multiply(h, a0, work[n:])
        np.add(y[n:], 0.5 * work[n:], work[:n])
        work[:n] *= h
        work += y
        a1 = self.evaluation.rhs(t + h, work)[n:]
        self.y_new[n:] = y[n:] + (0.5 * h) * (a0 + a1)
        self.y_new[:n] = y[:n] + h * y[n:] + (h * h / 6.0) * (2.0 * a0 + a1)

    def fixed(self, t: float, h: float, y: np.ndarray) -> None:
        """One step from (t, y) into y_new."""
        self.y[:] = y
        self.f[:] = self.evaluation.rhs(t, self.y)
        self._step(t, h)

    def attempt(self, h: float) -> float:
        """A trial step; returns the error estimate as a multiple of the tolerance, `scaled` holds its
        components."""
        self.h = h
        self._step(self.t, h)
        np.divide(self.y_new - self.work, weights(self.tolerance, self.y, self.y_new), self.scaled)
        return sqrt(self.scaled.dot(self.scaled) / len(self.scaled))

    def finish(self) -> None:
        """Accelerations at the step end: for the interpolation and as first stage of the next step."""
        self.f_new[:] = self.evaluation.rhs(self.t + self.h, self.y_new)

    def interpolate(self, t: float) -> np.ndarray:
        """y(t) in the last step, shape (n,)."""
        return hermite(t - self.t, self.h, self.y, self.f, self.y_new, self.f_new)
