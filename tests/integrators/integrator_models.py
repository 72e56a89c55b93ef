"""Problems with a known answer, shared by the integrator tests."""

from functools import cache
from typing import Any

import numpy as np

from spacar.integrators import METHODS, Problem
from spacar.integrators.problem import Evaluation, Tolerance

OSCILLATOR = np.array([[0.0, 1.0], [-4.0, -0.2]])


class Pendulum(Problem):
    """Damped pendulum driven at the hinge: q'' = -sin q - 0.2 q' + 0.8 cos 1.3 t."""

    n_positions = 1
    y0 = np.array([0.5, 0.3])

    def rhs(self, t: float, y: np.ndarray) -> np.ndarray:
        return np.array([y[1], -np.sin(y[0]) - 0.2 * y[1] + 0.8 * np.cos(1.3 * t)])

    def jacobian(self, t: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.array([[0.0, 1.0], [-np.cos(y[0]), -0.2]]), np.array([0.0, -1.04 * np.sin(1.3 * t)])


class Kepler(Problem):
    """Plane orbit of eccentricity 0.5, period 2 pi; exact by Kepler's equation."""

    n_positions = 2
    e = 0.5
    y0 = np.array([0.5, 0.0, 0.0, np.sqrt(3.0)])

    def rhs(self, t: float, y: np.ndarray) -> np.ndarray:
        r3 = (y[0] * y[0] + y[1] * y[1]) ** 1.5
        return np.array([y[2], y[3], -y[0] / r3, -y[1] / r3])

    def exact(self, t: np.ndarray) -> np.ndarray:
        anomaly = t.copy()
        for _ in range(60):
            anomaly -= (anomaly - self.e * np.sin(anomaly) - t) / (1 - self.e * np.cos(anomaly))
        s, c, b = np.sin(anomaly), np.cos(anomaly), np.sqrt(1 - self.e**2)
        rate = 1 / (1 - self.e * c)
        return np.array([c - self.e, b * s, -s * rate, b * c * rate]).T


class Linear(Problem):
    """y' = a y + b(t) as first-order system (all components 'velocities'); counts its evaluations."""

    def __init__(self, a: np.ndarray, load=lambda t: 0.0, n_positions: int | None = None) -> None:
        self.a = np.atleast_2d(np.asarray(a, float))
        self.load = load
        self.n_positions = len(self.a) // 2 if n_positions is None else n_positions
        self.n_rhs = self.n_jacobian = 0
        self.times: list[float] = []
        self.buffer = np.zeros(len(self.a))

    def rhs(self, t: float, y: np.ndarray) -> np.ndarray:
        self.n_rhs += 1
        self.times.append(t)
        # One buffer for all calls: an integrator that does not copy would be found out.
        np.dot(self.a, y, out=self.buffer)
        self.buffer[-1] += self.load(t)
        return self.buffer

    def jacobian(self, t: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        self.n_jacobian += 1
        return self.a, np.zeros(len(self.a))


class ProtheroRobinson(Problem):
    """y' = -rate (y - cos t) - sin t: from y = 1 the solution is cos t."""

    n_positions = 0

    def __init__(self, rate: float) -> None:
        self.rate = rate

    def rhs(self, t: float, y: np.ndarray) -> np.ndarray:
        return np.array([-self.rate * (y[0] - np.cos(t)) - np.sin(t)])

    def jacobian(self, t: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.array([[-self.rate]]), np.array([-self.rate * np.sin(t) - np.cos(t)])


@cache
def pendulum_reference(end: float) -> tuple[float, float]:
    """State of the pendulum at `end` by a Taylor series method of mpmath, good to about 20 digits."""
    import mpmath

    with mpmath.workdps(20):
        solution = mpmath.odefun(
            lambda t, y: [
                y[1],
                -mpmath.sin(y[0]) - y[1] / 5 + mpmath.mpf(4) / 5 * mpmath.cos(mpmath.mpf(13) / 10 * t),
            ],
            0,
            [mpmath.mpf(1) / 2, mpmath.mpf(3) / 10],
        )
        a, b = solution(end)
        return float(a), float(b)


def equal_steps(code: int, problem: Problem, y0: np.ndarray, end: float, n: int) -> tuple[np.ndarray, Any]:
    """End state of n equal steps of a variable-step code, driven by hand, and the integrator."""
    # Only the iteration of an implicit code asks for the tolerance: below the smallest discretization error.
    tolerance = Tolerance(1e-14 if METHODS[code].needs_jacobian else 1.0, 0.0)
    integrator = METHODS[code].build(Evaluation(problem, 0.0, end), len(y0), tolerance)
    integrator.start(0.0, y0)
    for j in range(n):
        integrator.begin(j * end / n)
        integrator.attempt(end / n)
        integrator.finish()
    return integrator.y_new.copy(), integrator
