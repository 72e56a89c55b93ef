"""Is the computed motion a continuous one? Dead points that are passed, and branches that are changed without a word.

The integrator sees the degrees of freedom. At a dead point one of them has an extreme value while the other coordinates
go on: they pass to the other branch of the position, the determinant of V[E, U] changes its sign, and all velocities
are continuous. A step may miss this in two ways. The motion is *reflected*: the degree of freedom turns, the position
stays on its branch, and the dependent velocities jump to their opposites. Or the position *jumps*: Newton's method ends
on the other branch where the dead point is not reached, and the dependent velocities change their signs with it.

Velocities and accelerations can be compared where the dead point is farther away than the degrees of freedom are known.
Its distance is that of the fold, s^2/2|c| in the residual along its singular vector (`spacar.kinematics.fold`); they
are known to ERROR. With a the last such step before a dead point and b the first one behind it, and w the singular
vector,

    w.v_a and w.v_b have the same sign:  the dead point was passed, which is said
    opposite signs and another sign of the determinant:  the position has jumped
    opposite signs on one branch:  reflected if
        |v_b - v_a - h (a_a + a_b)/2| > h max(|a_a|, |a_b|) + max(|v_a|, |v_b|)/10

for any coordinate (a tenth: the trapezoidal rule of a smooth motion with one radian a step errs by 8 %). Motions that
really turn as fast as that do so too, in steps that are long for them: so the degrees of freedom are interpolated
(Hermite) and the step is halved as long as its parts fail. The motion was reflected where a position in between cannot
be reached, is another one from the two ends, or is nearer to the dead point than they are known.

So near to a dead point that the velocities are lost the integration may also stop: where the position is not where
v_a leads within half of the way and 4 h^2 |a_a|, it is an error too.

To be cheap, steps are looked at only where the determinant has changed its sign, or has a minimum of at most half of
its last maximum (at a fold it falls to zero, and steps that straddle it see it fall by that much); with the second
test alone, and always, where there is no cheap determinant.
"""

from __future__ import annotations

from collections import deque
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.evaluator import Evaluator
from spacar.dynamics.loaded_mechanism import NOISE, Accepted, Moving, unexplained
from spacar.errors import AnalysisError, Report
from spacar.kinematics.fold import fold
from spacar.kinematics.regularity import PositionMatrix

HALF = float(np.log(0.5))
MORE = 4.0  # times the last acceleration that is known: what it may become while the dead point is passed
REMEMBERED = 200  # steps: towards a dead point they become shorter, by orders of magnitude
DEEPEST = 12  # halvings
SAME = float(np.sqrt(np.finfo(float).eps))  # scaled difference of positions: half of the digits, more than rounding


