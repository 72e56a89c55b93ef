"""Codes 220 and 225: two-stage explicit Runge-Kutta method for q'' = f(t, q, q').

Formulas: theory-system.md section 9; a member of the Nystrom family, E. J. Nystrom, Acta Soc. Sci. Fenn. 50
(1925), see Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", section II.14:

    a1 = f(t + h, q + h v + h^2/2 a0, v + h a0),    v+ = v + h/2 (a0 + a1),    q+ = q + h v + h^2/6 (2 a0 + a1)

The error of a step, h^3 in v and h^4 in q, is the difference from the integrals of the parabola through the
accelerations a- at the beginning of the step before (h- long), a0 and a2 = f(t + h, q+, v+), which is the first stage
of the next step. With D its second divided difference

    dv = h/2 (a2 - a1) - D h^3/6,    dq = h^2/6 (a2 - a1) - D h^4/12,    D = ((a2 - a0)/h - (a0 - a-)/h-) / (h + h-)

The step after a start has none before it and takes the acceleration in its middle, on the cubic through both ends.

The error of a step falls with h^3, that of the result with h^2. A result to the part p of its size S therefore needs
steps to the part p^(3/2): the tolerance w of a component, from ERROR, is w sqrt(w/S) for a step, S its largest value.
"""

from math import sqrt

import numpy as np

from spacar.errors import AnalysisError

from .problem import Evaluation, Tolerance
from .runge_kutta import OneStepMethod


class RungeKuttaNystrom(OneStepMethod):
    """Fixed (220) and variable (225) steps for y = (q, v).

    Raises AnalysisError `integrator.second-order` when there are not as many velocities as positions.
    """

    def __init__(self, code: int, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        self.n = evaluation.problem.n_positions
        if n != 2 * self.n:
            raise AnalysisError(
                f"INTEGRAT {code} needs as many velocities as positions, the model has {n - self.n} and {self.n} "
                "(kinematic coordinates of non-holonomic constraints): use INTEGRAT 0, 155 or 140",
                "integrator.second-order", n_positions=self.n, n_velocities=n - self.n,
            )  # fmt: skip
        super().__init__(evaluation, n, tolerance, (3.0, 0.3, 3.0), 2)
        self.f, self.f_new = self.stages
        self.size = np.zeros(n)  # largest value of each component so far
        self.a1, self.before = np.zeros((2, self.n))
        self.h_before = 0.0

    def start(self, t: float, y: np.ndarray) -> np.ndarray:
        self.h = 0.0  # there is no step before
        return super().start(t, y)

    def begin(self, t: float) -> None:
        self.h_before = self.h
        self.before[:] = self.f[self.n :]
        super().begin(t)
        np.maximum(self.size, np.abs(self.y), out=self.size)

    def _step(self, t: float, h: float) -> None:
        n, a0 = self.n, self.f[self.n :]
        q, v = self.y[:n], self.y[n:]
        self.a1[:] = a1 = self.evaluation.rhs(t + h, np.append(q + h * (v + (0.5 * h) * a0), v + h * a0))[n:]
        self.y_new[n:] = v + (0.5 * h) * (a0 + a1)
        self.y_new[:n] = q + h * v + (h * h / 6.0) * (2.0 * a0 + a1)

    def attempt(self, h: float) -> float:
        self.h = h
        self._step(self.t, h)
        n = self.n
        self.f_new[:] = self.evaluation.rhs(self.t + h, self.y_new)
        missed, bend = self.f_new[n:] - self.a1, self._bend(h)
        self.scaled[n:] = (0.5 * h) * missed - (h**3 / 6.0) * bend
        self.scaled[:n] = (h * h / 6.0) * missed - (h**4 / 12.0) * bend
        weight = self.weights(self.y_new)
        self.scaled /= weight * np.sqrt(weight / np.maximum(self.size, weight))
        return sqrt(self.scaled.dot(self.scaled) / len(self.scaled))

    def _bend(self, h: float) -> np.ndarray:
        """Second divided difference of the accelerations, half their second derivative, shape (n,)."""
        a0, a2, n = self.f[self.n :], self.f_new[self.n :], self.n
        if self.h_before > 0.0:
            return ((a2 - a0) / h - (a0 - self.before) / self.h_before) / (h + self.h_before)
        middle = self.evaluation.rhs(self.t + 0.5 * h, self.interpolate(self.t + 0.5 * h))[n:]
        return np.asarray((a0 - 2.0 * middle + a2) * (2.0 / (h * h)))
