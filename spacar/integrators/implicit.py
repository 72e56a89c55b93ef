"""Codes 310, 320, 330 (Rosenbrock) and 410, 420, 430 (implicit Euler, SDIRK): fixed steps, L-stable.

Formulas: theory-system.md section 9. Rosenbrock methods: H. H. Rosenbrock, Computer J. 5 (1963) 329; 330 is
the three-stage method ROS3 of A. Sandu et al., Atmos. Environ. 31 (1997) 3459. SDIRK methods: R. Alexander,
SIAM J. Numer. Anal. 14 (1977) 1006. The Jacobian J = dF/dy and F_t = dF/dt come from the exact linearization.
"""

from math import sqrt

import numpy as np

from spacar.errors import AnalysisError

from .problem import Evaluation, Tolerance
from .resolvent import Resolvent, eliminated, resolvent

GAMMA_2 = 1.0 - 1.0 / sqrt(2.0)
GAMMA_3 = 0.43586652150845900
MAX_NEWTON = 10


class _FixedStep:
    """State common to the implicit codes: `fixed(t, h, y)` leaves the end of the step in y_new."""

    def __init__(self, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        self.evaluation, self.tolerance = evaluation, tolerance
        self.nq = eliminated(n, evaluation.problem.n_positions)
        self.y_new = np.zeros(n)

    def start(self, t: float, y: np.ndarray) -> None:
        """Nothing to prepare."""

    def end(self, t: float, y: np.ndarray) -> None:
        self.y_new = y
        self.evaluation.problem.settle(min(t, self.evaluation.last), y)


# gamma; of every stage alpha, rows of a and c, and g; weights m
ROSENBROCK = {
    310: (1.0, ((0.0, (), (), 1.0),), (1.0,)),
    320: (
        GAMMA_2, ((0.0, (), (), GAMMA_2), (1.0, (1.0 / GAMMA_2,), (-2.0 / GAMMA_2,), -GAMMA_2)),
        (1.5 / GAMMA_2, 0.5 / GAMMA_2),
    ),
    330: (
        GAMMA_3,
        (
            (0.0, (), (), 0.43586652150845900),
            (GAMMA_3, (1.0,), (-1.0156171083877702,), 0.24291996454816804),
            (GAMMA_3, (1.0,), (4.0759956452537700, 9.2076794298330791), 2.1851380027664058),
        ),
        (1.0, 6.1697947043828246, -0.42772256543218573),
    ),
}  # fmt: skip


class Rosenbrock(_FixedStep):
    """310, 320, 330: with u the sum of k times gamma h (Hairer and Wanner II, section IV.7),

        (1/(gamma h) - J) u_i = F(t + alpha_i h, y + sum_j a_ij u_j) + sum_j c_ij u_j / h + g_i h F_t

    and y+ = y + sum_i m_i u_i. Stages with the same arguments share F.
    """

    def __init__(self, code: int, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        super().__init__(evaluation, n, tolerance)
        self.gamma, self.stages, self.m = ROSENBROCK[code]
        self.u = np.zeros((len(self.m), n))

    def fixed(self, t: float, h: float, y: np.ndarray) -> None:
        jacobian, f_t = self.evaluation.jacobian(t, y)
        solve = resolvent(jacobian, 1.0 / (self.gamma * h), self.nq, t, h)
        f, at = f_t, None
        for i, (alpha, a, c, g) in enumerate(self.stages):
            if at != (alpha, a):
                at = alpha, a
                f = self.evaluation.rhs(t + alpha * h, y + np.dot(a, self.u[: len(a)]))
            self.u[i] = solve(f + np.dot(c, self.u[: len(c)]) / h + (g * h) * f_t)
        self.end(t + h, y + np.dot(self.m, self.u))


def sdirk_tableau(code: int) -> tuple[np.ndarray, np.ndarray]:
    """(c, A) of 410, 420 or 430; the last row of A is b (stiffly accurate)."""
    if code == 410:
        return np.array([1.0]), np.array([[1.0]])
    if code == 420:
        g = GAMMA_2
        return np.array([g, 1.0]), np.array([[g, 0.0], [1.0 - g, g]])
    g = GAMMA_3
    b1, b2 = -(6.0 * g * g - 16.0 * g + 1.0) / 4.0, (6.0 * g * g - 20.0 * g + 5.0) / 4.0
    a = np.array([[g, 0.0, 0.0], [(1.0 - g) / 2.0, g, 0.0], [b1, b2, g]])
    return np.array([g, (1.0 + g) / 2.0, 1.0]), a


class SinglyDiagonallyImplicit(_FixedStep):
    """410, 420, 430: stages k_i = F(t + c_i h, y + h sum_j a_ij k_j) by modified Newton.

    I/(h gamma) - J is factored once per step. Converged when all |h dk_i| <= absolute error; after ten
    iterations once more ten with the Jacobian at the iterate, then AnalysisError `integrator.newton`.
    """

    def __init__(self, code: int, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        super().__init__(evaluation, n, tolerance)
        self.c, self.a = sdirk_tableau(code)
        self.gamma = float(self.a[0, 0])
        self.stages = np.zeros((len(self.c), n))

    def start(self, t: float, y: np.ndarray) -> None:
        """First guess of the first stage: F at the start; later the last stage of the step before."""
        self.stages[-1] = self.evaluation.rhs(t, y)

    def fixed(self, t: float, h: float, y: np.ndarray) -> None:
        hg = h * self.gamma
        solve = resolvent(self.evaluation.jacobian(t, y)[0], 1.0 / hg, self.nq, t, h)
        stages = self.stages
        for i, c in enumerate(self.c):
            base = y + h * (self.a[i, :i] @ stages[:i])
            stages[i] = stages[i - 1]
            t_i = t + c * h
            if not self._newton(solve, t_i, h, base, stages[i]):
                jacobian = self.evaluation.jacobian(t_i, base + hg * stages[i])[0]
                solve = resolvent(jacobian, 1.0 / hg, self.nq, t, h)
                if not self._newton(solve, t_i, h, base, stages[i]):
                    change = np.abs(h * self.last_change)
                    worst = int(np.argmax(change))
                    error, limit = float(change[worst]), float(self.tolerance.absolute)
                    raise AnalysisError(
                        "the implicit integrator's Newton iteration did not converge in the step of "
                        f"{h:.3g} s from t = {t:.9g} s: last change {error:.3g} in {self.evaluation.name(worst)}, "
                        f"required {limit:.3g}. Try a smaller step size (INTEGRAT position 2) or, when the change is "
                        "at rounding level, a larger absolute error (ERROR position 1)",
                        "integrator.newton", t=t, step=h, error=error, component=worst,
                    )  # fmt: skip
        self.end(t + h, base + hg * stages[-1])

    def _newton(self, solve: Resolvent, t: float, h: float, base: np.ndarray, k: np.ndarray) -> bool:
        """Improves k in place; whether it converged."""
        hg = h * self.gamma
        for _ in range(MAX_NEWTON):
            self.evaluation.statistics.newton_iterations += 1
            self.last_change = solve((1.0 / hg) * (self.evaluation.rhs(t, base + hg * k) - k))
            k += self.last_change
            if h * np.abs(self.last_change).max() <= self.tolerance.absolute:
                return True
        return False