class Continuity:
    """Looks at the accepted steps of one motion. `errors`: absolute and relative one of the degrees of freedom;
    `resolved`: steps follow every vibration, so that accelerations tell what happens within them."""

    def __init__(
        self, evaluator: Evaluator, matrix: PositionMatrix, report: Report, errors: tuple[float, float],
        resolved: bool = True,
    ) -> None:  # fmt: skip
        self.evaluator, self.matrix, self.report, self.errors = evaluator, matrix, report, errors
        self.resolved = resolved
        self.scale = evaluator.model.mechanism.scale
        self.steps: deque[Accepted] = deque(maxlen=REMEMBERED)
        self.peak = -np.inf  # of the determinant, since its last minimum
        self.entered: tuple[Accepted, float] | None = None  # last step before a dead point that is being left, its time

    def resume(self, before: list[Accepted], peak: float) -> None:
        """Go on behind steps that were looked at elsewhere; `peak` of the determinant since its last minimum."""
        self.steps.clear()
        self.steps.extend(before)
        self.peak = peak

    def check(self, t: float, y: Array) -> None:
        """Raises AnalysisError 'position.singular'."""
        at, steps = self.evaluator.moving(), self.steps
        if at is None:
            return
        if steps and not at.t > steps[-1].at.t:
            steps.clear()
        sign, size = self.matrix.determinant() if self.matrix.has_determinant else (1.0, 0.0)
        before, now = steps[-1] if steps else None, Accepted(y.copy(), at, sign, size)
        steps.append(now)
        if before is None:
            self.peak, self.entered = size, None
        elif not self.matrix.has_determinant:
            if unexplained(before.at, at, self.scale).any():
                self._closer().turned(before, now)
        elif self.entered is not None:
            self._leave(now)
        elif sign != before.sign or (size > before.size and before.size <= self.peak + HALF):
            self._enter(before, now)
        else:
            self.peak = max(size, self.peak)

    def _enter(self, before: Accepted, now: Accepted) -> None:
        """A sign has changed, or the determinant had a minimum at `before`."""
        self.peak = now.size
        closer, steps = self._closer(), list(self.steps)
        if before.sign == now.sign and not closer.near(before):
            for a, b in pairwise(steps[-3:]):
                if a.sign == b.sign and unexplained(a.at, b.at, self.scale).any():
                    closer.turned(a, b)
            return
        steps.pop()
        while len(steps) > 1 and closer.near(steps[-1]):
            steps.pop()
        self.entered = steps[-1], before.at.t
        self._leave(now, closer)

    def _leave(self, now: Accepted, closer: Closer | None = None) -> None:
        closer = closer or self._closer()
        assert self.entered is not None
        a, t = self.entered
        if closer.near(now):
            if strayed(a.at, now.at, self.scale).any():
                raise _stopped(t, "the motion was stopped or turned instead of passing it")
            return
        self.entered, self.peak = None, now.size
        on = closer.goes_on(a, now)
        if a.sign != now.sign and not on:
            raise _stopped(t, "the position jumped to another branch instead of passing it")
        if not on:
            if unexplained(a.at, now.at, self.scale).any():
                raise _stopped(t, "the integration turned back instead of passing it")
            return
        self.report.add(
            f"warning: between t = {a.at.t:.9g} and {now.at.t:.9g} the degrees of freedom passed a singular position"
            f" (dead point) at about t = {t:.6g}; the accuracy of the integration is lost there: choose other degrees"
            " of freedom"
        )

    def _closer(self) -> Closer:
        return Closer(self.evaluator.settled().companion(), *self.errors, self.resolved)


def strayed(a: Moving, b: Moving, scale: Array) -> NDArray[np.bool_]:
    """Coordinates that did not go from a to b as their velocity at a demands, for several times its acceleration."""
    h = b.t - a.t
    way = h * np.abs(a.xd)
    noise = NOISE * scale * (way / scale).max(initial=0.0)
    return np.asarray(np.abs(b.x - a.x - h * a.xd) > MORE * h * h * np.abs(a.xdd) + 0.5 * way + noise)


