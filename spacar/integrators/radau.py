"""Codes 553 and 595: Radau IIA of 3 and 5 stages (orders 5 and 9) in variable steps, for stiff and undamped models.

E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd ed., Springer 1996, section IV.8. The stages
Z_i = Y_i - y solve a^-1 Z / h = F(Y) by a simplified Newton iteration: with the eigenvalues lambda of a^-1 the linear
system of all stages falls apart into systems lambda/h I - J. As y = (q, u) with q' = v, v the last part of u,
dF/dq and dF/du of the rows u are enough:

    (lambda/h I - dF_u/du - h/lambda [0, dF_u/dq]) w = r,

of half the size for a mechanism without kinematic coordinates. The positions of the stages are integrated exactly,
Z_q = h (c v + a Z_v).

A velocity is measured by the displacement that its error makes within the step: h dv counts like dq, as chapter VII
does with variables of index 2, which the velocities of constrained motion are; a stiff vibration is nearly a constraint
(Ch. Lubich, ZAMP 44 (1993) 1022). What is resolved has h omega near 1, and h dv is about its displacement dv/omega; of
what is not, h dv is more than that. With dv itself steps would follow every vibration whose *velocity* was above the
tolerance: a unit beam that is released has displacements 4 beta^-5 and velocities 4 beta^-3 with omega = beta^2. What
moves its tip by 1e-5, 1e-7 has frequencies up to 170 and 1,100 rad/s; velocities of 1e-5, 1e-7 go to 5,400 and 120,000.

Coefficients of the methods of s stages (sections IV.5 and IV.8): collocation at the right Radau points, order 2s - 1.
c are the roots of P_s(2c - 1) - P_{s-1}(2c - 1), a_ij = int_0^{c_i} l_j with the Lagrange polynomials l_j of c;
b is the last row of a. For odd s the inverse of a has one real eigenvalue and (s - 1)/2 complex pairs, which split the
linear system of all stages into one real and (s - 1)/2 complex systems of the size of the state.

Error estimate (IV.8.18): embedded quadrature of order s at the points 0, c_1 ... c_s, with the weight 1/lambda_0 at 0.
Between the points the state follows the polynomial through 0, c_1 ... c_s. Where positions are integrals of velocities,
the integral of the polynomial of the velocities is one order better and meets the end of the step as well.
"""

from functools import cache
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import EPS
from spacar.errors import AnalysisError

from .failures import slow_newton
from .problem import Evaluation, Tolerance
from .resolvent import DenseResolvent, Resolvent, eliminated, resolvent
from .runge_kutta import OneStepMethod

MAX_NEWTON = 10
# The iteration ends when its estimated error is below this part of the tolerance of the step.
KAPPA = 0.01
# A Jacobian is kept as long as each iteration divides the error at least by 1 / KEEP.
KEEP = 0.2
# A step is not enlarged by less than this factor: the LU factors are kept instead.
SAME = 1.2
SAFETY = 0.9


class Collocation(NamedTuple):
    """Radau IIA with Z_i = Y_i - y, i = 1 ... s.

    c (s,), a and its inverse (s, s); real: lambda_0; pairs: lambda_k, one of each complex pair
    to (s, s)    real: row 0 transforms to the real system, rows 1, 2 and 3, 4 ... are real and imaginary parts
    back (s, s)  the columns to go with them, so that back @ to = I
    error (s,)   e with error estimate (F(y) + sum e_i Z_i / h), to be filtered by (lambda_0 / h - J)^-1
    basis (s, s) row k: coefficients of s^{k+1} of the polynomial through 0, Z_1 ... Z_s
    largest      of |(s - c_1) ... (s - c_s)| and of |s (s - c_1) ... (s - c_s)| in the step
    """

    c: np.ndarray
    a: np.ndarray
    inverse: np.ndarray
    real: float
    pairs: tuple[complex, ...]
    to: np.ndarray
    back: np.ndarray
    error: np.ndarray
    basis: np.ndarray
    largest: tuple[float, float]


