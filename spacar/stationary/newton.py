"""Newton's iteration on the mixed equations, with its test of contraction; where it begins: on the polynomial through
earlier states of the path.

Prescribed coordinates are unknowns that move with the first correction: V and the geometric stiffness at the last
position take the others along, so that no configuration is evaluated in which only the prescribed coordinates have
jumped.

Corrections must contract: with the exact tangent the second is at most 0.6 of the first (half of it at an exactly
critical state, where Newton's method converges linearly), later ones three quarters of the one before. An iteration
that does not is broken off at once: it would leave the neighbourhood of the path, and what it may find is the state of
another branch (P. Deuflhard, Newton Methods for Nonlinear Problems, Springer 2004, chapter 5). Without N0 (ITERSTEP
types 1, 3) and with slips convergence is linear and contraction by any factor will do. In motion and with slips a
cyclic coordinate may drift while the forces converge; there it is enough that the forces contract.

What rounding makes of a correction is measured, not assumed: one more right-hand side holds the rounding errors of the
residual (eps times the sum of the sizes of its terms). Corrections of the size of its solution need not contract, and
end the iteration.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import isfinite, prod
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError
from spacar.kinematics.kinematics import LARGEST_JUMP, largest
from spacar.linear_systems import SingularMatrixError
from spacar.stationary.singular import minimum_norm
from spacar.stationary.stationary_equations import (
    FLOOR,
    NO_DIGITS,
    SPREAD,
    Astray,
    Iterate,
    Prescribed,
    StationaryEquations,
    Tangent,
    require_digits,
)

FORCES = 1e-9  # out-of-balance work / work of the forces in it
LENGTHS = 1e-11  # incompatibility / model length, or rad
CORRECTION = 1e-7  # last correction / model length, or rad: the next one would be of the size of its square
PASSING_FORCES, PASSING_LENGTHS, PASSING_CORRECTION = 1e-4, 1e-7, 1e-3  # at a state that is no result
RELAXATIONS = 10.0 ** -np.arange(0.0, 12.0, 0.5)  # damping of a length over the stiffness, step by step
FIRST_RATIO, LATER_RATIO, LINEAR_RATIO = 0.6, 0.75, 0.98  # of two corrections, at most


@dataclass(frozen=True)
class Demand:
    """What an iteration has to reach in at most `limit` corrections: the relative sizes of forces, lengths and of the
    last correction as the constants above, and `tolerance`, the largest force out of balance [N]."""

    limit: int
    tolerance: float = np.inf
    forces: float = PASSING_FORCES
    lengths: float = PASSING_LENGTHS
    correction: float = PASSING_CORRECTION

    @classmethod
    def of(cls, limit: int, tolerance: float, stored: bool) -> Demand:
        """The demand of a level that is stored, or of one that is passed through only."""
        return cls(limit, tolerance, FORCES, LENGTHS, CORRECTION) if stored else cls(limit)

    def exactly(self) -> Demand:
        """The same with the accuracy of a result, whatever ITERSTEP asks for."""
        return replace(self, forces=FORCES, lengths=LENGTHS, correction=CORRECTION)

    @classmethod
    def of_return(cls, limit: int, near: float) -> Demand:
        """Of an iteration that is to tell where it leads only, up to about `near` [model lengths or rad]."""
        return cls(limit, np.inf, np.inf, np.inf, near)

    @property
    def sizes(self) -> tuple[float, float, float, float]:
        """Of forces, lengths and the last correction, and the force: as C takes them."""
        return self.forces, self.lengths, self.correction, self.tolerance

    def met_by_guess(self, p: Iterate) -> bool:
        """Is no correction needed? At a state that is no result it is not, where forces and lengths are as small as at
        one that is: the error of such a prediction is of the size that a result may have in these."""
        if p.quiet or self.forces <= FORCES:
            return p.quiet
        return p.work <= FORCES * p.work_size and p.gap <= LENGTHS

    def met(self, p: Iterate) -> bool:
        """Are forces and lengths small enough at this point?"""
        small = p.work <= self.forces * p.work_size and p.force <= self.tolerance and p.gap <= self.lengths
        return p.quiet or small


@dataclass
class Corrections:
    """The sizes of the corrections of one iteration, and when it has ended or has to be broken off."""

    demand: Demand
    exact: bool
    plain: bool = True
    sizes: list[float] = field(default_factory=list)
    noise: float = 0.0  # the size that rounding alone gives a correction
    work: float = np.inf  # of the forces out of balance at the last point
    contracts: bool = True

    def add(self, size: float, noise: float) -> None:
        """Raises Astray when the corrections do not contract."""
        self.sizes.append(size)
        self.noise = SPREAD * noise
        if not size <= LARGEST_JUMP:
            raise too_large(size)
        if len(self.sizes) > 1 and size > self.noise:
            ratio = (FIRST_RATIO if len(self.sizes) == 2 else LATER_RATIO) if self.exact else LINEAR_RATIO
            self.contracts = size <= ratio * self.sizes[-2]
            if not self.contracts and self.plain:
                raise growing(self.sizes)

    def ended(self, p: Iterate) -> bool:
        """Is the point that the last correction led to the solution? Raises Astray beyond the limit of iterations."""
        if not p.finite:
            raise not_finite()
        if not self.contracts and p.work > FIRST_RATIO * self.work:
            raise growing(self.sizes)
        self.work = p.work
        if not self.sizes:
            return self.demand.met_by_guess(p)
        last = self.sizes[-1]
        met = last <= self.noise or (self.demand.met(p) and self._left(last) <= self.demand.correction)
        if not met and len(self.sizes) >= self.demand.limit:
            raise no_convergence(self.demand.limit)
        return met

    def _left(self, last: float) -> float:
        """The error behind the last correction, scaled so that `Demand.correction` applies to it: with quadratic
        convergence the correction itself, with linear convergence what a geometric series leaves."""
        if self.exact or len(self.sizes) < 2:
            return last
        ratio = min(last / self.sizes[-2], LINEAR_RATIO) if self.sizes[-2] > 0.0 else 0.0
        left = last * ratio / (1.0 - ratio)
        return max(left * self.demand.correction / self.demand.lengths, 0.0)


def too_large(size: float) -> Astray:
    return Astray(f"a correction of {size:.2g} model lengths or rad")


def growing(sizes: Sequence[float]) -> Astray:
    return Astray("corrections that do not contract: " + " ".join(f"{v:.2g}" for v in sizes))


def not_finite() -> Astray:
    return Astray("numbers that are not finite")


def no_convergence(limit: int) -> Astray:
    text = f"no convergence in {limit} iteration{'s' * (limit != 1)}"
    return Astray(text, remedy="more iterations (the first number of ITERSTEP)")


def correction(
    q: StationaryEquations, tangent: Tangent, p: Iterate, dx: Array, more: Array | None = None
) -> tuple[Array, float]:
    """Solution (n,) or (n, 2) for the right-hand sides p.right - tangent dx (and `more`), and the noise in it.

    Raises SingularMatrixError.
    """
    b = np.empty((len(p.right), 3 if more is None else 4))
    b[:, 0] = p.right - tangent.along(dx) if dx.any() else p.right
    np.multiply(q.signs, p.rounding, out=b[:, 1])
    b[:, 2] = q.probe
    if more is not None:
        b[:, 3] = more
    solution = tangent.solve(b)
    require_digits(tangent.solve, tangent.rounding, solution[:, 2], q.nf)
    noise = largest(solution[: q.nf, 1] / q.free_scale)
    if not noise < NO_DIGITS:
        raise SingularMatrixError(f"rounding errors move the solution by {noise:.2g} model lengths or rad")
    return (solution[:, 0] if more is None else solution[:, [0, 3]]), noise


@dataclass(frozen=True)
class Converged:
    """The state, how many corrections led there, the noise in the last one, and whether its matrix was regular."""

    point: Iterate
    iterations: int
    noise: float
    regular: bool


def newton(
    q: StationaryEquations, tangent: Tangent, x: Array, sigma: Array, given: Prescribed, demand: Demand
) -> Converged:
    """The state in equilibrium near x (nx,), sigma (ne,).

    Raises Astray, SingularMatrixError, AnalysisError of user functions.
    """
    path = Corrections(demand, tangent.exact and q.holonomic, q.plain)
    dx = np.zeros_like(x)
    dx[q.P] = (given.x - x)[q.P]
    p = q.point(x, sigma, given)
    if not dx.any() and path.ended(p):
        return Converged(p, 0, 0.0, regular=False)
    least = FLOOR * max(1.0, largest(x / q.scale))  # smaller changes of x are rounding themselves
    while True:
        tangent.factor(p)
        z, noise, regular = _correct(q, tangent, p, dx, not path.sizes)
        dx[q.F] = z[: q.nf]
        path.add(largest(dx / q.scale) if isfinite(np.add.reduce(z)) else np.inf, max(noise, least))
        q.d.sweep.follow(p.x, q.d.sweep.e)
        if q.holonomic:
            p = q.point(p.x + dx, p.sigma + q.flexibility.size * z[q.nf :], given)
        else:
            p = _projected(q, p, dx, given)
        if path.ended(p):
            return Converged(p, len(path.sizes), path.noise, regular)
        dx = np.zeros_like(x)


def relaxed(
    q: StationaryEquations, tangent: Tangent, x: Array, sigma: Array, given: Prescribed
) -> tuple[Array, Array]:
    """x (nx,), sigma (ne,) where a motion from x without inertia, which a viscous damping of all coordinates slows
    down, comes to: linearly implicit Euler with growing steps (C. T. Kelley, D. E. Keyes, SIAM J. Numer. Anal. 35
    (1998) 508-523). It finds the path that goes on where another one ends, as of a slack chain that is pulled tight.

    Raises SingularMatrixError.
    """
    damping = q.flexibility.size * (q.free_scale.max() / q.free_scale) ** 2
    diagonal = np.arange(q.nf)
    dx = np.zeros_like(x)
    dx[q.P] = (given.x - x)[q.P]
    for factor in RELAXATIONS:
        p = q.point(x, sigma, given)
        with suppress(SingularMatrixError):
            tangent.factor(p)
        matrix = tangent.dense()
        matrix[diagonal, diagonal] += factor * damping
        try:
            z = np.linalg.solve(matrix, p.right - tangent.along(dx))
        except np.linalg.LinAlgError as error:
            raise SingularMatrixError(str(error)) from None
        dx[q.F] = z[: q.nf]
        q.d.sweep.follow(p.x, q.d.sweep.e)
        x, sigma, dx = p.x + dx, p.sigma + q.flexibility.size * z[q.nf :], np.zeros_like(x)
    return x, sigma


def _correct(q: StationaryEquations, tangent: Tangent, p: Iterate, dx: Array, first: bool) -> tuple[Array, float, bool]:
    """The correction, its noise, and whether the matrix is regular. Of minimum norm where it is not; at an iterate,
    which satisfies the constraints to first order only, what is not in the range of the matrix is left to the next
    correction."""
    try:
        z, noise = correction(q, tangent, p, dx)
        if isfinite(np.add.reduce(z)):
            return z, noise, True
    except SingularMatrixError:
        pass
    return *minimum_norm(q, tangent, p, dx, first), False


def _projected(q: StationaryEquations, p: Iterate, dx: Array, given: Prescribed) -> Iterate:
    """Wheels: the configuration that the degrees of freedom have after the correction, with the stresses that balance
    it; those of calculable deformations follow from their law. A wheel's turn is cyclic and large, its Euler parameters
    must not leave the constraints."""
    d = q.d
    n, k = d.numbering, d.kinematics
    e = d.sweep.e + d.sweep.rate(dx)
    e[q.constrained] = given.e[q.constrained]
    k.start_at(p.x, d.sweep.e)
    try:
        k.position(p.x + dx, np.where(np.arange(n.ne) < n.e_class["kinematic"].stop, e, 0.0))
    except AnalysisError as error:
        raise Astray(str(error), error.code) from None
    x = k.x
    p = q.point(x, p.sigma, given)
    sigma, still, calculable = p.sigma.copy(), np.zeros(n.ne), n.e_class["calculable"]
    law = d.law(d.sweep.e, still) - d.law(still, still) + q.law_offset(p.motion, p.user)
    sigma[calculable] = law[calculable]
    p = q.point(x, sigma, given)
    return q.point(x, q.balanced(p), given)


FARTHEST = 16.0  # weight of a state in the prediction: 6 for equal parts, more when the parts have grown


class Known(NamedTuple):
    """A state of the path: its place on the way (0 to 1 initial, 1 to 2 additional loading), x, sigma."""

    path: float
    x: Array
    sigma: Array


def predicted(known: list[Known], path: float, fixed: slice) -> Known:
    """Lagrange's polynomial through the known states; fewer of them if they are close together."""
    weights = _lagrange(known, path)
    while len(known) > 1 and max(map(abs, weights)) > FARTHEST:
        known = known[1:]
        weights = _lagrange(known, path)
    x, sigma = np.dot(weights, [k.x for k in known]), np.dot(weights, [k.sigma for k in known])
    x[fixed] = known[-1].x[fixed]  # no iteration corrects them: rounding would grow from level to level
    return Known(path, x, sigma)


def _lagrange(known: list[Known], path: float) -> list[float]:
    """Weights of the polynomial through the known states, at a place."""
    at = [k.path for k in known]
    return [prod((path - b) / (a - b) for j, b in enumerate(at) if j != i) for i, a in enumerate(at)]