class Closer:
    """Looks at steps with a NumPy evaluator of its own. Its checks raise AnalysisError."""

    def __init__(self, dynamics: Dynamics, atol: float, rtol: float, resolved: bool = True) -> None:
        self.d, self.atol, self.rtol, self.resolved = dynamics, atol, rtol, resolved
        self.scale = dynamics.mechanism.scale

    def goes_on(self, a: Accepted, b: Accepted) -> bool:
        """Does the motion that is not determined at a dead point between both go on in its direction?"""
        w = min((self._fold(p) for p in (a, b)), key=lambda found: found[0])[1]
        U = self.d.kinematics.U
        before, after = (float(w @ (p.at.xd / self.scale)[U]) for p in (a, b))
        return before * after >= 0.0

    def near(self, p: Accepted) -> bool:
        """Is the dead point nearer than the degrees of freedom are known?"""
        return self._fold(p)[2]

    def turned(self, a: Accepted, b: Accepted) -> None:
        """On one branch: has the motion turned, or was it reflected?

        Where steps pass over vibrations the rates of the degrees of freedom may have changed unexplained; then those of
        b, at the position of a, make the velocities of b.
        """
        if not self.resolved:
            p = self.d.n_positions
            with_rates = self._place(a, a.at.t, np.concatenate((a.y[:p], b.y[p:])))
            if not unexplained(with_rates.at, b.at, self.scale).any():
                return
        self._between(a, b, 0)

    def _between(self, a: Accepted, b: Accepted, depth: int) -> None:
        if depth > DEEPEST or not unexplained(a.at, b.at, self.scale).any():
            return
        t, y = self._middle(a, b)
        try:
            m = self._place(a, t, y)
            other = self._place(b, t, y)
        except AnalysisError as error:
            raise _stopped(t, f"the integration turned back instead of passing it ({error})") from None
        if np.abs((m.at.x - other.at.x) / self.scale).max(initial=0.0) > SAME:
            raise _stopped(t, "the integration turned back instead of passing it")
        if self.near(m):
            raise _stopped(t, "the integration turned back, but nearer to it than ERROR: it may as well pass it")
        self._between(a, m, depth + 1)
        self._between(m, b, depth + 1)

    def _middle(self, a: Accepted, b: Accepted) -> tuple[float, Array]:
        """State in the middle of a step: quintic polynomials, cubic ones of the kinematic coordinates, and of all where
        the accelerations are those of vibrations that the step passes over."""
        d, n = self.d, self.d.numbering.nddof
        h, p = b.at.t - a.at.t, d.n_positions
        f0, f1 = self._derivative(a), self._derivative(b)
        rise = (b.y - a.y)[:p]
        y = 0.5 * (a.y + b.y)
        y[:p] += (h / 8.0) * (f0 - f1)[:p]
        if not self.resolved:
            y[p:] = (1.5 / h) * rise[:n] - 0.5 * y[p:]
            return a.at.t + 0.5 * h, y
        v0, v1, a0, a1 = a.y[p:], b.y[p:], f0[p:], f1[p:]
        y[:n] += (h / 32.0) * (v0 - v1) + (h * h / 64.0) * (a0 + a1)
        y[p:] = (15.0 / 8.0 / h) * rise[:n] - (7.0 / 16.0) * (v0 + v1) + (h / 32.0) * (a1 - a0)
        return a.at.t + 0.5 * h, y

    def _derivative(self, p: Accepted) -> Array:
        self.d.kinematics.start_at(p.at.x, p.at.e)
        self.d.last = None
        return self.d.rhs(p.at.t, p.y)

    def _place(self, start: Accepted, t: float, y: Array) -> Accepted:
        """The state y at t, reached from another step. Raises AnalysisError."""
        d = self.d
        self._derivative(start)
        d.rhs(t, y)
        at = d.moving()
        assert at is not None
        return Accepted(y, at, 0.0, 0.0)

    def _fold(self, p: Accepted) -> tuple[float, Array, bool]:
        """Smallest singular value of the position, its vector w (len(U),), and whether the dead point is nearer than
        the degrees of freedom are known."""
        d = self.d
        self._derivative(p)
        k, n = d.kinematics, d.numbering
        rows, columns = 1.0 / d.mechanism.deformation_scale[k.E], k.scale[k.U]
        s, u, w, bend = fold(k.sweep, k.velocity_system, k.E, k.U, rows, columns)
        sigma = np.zeros(n.ne)
        sigma[k.E] = u * rows
        xs, es = n.x_class["dynamic"], n.e_class["dynamic"]
        force, m = k.sweep.rate_transposed(sigma)[xs], d.n_xm
        error = self.atol + self.rtol * np.abs(p.y[: n.nddof])
        known = float(np.abs(force) @ error[:m] + np.abs(sigma[es]) @ error[m:])
        return s, w, bool(s * s <= 2.0 * abs(bend) * known)


def _stopped(t: float, what: str) -> AnalysisError:
    return AnalysisError(
        f"singular position at t = {t:.9g}: at this dead point of the degrees of freedom {what}; choose other degrees"
        " of freedom, or a smaller ERROR",
        "position.singular",
    )