@cache
def radau(s: int) -> Collocation:
    """Radau IIA with an odd number s of stages."""
    from numpy.polynomial import legendre

    difference = np.zeros(s + 1)
    difference[s - 1 :] = -1.0, 1.0
    c = 0.5 * (1.0 + np.sort(legendre.legroots(difference).real))
    c[-1] = 1.0
    a = _integrals(c)
    inverse = np.linalg.inv(a)  # at most 5 x 5 and once
    values, vectors = np.linalg.eig(inverse)
    order = np.argsort(np.abs(values.imag))
    i0 = int(order[0])
    upper = [int(i) for i in order[1:] if values[i].imag > 0.0]
    left = np.linalg.inv(vectors)
    to, back = [left[i0].real], [vectors[:, i0].real]
    for i in upper:
        to += [left[i].real, left[i].imag]
        back += [2.0 * vectors[:, i].real, -2.0 * vectors[:, i].imag]
    real = float(values[i0].real)
    # Weights of the embedded quadrature: 1/lambda_0 at 0, order s with the others.
    powers = np.arange(s)
    moments = 1.0 / (powers + 1.0)
    moments[0] -= 1.0 / real
    embedded = np.linalg.solve(c[None, :] ** powers[:, None], moments)
    error = real * (embedded - a[-1]) @ inverse
    basis = np.linalg.inv(c[:, None] ** (powers[None, :] + 1.0))
    inside = np.linspace(0.0, 1.0, 201)
    product = np.prod(inside[:, None] - c, axis=1)
    largest = float(np.abs(product).max()), float(np.abs(inside * product).max())
    pairs = tuple(complex(values[i]) for i in upper)
    return Collocation(c, a, inverse, real, pairs, np.array(to), np.array(back).T, error, basis, largest)


def _integrals(c: np.ndarray) -> np.ndarray:
    """int_0^c_i of the Lagrange polynomials of the points c, by Gauss quadrature, which is exact for them."""
    from numpy.polynomial.legendre import leggauss

    nodes, weights = leggauss(len(c))
    x = 0.5 * np.multiply.outer(c, 1.0 + nodes)
    out = np.empty((len(c), len(c)))
    for j, point in enumerate(c):
        others = np.delete(c, j)
        values = np.prod((x[:, :, None] - others) / (point - others), axis=2)
        out[:, j] = 0.5 * c * (values @ weights)
    return out


