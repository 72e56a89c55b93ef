"""The configuration of a mechanism and the linear map from given to dependent velocities.

Position level (theory-system.md 1.1): the holonomic rows h = fixed, input, dynamic and kinematic deformations determine
the calculable coordinates c,  D_h(x) = e_h.  Velocity level: the rows E = fixed, input and dynamic (slips included)
determine U = calculable and kinematic coordinates,  V[E,U] xd_U = ed_E - V[E,rest] xd_rest.  Without slips both
matrices are the same.

Newton's method starts from a guess (the motion extrapolated in time, if the caller knows it) or from the last
configuration, moved by the first order prediction with the last factorization. It has converged when
max |dx_i|/scale_i <= `within` (1e-11; scale: size of the mechanism for positions, 1 for angles and Euler
parameters); the correction that passes the test is still applied, and since convergence is quadratic the position is
accurate to rounding, while V and so the velocity are those of a configuration that differs by the last correction. An
integrator may ask for less in intermediate states, or for more, so that this difference does not disturb its error
estimates. There are at most 20 iterations; a correction that makes the residual grow is halved, at most 5 times.

Rounding sets how small corrections and residuals can become. With s = max(1, |x_i|/scale_i, |e_i|/scale_i) the scaled
residual is known to delta = 64 eps s (a few dozen operations make a deformation of a spatial beam). A correction that
follows one below 1e-11 or delta is as small as rounding allows and passes always. With an ill-conditioned matrix D' a
residual of delta makes corrections up to |D'^-1| delta, which may stay above both: two residuals below delta one after
the other are therefore accepted as well, if the position is determined. It is not near a double root (a dead point),
where the residual is eps while the position is wrong by sqrt(eps): `spacar.kinematics.constraint_matrices`.

D(x) = e has several solutions (a rigid beam may point to either side), so a target is reached continuously: when an
iteration fails, or ends farther than 0.8 model lengths or rad from where it began, the way to the target is halved, at
most 10 times; what joined nodes go the same way along an axis is no distance. Where the prediction already goes
farther, the way is divided at once, and of many turns whole periods are left out (`whole_turns`); so is that from the
reference configuration if the determinant of D' changes its sign. A way that is shorter than delta is not divided: its
ends are one position to rounding. At a dead point delta is what rounding knows of the given values, and sqrt(delta) of
the model what it knows of the position; two iterates that meet the constraints there to delta, without being single
roots, end the iteration, as those that follow only wander in that range.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError
from spacar.kinematics.constraint_matrices import ConstraintMatrices
from spacar.kinematics.element_sweep import ElementSweep
from spacar.kinematics.whole_turns import Period, followed
from spacar.linear_systems import SingularMatrixError
from spacar.linear_systems.linear_system import matrix
from spacar.mechanism.mechanism import Mechanism

CONVERGED = 1e-11  # largest scaled correction that ends Newton's iteration: the relative error of velocities
MAX_ITERATIONS = 20
MAX_HALVINGS = 5
MOST_FOLDED = 2  # iterates at a double root; a third one was not seen to leave it
# Chosen: when a residual doubles but stays below this, its correction is not halved. It accepts nothing. With rounding
# as the only excuse, the ways to stages beyond a dead point are cut hundreds of times, for the same result.
GROWN = 1e-6
LARGEST_JUMP = 0.8  # rad or model lengths between two configurations
FARTHEST_GUESS = 0.5 * LARGEST_JUMP  # from farther Newton's method could end at another solution
MAX_DEPTH = 10
MOST_PREDICTED = 10.0 * LARGEST_JUMP  # a first-order prediction that goes farther says nothing
FIRST_PIECES = 64  # of the way from a reference configuration that has another sign of the determinant
MOST_PIECES = 50_000  # that are followed; a stage of a step that is much too long may be at any distance


class Unplaced(Exception):
    """A Newton iteration that did not reach its target: x, residual, history, number of iterations, or x, error of a
    singular matrix. As an explanation costs more than a trial with smaller steps, it is made only at the end."""


class Kinematics(ConstraintMatrices):
    """Mutable state of one mechanism: configuration x, deformations and factorizations at x.

    Raises AnalysisError 'mechanism.count' when the numbers of unknowns and equations differ.
    """

    def __init__(self, mechanism: Mechanism, kind: str | None = None, sweep: ElementSweep | None = None) -> None:
        super().__init__(mechanism, kind, sweep)
        n = self.numbering
        if not n.is_square:
            from spacar.kinematics.failure import count_failure

            raise count_failure(self)
        self.e = np.zeros(n.ne)  # at x
        self.e_given = np.zeros(n.ne)
        self.iterations = 0  # Newton iterations of the last position
        self.period: Period | None = None  # of the given values
        self._sign = 0.0  # of the determinant at the reference configuration, until the first position is found

    # -- position -----------------------------------------------------------------------------------------------
    def move(self, x_given: Array, e_given: Array) -> None:
        """Go to the configuration with these given values, from the reference configuration at the first call.

        x_given (nx,) holds the given coordinates (entries of U are ignored), e_given (ne,) the given deformations.
        Raises AnalysisError 'position.no-convergence' or 'position.singular'.
        """
        self.begin()
        self.position(x_given, e_given)

    def begin(self) -> None:
        """At the first call: the way to the first given values starts with the deformations of the present x.

        These need not be the wanted ones in the reference configuration (DRPINBOD).
        """
        if self.is_factored:
            return
        self.sweep.strain(self.x)
        self.e_given = self.sweep.e.copy()
        self._accept()
        with suppress(SingularMatrixError):  # then without a prediction: the iteration will say what is singular
            self.refactor()
            self._sign = self.position_system.determinant_sign() if len(self.c) else 0.0

    def position(self, x_given: Array, e_given: Array) -> None:
        """Solve D_h(x) = e_h from the present configuration; leaves V and its factorization at the solution."""
        self._solve(x_given, e_given, None, None, None, CONVERGED)

    def place(
        self, x_given: Array, e_given: Array, v_given: Array, e_rate: Array, guess: Array | None = None,
        within: float = CONVERGED,
    ) -> Array:  # fmt: skip
        """Position and velocity together: xd (nx,) with V[E] xd = e_rate[E]; arguments as `position`, `dependent`.

        `guess` (nx,) is a good estimate of the calculable coordinates; `within`: largest scaled correction that ends
        Newton's iteration.
        """
        velocity = self._solve(x_given, e_given, v_given, e_rate, guess, within)
        return self.dependent(v_given, e_rate) if velocity is None else velocity

    def _solve(
        self, x_given: Array, e_given: Array, v_given: Array | None, e_rate: Array | None, guess: Array | None,
        within: float, depth: int = 0,
    ) -> Array | None:  # fmt: skip
        x, c = x_given.copy(), self.c
        x_old, e_old = self.x, self.e_given
        if guess is not None:
            x[c] = guess[c]
            if largest((x - x_old)[c] / self.scale[c]) > FARTHEST_GUESS and self._jump(x_old, x) > FARTHEST_GUESS:
                guess = None
        if guess is None:
            x[c] = x_old[c]
        self.target = e_given
        if self.is_factored and guess is None:
            residual = self.sweep.rate(x - x_old)[self.h] - (e_given - e_old)[self.h]
            if residual.any():
                with suppress(SingularMatrixError):
                    x[c] -= self.position_system.solve(residual)
            ahead = self._jump(x_old, x)
            if depth == 0 and LARGEST_JUMP < ahead < MOST_PREDICTED:
                self.sweep.follow(x_old, self.e)
                self._approach(x_given, e_given, within, int(np.ceil(ahead / LARGEST_JUMP)), 1)
                return self._solve(x_given, e_given, v_given, e_rate, None, within, 1)
        self._factored = self._waiting = False
        elsewhere, sign, self._sign = False, self._sign, 0.0
        try:
            velocity = self._newton(x, e_given, v_given, e_rate, within)
            near = self._jump(x_old, x) <= LARGEST_JUMP
            elsewhere = near and sign != 0.0 and self.position_system.determinant_sign() != sign
            if not elsewhere and (near or depth == MAX_DEPTH):
                self.e_given = e_given
                self._accept()
                return velocity
        except Unplaced as failure:
            still = self._distance(x_given, e_given - e_old) <= self.rounding(x_old, e_given[self.h])
            if depth == MAX_DEPTH or (guess is None and still):
                from spacar.kinematics.failure import explained

                raise explained(self, *failure.args) from None
        self.x, self._factored = x_old, False
        self.sweep.follow(x_old, self.e)
        far = depth == 0 and self._distance(x_given, e_given - e_old) > LARGEST_JUMP
        if far and not self.numbering.nkddof and self.skip_turns(x_given, e_given, within):
            return self._solve(x_given, e_given, v_given, e_rate, None, within)
        jumps = 0.0 if depth else self._distance(x_given, e_given - self.e_given) / LARGEST_JUMP
        pieces = FIRST_PIECES if elsewhere else int(np.ceil(jumps)) if 2.0 < jumps <= MOST_PIECES else 2
        self._approach(x_given, e_given, within, pieces, depth + 1)
        return self._solve(x_given, e_given, v_given, e_rate, None, within, depth + 1)

    def skip_turns(self, x_given: Array, e_given: Array, within: float = CONVERGED) -> bool:
        """Go by whole periods as near as possible to given values; False where none could be left out."""
        nx, scale = len(self.x), np.concatenate((self.scale, self.mechanism.deformation_scale))
        rows = np.concatenate((np.setdiff1d(np.arange(nx), self.c), nx + self.h))
        known = max(CONVERGED, self.rounding(x_given, e_given[self.h]))

        def ahead() -> tuple[Array, Array]:
            first, way = np.concatenate((self.x, self.e_given)) / scale, np.zeros(len(scale))
            way[rows] = (np.concatenate((x_given, e_given)) / scale - first)[rows]
            return first, way

        def go(first: Array, way: Array, guess: Array | None, depth: int) -> Array:
            given = (first + way) * scale
            self._solve(given[:nx], given[nx:], None, None, guess, within, depth)
            return np.concatenate((self.x, self.e)) / scale

        first, way = ahead()
        if self.period is None or not self.period.divides(way, known):
            self.period = followed(way, lambda part: go(first, part * way, None, 1), known)
            first, way = ahead()
        n = 0 if self.period is None else self.period.times(way)
        x_old, e_old, given_old = self.x, self.e, self.e_given
        if self.period is not None and n:
            target = np.concatenate((x_old, e_old)) / scale + n * self.period.shift
            self.start_at(target[:nx] * self.scale, target[nx:] * scale[nx:])
            with suppress(AnalysisError):
                if largest(go(first, n * self.period.way, self.x, MAX_DEPTH) - target) <= abs(n) * known:
                    return True
            self.start_at(x_old, e_old)
            self.e_given, self.period = given_old, None
        return False

    def _accept(self) -> None:
        self.e = self.sweep.e.copy()
        self.sweep.follow(self.x, self.e)

    def _approach(self, x_given: Array, e_given: Array, within: float, pieces: int, depth: int) -> None:
        """All but the last of equal pieces of the way from the present configuration to the given values."""
        x_old, e_old = self.x, self.e_given
        for k in range(1, pieces):
            part = k / pieces
            x, e = x_old + part * (x_given - x_old), e_old + part * (e_given - e_old)
            self._solve(x, e, None, None, None, within, depth)

    def _jump(self, a: Array, b: Array) -> float:
        """Largest scaled difference of two configurations, without what joined nodes go the same way along an axis:
        such a translation deforms no element."""
        d = (b - a) / self.scale
        size = largest(d)
        if size <= FARTHEST_GUESS or not size < np.inf:
            return size
        k = self.numbering.translations
        moved, k = d[k >= 0], k[k >= 0]
        low, high = np.full((2, len(d)), np.inf)
        np.minimum.at(low, k, moved)
        np.minimum.at(high, k, -moved)
        d[self.numbering.translations >= 0] -= np.maximum(low[k], 0.0) - np.maximum(high[k], 0.0)
        return largest(d)

    def _distance(self, x_given: Array, e: Array) -> float:
        """Largest scaled change of the given coordinates and, by e (ne,), deformations."""
        x = x_given.copy()
        x[self.c] = self.x[self.c]
        return max(self._jump(self.x, x), largest(e[self.h] / self.h_scale))

    def _newton(
        self, x: Array, e_given: Array, v_given: Array | None, e_rate: Array | None, within: float
    ) -> Array | None:
        """Newton's iteration from x (changed in place); one solve also gives the velocity where both matrices agree."""
        c, h, sweep = self.c, self.h, self.sweep
        target, scale = e_given[h], self.scale[c]
        history: list[float] = []
        correction = np.zeros(len(c))
        halvings = 0
        size = np.inf
        rounding = 0.0  # evaluated only when the usual test is not passed
        folded = 0  # iterates that meet the constraints to rounding without being single roots
        together = v_given is not None and self.velocity_map_is_position_map
        for iteration in range(1, MAX_ITERATIONS + 1):
            sweep.strain(x)
            residual = sweep.e[h] - target
            norm = largest(residual / self.h_scale)
            grown = bool(history) and norm > 2.0 * history[-1]
            if not norm < np.inf or (grown and norm > max(GROWN, self.rounding(x, target))):
                if halvings == MAX_HALVINGS:
                    raise Unplaced(x, residual, history, iteration)
                halvings += 1
                correction *= 0.5
                x[c] += correction
                continue
            history.append(norm)
            halvings = 0
            right = residual
            if together:
                right = np.empty((len(residual), 2))
                right[:, 0] = residual
                right[:, 1] = (e_rate - sweep.rate(v_given))[self.E]  # type: ignore[arg-type,operator]
            try:
                self._factor_position()
                solution = self.position_system.solve(right)
            except SingularMatrixError as error:
                raise Unplaced(x, error) from None
            correction = solution[:, 0] if together else solution
            x[c] -= correction
            size, before = largest(correction / scale), size
            if size > within and before > CONVERGED:
                rounding = self.rounding(x, target)
            done = size <= within or before <= CONVERGED or before <= rounding
            if not done and len(history) > 1 and max(history[-2:]) <= rounding:
                done = self.is_single_root(self.of_position, rounding)
                folded += 1
                if not done and folded == MOST_FOLDED:
                    raise Unplaced(x, residual, history, iteration)
            if done:
                self.x = x
                self.iterations = iteration
                if not self.velocity_map_is_position_map:
                    self._factor_velocity()
                self._factored = True
                if not together:
                    return None
                v = v_given.copy()  # type: ignore[union-attr]
                v[self.U] = solution[:, 1]
                return v
        raise Unplaced(x, residual, history, MAX_ITERATIONS)

    def refresh(self) -> None:
        """x was changed from outside: evaluate and factor there."""
        self.sweep.strain(self.x)
        self.refactor()

    def stand_at(self, x: Array, e: Array) -> None:
        """x (nx,), e (ne,), where the sweep is, were found elsewhere: V there is factored when its factors are asked
        for."""
        self.start_at(x, e)
        self._waiting = True

    def start_from(self, other: Kinematics) -> None:
        """Take over the configuration of another evaluator of the same mechanism."""
        self.x, self.e_given = other.x.copy(), other.e_given.copy()
        self.e = other.e.copy()
        self.sweep.branch[:] = other.sweep.branch

    def start_at(self, x: Array, e: Array) -> None:
        """Begin the next Newton iteration at x (nx,) with angles near those of e (ne,), without a prediction."""
        self.x, self.e, self.e_given = x.copy(), e.copy(), e.copy()
        self.sweep.follow(x, e)
        self._factored = self._waiting = False

    # -- velocity and acceleration ------------------------------------------------------------------------------
    def dependent(self, given: Array, e_rate: Array) -> Array:
        """Full vector v with V[E] v = e_rate[E]; `given` (nx,) or (nx, k) holds the other coordinates, zero on U.

        Serves velocities (e_rate = ed), accelerations (e_rate = edd - H(xd, xd)) and columns of transfer functions.
        """
        v = given.copy()
        right = e_rate[self.E]  # a copy
        right -= (self.sweep.rate(v) if v.ndim == 1 else self.sweep_rates(v))[self.E]
        v[self.U] = self.velocity_system.solve(right)
        return v

    def sweep_rates(self, v: Array) -> Array:
        """V v for several columns, (ne, k)."""
        shape = self.numbering.ne, self.numbering.nx
        return np.asarray(matrix(self.sweep.v_rows, self.sweep.v_columns, self.sweep.v_entries, shape) @ v)

    def reactions(self, force: Array, sigma: Array) -> None:
        """Multipliers: write sigma[E] so that (force + V^T sigma) vanishes on U (theory-system.md (10)).

        force (nx,) is M xdd + h - f; sigma (ne,) holds the constitutive stresses of the rows outside E.
        """
        sigma[self.E] = 0.0
        residual = force + self.sweep.rate_transposed(sigma)
        sigma[self.E] = self.velocity_system.solve_transposed(-residual[self.U])


def largest(values: Array) -> float:
    """max |values|, nan if any is; 0 when empty."""
    return float(np.abs(values).max()) if len(values) else 0.0
