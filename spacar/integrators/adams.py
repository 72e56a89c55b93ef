"""Code 0: Adams predictor-corrector of orders 1 to 12 in variable steps (PECE with local extrapolation).

Formulas: theory-system.md section 9.1; method of L. F. Shampine and M. K. Gordon, "Computer Solution of
Ordinary Differential Equations: The Initial Value Problem", Freeman 1975, chapters 5, 6 and 10. The history
is kept as modified divided differences phi_1 ... phi_{k+1}, rows of one array, so that prediction and
predicted differences of all components come from a single small matrix product.
"""

from collections.abc import Iterator
from itertools import pairwise
from math import sqrt

import numpy as np

from spacar.arrays import EPS
from spacar.errors import AnalysisError

from .failures import LAST_STRETCH, MAX_REDUCTIONS, REDUCTION, not_evaluated, step_too_small
from .problem import Evaluation, Step, Tolerance

MAX_ORDER = 12
PHI = MAX_ORDER + 1  # differences that are kept
# |gamma*_i|, i = 0...13: error constants of the Adams methods in constant steps (index 0 is not used).
GAMMA_STAR = (
    0.0, 0.5, 0.0833, 0.0417, 0.0264, 0.0188, 0.0143,
    0.0114, 0.00936, 0.00789, 0.00679, 0.00592, 0.00524, 0.00468,
)  # fmt: skip


def predictor_weights(alpha: list[float], k: int) -> list[float]:
    """g_1 ... g_{k+1} from alpha_1 ... alpha_k (lists start at index 0)."""
    row = [1.0 / (q * (q + 1)) for q in range(1, k + 1)]
    g = [1.0, row[0]]
    for a in alpha[1:k]:
        row = [u - a * v for u, v in pairwise(row)]
        g.append(row[0])
    return g


# (k+1, k): below a row of ones the summation phi_k + ... + phi_i, i = 1 ... k
_SUMMATION = tuple(np.vstack([np.ones(k), np.triu(np.ones((k, k)))]) for k in range(MAX_ORDER + 1))


def step_coefficients(
    h: float, k: int, n_s: int, psi: list[float]
) -> tuple[list[float], list[float], list[float], np.ndarray]:
    """Coefficients of a step h of order k whose last n_s steps, this one included, are equal.

    `psi` are the sums of the last i steps at the start of the step. Returns the sums at its end, g_1 ... g_{k+1},
    sigma_1 ... sigma_{k+1} and the (k+1, k) matrix that maps phi to (sum g_i phi*_i, phi^e_1, ..., phi^e_k).
    """
    psi_new = [h, *(h + p for p in psi[:-1])]
    n_s = min(n_s, k)
    alpha = [1.0 / i for i in range(1, n_s + 1)]
    beta = [1.0] * n_s
    sigma = [1.0] * (n_s + 1)
    b, s = 1.0, 1.0
    for i in range(n_s, k):
        b *= psi_new[i - 1] / psi[i - 1]
        a = h / psi_new[i]
        s *= (i + 1) * a
        beta.append(b)
        alpha.append(a)
        sigma.append(s)
    g = predictor_weights(alpha, k)
    matrix = _SUMMATION[k].copy()
    matrix[0] = g[:k]
    matrix *= beta
    return psi_new, g, sigma, matrix


def interpolation_weights(tau: float, k: int, psi: list[float]) -> list[float]:
    """w_1 ... w_{k+1} of y(t_n + tau) = y_n + tau sum w_i phi_i."""
    row = [1.0 / q for q in range(1, k + 2)]
    weights = [1.0]
    sum_before = 0.0
    for p in psi[:k]:
        gamma, eta = (tau + sum_before) / p, tau / p
        row = [gamma * u - eta * v for u, v in pairwise(row)]
        weights.append(row[0])
        sum_before = p
    return weights


def lowered(k: int, e_k: float, e_k1: float, e_k2: float) -> bool:
    """Whether the error estimates of orders k, k-1, k-2 ask for order k-1."""
    return (k > 2 and max(e_k1, e_k2) <= e_k) or (k == 2 and e_k1 <= 0.5 * e_k)


def next_step_size(h: float, k: int, error: float) -> float:
    """The step after an accepted one: double, keep or reduce; `error` is the estimate for the new order k."""
    if error * 2.0 ** (k + 1) <= 0.5:
        return 2.0 * h
    if error <= 0.5:
        return h
    return h * min(0.9, max(0.5, (0.5 / error) ** (1.0 / (k + 1))))