class Radau(OneStepMethod):
    """`attempt` leaves y_new and the stages; the Jacobian and its factors are kept as long as they do."""

    def __init__(self, stages: int, evaluation: Evaluation, n: int, tolerance: Tolerance) -> None:
        super().__init__(evaluation, n, tolerance, (stages + 1.0, 0.2, 8.0), 1)
        self.method = radau(stages)
        # q, the positions whose rates are the last components of y, and u, the others.
        self.n, self.nq = n, eliminated(n, evaluation.problem.n_positions)
        self.Z, self.F = np.zeros((2, stages, n))
        self.change, self.right = np.zeros((stages, n)), np.zeros((stages, n - self.nq))  # of an iteration
        self.weight = np.zeros(n)
        self._forget()

    def _forget(self) -> None:
        self.J: Any = None  # dF/dy, once it is known
        self.fresh = False
        self.factors: list[Resolvent] = []
        self.factored_h = 0.0
        self.contraction = 1.0
        self.slope = np.zeros(self.n)
        self.before: tuple[float, float] | None = None  # step size and error of the last accepted step
        self.predicted = False  # Z holds the polynomial of an accepted step
        self.refused = False

    def start(self, t: float, y: np.ndarray) -> np.ndarray:
        self._forget()
        return super().start(t, y)

    def begin(self, t: float) -> None:
        if self.predicted:
            self.slope = (self.Z[-1] - self.Z[-2]) / (self.h * (1.0 - self.method.c[-2]))
        super().begin(t)
        self.fresh = self.refused = False

    # -- one step -------------------------------------------------------------------------------------------------
    def attempt(self, h: float) -> float:
        """Raises AnalysisError `integrator.newton` when the iteration does not converge with a new Jacobian."""
        self.h = h
        if self.J is None or (self.contraction > KEEP and not self.fresh):
            self._linearize()
        self._factor()
        failure = self._newton()
        if failure is not None and not self.fresh:
            self._linearize()
            self._factor()
            failure = self._newton()
        if failure is not None:
            raise failure
        self.y_new[:] = self.y + self.Z[-1]
        error = self._error(self.stages[0])
        if error > 1.0 and (self.refused or not self.predicted):
            # The estimate of a stiff component is F there, not damped enough by one solve (IV.8.20).
            error = self._error(self.evaluation.rhs(self.t, self.y + self.estimate))
        error = max(error, self._between())
        self.refused = error > 1.0
        return error

    def _linearize(self) -> None:
        self.J = self.evaluation.jacobian(self.t, self.y)[0]
        self.fresh = True
        self.factored_h = 0.0

    def _factor(self) -> None:
        """Factors of the real and complex iteration matrices for the step."""
        h = self.h
        if h == self.factored_h:
            return
        each = (self.method.real, *self.method.pairs)
        self.factors = [resolvent(self.J, eigenvalue / h, self.nq, self.t, h) for eigenvalue in each]
        self.factored_h = h
        self.contraction = 1.0

    def _guess(self) -> None:
        """Stages on the line through the last two stages of the step before, positions integrated.

        The polynomial of all stages is the better guess of a smooth motion (a third less iterations), but it
        magnifies what is left in unresolved vibrations some thousand times.
        """
        m, nq, Z, h = self.method, self.nq, self.Z, self.h
        np.multiply.outer(h * m.c, self.slope, out=Z)
        if nq:
            Z[:, :nq] = (h * m.c)[:, None] * self.y[self.n - nq :] + (h * m.a) @ Z[:, self.n - nq :]

    def _newton(self) -> AnalysisError | None:
        """Stages of the step into Z; what to say when the iteration does not converge."""
        # What is known of the contraction is older by a step (IV.8.11); nothing is known of new factors.
        self.contraction = min(max(self.contraction, EPS) ** 0.8, 0.99)
        self._guess()
        self.weight[:] = self.weights(self.y + self.Z[-1])
        blocks = self.evaluation.blocks if isinstance(self.factors[0], DenseResolvent) else None
        found = None if blocks is None else blocks.newton(self)
        if found is None:
            if blocks is not None:
                self._guess()
            found = self._iterate()
        converged, change, theta = found
        if converged:
            return None
        worst = int(np.argmax(np.abs(self.change / self.weight))) % self.n
        failure = slow_newton(self.evaluation, self.t, self.h, change, theta, worst, KAPPA)
        self.contraction = 1.0
        return failure

    def _iterate(self) -> tuple[bool, float, float]:
        """Whether Z converged from its guess, size and contraction of the last change."""
        m, n, nq, Z, F, h = self.method, self.n, self.nq, self.Z, self.F, self.h
        statistics = self.evaluation.statistics
        drift = (h * m.c)[:, None] * self.y[n - nq :]
        ha, inverse = h * m.a, m.inverse / h
        real, *complexes = self.factors
        weight, dZ, increment, residual = self.weight, self.change, self.right, np.zeros(Z.shape)
        factor = 1.0 / sqrt(Z.size)
        change, theta, estimate = 0.0, 0.0, self.contraction
        for k in range(MAX_NEWTON):
            statistics.newton_iterations += 1
            for i, c in enumerate(m.c):
                F[i] = self.evaluation.rhs(self.t + c * h, self.y + Z[i])
            residual[:, nq:] = m.to @ (F[:, nq:] - inverse @ Z[:, nq:])
            increment[0] = real(residual[0])[nq:]
            for i, solve in enumerate(complexes):
                w = solve(residual[2 * i + 1] + 1j * residual[2 * i + 2])[nq:]
                increment[2 * i + 1], increment[2 * i + 2] = w.real, w.imag
            np.matmul(m.back, increment, dZ[:, nq:])
            if nq:
                # the positions follow the velocities, whatever they were before
                Z_v = Z[:, n - nq :] + dZ[:, n - nq :]
                dZ[:, :nq] = drift + ha @ Z_v - Z[:, :nq]
            scaled = (dZ / weight).ravel()
            previous, change = change, factor * sqrt(scaled.dot(scaled))
            np.add(Z, dZ, Z)
            if k:
                theta = change / previous
                self.contraction = theta
                if not theta < 0.99 or change * theta ** (MAX_NEWTON - 1 - k) > KAPPA * (1.0 - theta):
                    break
                if change * theta <= KAPPA * (1.0 - theta):
                    return True, change, theta
            elif change * estimate <= KAPPA * (1.0 - estimate):
                return True, change, theta
        return False, change, theta

    def _error(self, f: np.ndarray) -> float:
        """Norm of (lambda_0/h - J)^-1 (f + error @ Z / h), by the factors of the real system."""
        self.estimate = self.factors[0](f + (self.method.error / self.h) @ self.Z)
        np.divide(self.estimate, self.weights(self.y_new), self.scaled)
        return sqrt(self.scaled.dot(self.scaled) / self.n)

    def weights(self, y_new: np.ndarray) -> np.ndarray:
        """Tolerance of each component in a step, (n,): of velocities that of their displacements over h."""
        weight = super().weights(y_new)
        if self.nq:
            weight[self.n - self.nq :] /= self.h
        return weight

    def _between(self) -> float:
        """Largest norm, inside the step, of the last term of the positions (of everything without them).

        The estimate for the end of the step is blind to what is stiff: that ends right, but may pass anywhere between.
        """
        m, nq = self.method, self.nq
        if nq:
            last = (self.h * m.largest[1] / (len(m.c) + 1)) * (m.basis[-1] @ self.Z[:, self.n - nq :])
        else:
            last = m.largest[0] * (m.basis[-1] @ self.Z)
        last /= self.weights(self.y_new)[: len(last)]
        return sqrt(last.dot(last) / len(last))

    # -- between steps --------------------------------------------------------------------------------------------
    def finish(self) -> None:
        """F at the step end, for the error estimate of the next step, whose stages this one predicts."""
        self.stages[0] = self.evaluation.rhs(self.t + self.h, self.y_new)
        self.predicted = True

    def factor(self, error: float) -> float:
        """Next step over this one, from the error and its trend over two steps (IV.8.25); small gains are left."""
        exponent, smallest, largest = self.controller
        error = max(error, 1e-10)
        factor = SAFETY * error ** (-1.0 / exponent)
        if self.before is not None:
            h, last = self.before
            factor = min(factor, factor * (self.h / h) * (last / error) ** (1.0 / exponent))
        self.before = self.h, max(error, 1e-2)
        factor = min(largest, max(smallest, factor))
        return 1.0 if 1.0 <= factor <= SAME and self.contraction <= KEEP else factor

    def interpolate(self, t: float) -> np.ndarray:
        """y(t) in the last step, shape (n,): collocation polynomial; positions integrate that of the velocities."""
        s = (t - self.t) / self.h
        nq = self.nq
        powers = s ** np.arange(1, len(self.Z) + 1)
        polynomial = powers @ self.method.basis
        out = self.y + polynomial @ self.Z
        if nq:
            integral = (s * powers / np.arange(2, len(self.Z) + 2)) @ self.method.basis
            out[:nq] = self.y[:nq] + self.h * (s * self.y[self.n - nq :] + integral @ self.Z[:, self.n - nq :])
        return out