class Adams:
    """Work arrays and history for a state of n components."""

    def __init__(self, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        self.evaluation = evaluation
        self.tolerance = tolerance
        self.memory = np.zeros((2 * PHI + 6, n))
        self.phi, self.expected = self.memory[:PHI], self.memory[PHI : 2 * PHI]
        self.y, self.y_new, self.predicted, self.d, self.weight, self.scaled = self.memory[2 * PHI :]
        self.psi = [0.0] * (MAX_ORDER + 1)
        self.t = 0.0
        self.k = 1

    def interpolate(self, t: float) -> np.ndarray:
        """y(t) in the last step from the step's own polynomial, shape (n,)."""
        tau = t - self.t
        weights = np.array(interpolation_weights(tau, self.k, self.psi))
        weights *= tau
        result = weights @ self.phi[: self.k + 1]
        result += self.y
        return result

    def _norm(self, a: np.ndarray) -> float:
        """Weighted norm."""
        np.multiply(a, self.weight, self.scaled)
        return sqrt(self.scaled.dot(self.scaled))

    def _set_weights(self) -> None:
        self.weight[:] = 1.0 / (np.abs(self.y) * self.tolerance.relative + self.tolerance.absolute)

    def steps(self, t: float, y: np.ndarray, t_end: float, h: float) -> Iterator[Step]:
        """Accepted steps from (t, y) to exactly t_end; h is the largest first step.

        Raises AnalysisError `integrator.step-too-small`, or the error of F after ten reductions of the step.
        """
        rhs, phi, d, stepper = self.evaluation.rhs, self.phi, self.d, self.evaluation.stepper
        self.y[:] = y
        if stepper is not None:
            yield from stepper.steps(self, t, t_end, h, float("inf"))
            return
        h_min = 4.0 * EPS * max(abs(t), abs(t_end), t_end - t)
        phi[0] = rhs(t, self.y)
        self._set_weights()
        slope = self._norm(phi[0])
        if 16.0 * h * h * slope > 1.0:
            h = 0.25 / sqrt(slope)
        h = max(h, h_min)
        k, k_old, n_s, h_old = 1, 0, 0, 0.0
        starting = True
        reductions = rejections = 0
        while True:
            # --- predict, evaluate, estimate
            final = t + LAST_STRETCH * h >= t_end
            if final:
                h = t_end - t
            t_new = t_end if final else t + h
            equal = min(n_s + 1 if h == h_old else 1, k_old + 1)
            psi, g, sigma, matrix = step_coefficients(h, k, equal, self.psi)
            expected = self.expected[: k + 1]
            np.matmul(matrix, phi[:k], expected)
            np.multiply(expected[0], h, self.predicted)
            np.add(self.predicted, self.y, self.predicted)
            try:
                np.subtract(rhs(t_new, self.predicted), expected[1], d)
                size = self._norm(d)
                error = h * abs(g[k - 1] - g[k]) * size
                e_k = h * GAMMA_STAR[k] * sigma[k] * size
                e_k1 = h * GAMMA_STAR[k - 1] * sigma[k - 1] * self._norm(expected[k] + d) if k > 1 else 0.0
                e_k2 = h * GAMMA_STAR[k - 2] * sigma[k - 2] * self._norm(expected[k - 1] + d) if k > 2 else 0.0
                lower = lowered(k, e_k, e_k1, e_k2)
                if error <= 1.0:
                    np.multiply(d, h * g[k], self.y_new)
                    np.add(self.y_new, self.predicted, self.y_new)
                    change = np.subtract(rhs(t_new, self.y_new), expected[1])
            except AnalysisError as cause:
                self.evaluation.step_rejected()
                reductions += 1
                starting = False
                if reductions > MAX_REDUCTIONS or h * REDUCTION < h_min:
                    raise not_evaluated(cause, t, h, reductions) from cause
                h *= REDUCTION
                k = max(1, k - 1)
                continue

            if not error <= 1.0:
                # --- reject: the history was not touched
                self.evaluation.step_rejected()
                rejections += 1
                starting = False
                if 0.5 * h < h_min:
                    self._norm(d)
                    raise step_too_small(self.evaluation, t, h, error, self.scaled)
                factor = 0.5
                if rejections > 3 and e_k > 2.0:
                    factor = sqrt(0.5 / e_k)
                h = max(factor * h, h_min)
                k = 1 if rejections >= 3 else k - lower
                continue

            # --- accept: new history, new order, new step
            e_raised = h * GAMMA_STAR[k + 1] * self._norm(change - phi[k]) if k + 1 <= equal else None
            np.add(expected[1:], change, phi[:k])
            phi[k] = change
            self.y, self.y_new = self.y_new, self.y
            self.psi, self.k, self.t = psi, k, t_new
            t, n_s, h_old, k_old = t_new, equal, h, k
            reductions = rejections = 0
            self.evaluation.step_accepted(t, self.y)
            yield Step(t, self.y, self.interpolate)
            if final:
                return
            self._set_weights()
            starting = starting and not lower and k < MAX_ORDER
            if starting:
                k += 1
                h *= 2.0
                continue
            if not lower and e_raised is not None:
                if k > 1 and e_k1 <= min(e_k, e_raised):
                    lower = True
                elif k < MAX_ORDER and e_raised < (e_k if k > 1 else 0.5 * e_k):
                    k, e_k = k + 1, e_raised
            if lower:
                k, e_k = k - 1, e_k1
            h = max(next_step_size(h, k, e_k), h_min)
