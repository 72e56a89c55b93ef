"""Is the computed motion a continuous one? Dead points that are passed, and branches that are changed without a word.

The integrator sees the degrees of freedom. At a dead point one of them has an extreme value while the other coordinates
go on: they pass to the other branch of the position, the determinant of V[E, U] changes its sign, and all velocities
are continuous. A step may miss this in two ways. The motion is *reflected*: the degree of freedom turns, the position
stays on its branch, and the dependent velocities jump to their opposites. Or the position *jumps*: Newton's method ends
on the other branch where the dead point is not reached, and the dependent velocities change their signs with it.

Velocities and accelerations can be compared where the dead point is farther away than the degrees of freedom are known.
Its distance is that of the fold, s^2/2|c| in the residual along its singular vector (`fold`); they are known to ERROR.
With a the last such step before a dead point and b the first one behind it, and w the singular vector,

    w.v_a and w.v_b have the same sign:  the dead point was passed, which is said
    opposite signs and another sign of the determinant:  the position has jumped
    opposite signs on one branch:  turned, or reflected; looked at closer

and likewise any step that is suspected (below). Looking closer is following the path of the degrees of freedom: they
are interpolated (Hermite), and the step is halved until no dead point lies in any part and the velocities are explained
by the accelerations

    |v_b - v_a - h (a_a + a_b)/2| <= h max(|a_a|, |a_b|) + max(|v_a|, |v_b|)/10

(a tenth: the trapezoidal rule of a smooth motion with one radian a step errs by 8 %), or where a vibration is too fast
for that, the position at b is the one that is reached from a. The smallest singular value s of the scaled matrix, with
its vectors u and w, changes with the rate

    ds/dt = u^T H(w, v)         (H: second derivative of the deformations, v: velocity)

so that a dead point is s/|ds/dt| away, and a part with h |ds/dt| <= s/2 at both ends does not reach it (the contraction
of Kantorovich, h |v| times the curvature, along the one direction that matters; the half is for a ds/dt that changes).
The motion was reflected where a position in between cannot be reached, is another one from the two ends, or is nearer
to the dead point than the degrees of freedom are known. A motion that turns before a dead point passes.

So near to a dead point that the velocities are lost the integration may also stop: where the position is not where v_a
leads within half of the way and 4 h^2 |a_a|, it is an error too. Where it turns there within a step or two, so that
turning is as good as passing, a warning says so; and also where no step is known to be farther than ERROR from it.

To be cheap, only suspected steps are looked at: the determinant of all states evaluated in a step tells. At a fold it
is zero and about linear in time on both sides. Suspected is a step in which its sign changes, or

    in which a state lies below 2/3 of both ends            (INSIDE)
    whose begin is a minimum, below half of the last maximum  (HALF)
    in which a coordinate goes farther than one radian or length of the model, with a state below 4/5 of an end  (WIDE)

Were steps without states inside, a zero in the middle of a long one would lie between two equal ends. With the states
of the codes, fractions c of the step, the two rules find a zero wherever it lies in the step: halfway between two of
the c it leaves at most 0.29 of the lower end with 853, 0.56 with 155, 0.61 with 553, or the end itself is a minimum.
Adams steps have no states inside; a zero in the middle is seen in steps up to one radian of |sin|, which they do not
reach: no position is placed farther than 0.8 rad from the one before. Beyond one radian (wide ERROR) a motion may turn
on its way to the dead point between two states, which a determinant that varies is enough to suspect. The start state
belongs to the first step. Where there is no cheap determinant the velocities alone are asked, always.
"""

from __future__ import annotations

from collections import deque
from itertools import pairwise
from math import sqrt
from typing import NamedTuple

import numpy as np

from spacar.arrays import EPS, Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.evaluator import Evaluator
from spacar.dynamics.loaded_mechanism import NOISE, Accepted, Moving, unexplained
from spacar.errors import AnalysisError, Report
from spacar.kinematics.regularity import PositionMatrix

HALF, INSIDE, WIDE = float(np.log(0.5)), float(np.log(2.0 / 3.0)), float(np.log(0.8))
FAR_APART = 1.0  # rad or model lengths in a step: beyond, the determinant need not be linear about its zeros
TURNING = 0.5  # part of the largest velocity of a motion that turns by which a step may change it: a reflection, by 2
APART = 0.5  # part of the way to a dead point that a step without one may go
MORE = 4.0  # times the last acceleration that is known: what it may become while the dead point is passed
REMEMBERED = 200  # steps: towards a dead point they become shorter, by orders of magnitude
DEEPEST = 40  # halvings; the path is followed to the dead point, ERROR ends that before
MET = 1e-6  # part of the duration: a dead point that is nearer has ended an integration that cannot go on
STANDING = 2  # steps in a row that rounding cannot tell from a dead point
SAME = sqrt(EPS)  # scaled difference of positions: half of the digits, more than rounding


class Continuity:
    """Looks at the accepted steps of one motion. `errors`: absolute and relative one of the degrees of freedom;
    `resolved`: steps follow every vibration, so that accelerations tell what happens within them."""

    def __init__(
        self, evaluator: Evaluator, matrix: PositionMatrix, report: Report, errors: tuple[float, float], resolved: bool
    ) -> None:
        self.evaluator, self.matrix, self.report, self.errors = evaluator, matrix, report, errors
        self.resolved = resolved
        self.scale = evaluator.model.mechanism.scale
        self.steps: deque[Accepted] = deque(maxlen=REMEMBERED)
        self.peak = -np.inf  # of the determinant, since its last minimum
        self.entered: tuple[Accepted, float] | None = None  # last step before a dead point that is being left, its time
        self.crossings = 0  # sign changes of the determinant since then
        if matrix.has_determinant:
            evaluator.sample()

    def resume(self, before: list[Accepted], peak: float) -> None:
        """Go on behind steps that were looked at elsewhere; `peak` of the determinant since its last minimum."""
        self.steps.clear()
        self.steps.extend(before)
        self.peak = peak

    def check(self, t: float, y: Array) -> None:
        """Raises AnalysisError 'position.singular'."""
        at, steps = self.evaluator.moving(), self.steps
        low, changed = self.evaluator.sampled()
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
            self.crossings += sign != before.sign
            self._leave(now)
        elif (
            sign != before.sign
            or changed
            or low <= min(before.size, size) + INSIDE
            or (size > before.size and before.size <= self.peak + HALF)
            or (low <= max(before.size, size) + WIDE and goes_far(before.at, at, self.scale))
        ):
            self._enter(before, now)
        else:
            self.peak = max(size, self.peak)

    def _enter(self, before: Accepted, now: Accepted) -> None:
        """A sign has changed, or the determinant had a minimum at `before` or in the step from there."""
        self.peak = now.size
        closer, steps = self._closer(), list(self.steps)
        if before.sign == now.sign and not closer.near(before):
            for a, b in pairwise(steps[-3:]):
                if a.sign == b.sign:
                    closer.turned(a, b)
            return
        steps.pop()
        while len(steps) > 1 and closer.near(steps[-1]):
            steps.pop()
        self.entered, self.crossings = (steps[-1], before.at.t), int(before.sign != now.sign)
        self._leave(now, closer)

    def _leave(self, now: Accepted, closer: Closer | None = None) -> None:
        """Decide what the motion did at the dead point, as soon as that is farther away than it is known."""
        closer = closer or self._closer()
        assert self.entered is not None
        a, t = self.entered
        if closer.near(now):
            if strayed(a.at, now.at, self.scale):
                raise _stopped(t, "the motion was stopped or turned instead of passing it")
            if closer.stands([*self.steps][-STANDING:]):
                raise _stopped(t, "the motion comes to stand, where positions are not determined to rounding")
            return
        self.entered, self.peak = None, now.size
        on = closer.goes_on(a, now)
        if a.sign != now.sign and not on:
            raise _stopped(t, "the position jumped to another branch instead of passing it")
        if not on:
            if unexplained(a.at, now.at, self.scale).any():
                raise _stopped(t, "the integration turned back instead of passing it")
            self._came_back(closer, a, now, t)
            return
        self._passed(a, now, t)

    def finish(self) -> None:
        """The motion ends here: was it leaving a dead point?"""
        if self.entered is None or not self.steps:
            return
        (a, t), now = self.entered, self.steps[-1]
        if a.sign != now.sign:
            self._passed(a, now, t)
        else:
            self._came_back(self._closer(), a, now, t)

    def ended(self, error: AnalysisError) -> None:
        """The integration has ended with this error: raises AnalysisError 'position.singular' where the last step is at
        a dead point."""
        duration = self.evaluator.model.mechanism.settings.duration or 0.0
        if self.steps and self._closer().meets(self.steps[-1], MET * duration):
            t = self.steps[-1].at.t
            raise AnalysisError(
                f"singular position at t = {t:.9g}: the motion comes to a dead point of the degrees of freedom, where"
                " the integration cannot go on; choose other degrees of freedom, or keep what is prescribed away from"
                " it", "position.singular", t=t,
            ) from error  # fmt: skip

    def _came_back(self, closer: Closer, a: Accepted, b: Accepted, t: float) -> None:
        """On the branch of before: it has turned, or passed twice while all was near, as with an ERROR that is wide."""
        if self.crossings:
            self._passed(a, b, t)
        elif closer.near(a) or not closer.turned_in_steps([p for p in self.steps if p.at.t >= a.at.t]):
            self._turned(a, b, t)

    def _passed(self, a: Accepted, b: Accepted, t: float) -> None:
        what = "a singular position (dead point)"
        if self.crossings > 1:
            what = "singular positions (dead points), the first"
        from spacar.kinematics.failure import other_release

        self.report.add(
            f"warning: between t = {a.at.t:.9g} and {b.at.t:.9g} the degrees of freedom passed {what} at about"
            f" t = {t:.6g}; the accuracy of the integration is lost there: choose other degrees of freedom"
            f"{other_release(self.evaluator.model.mechanism, a.at.x)}"
        )

    def _turned(self, a: Accepted, b: Accepted, t: float) -> None:
        self.report.add(
            f"warning: between t = {a.at.t:.9g} and {b.at.t:.9g} the degrees of freedom turned before a singular"
            f" position (dead point) at about t = {t:.6g}, but nearer to it than ERROR: they may as well pass it;"
            " choose other degrees of freedom, or a smaller ERROR"
        )

    def _closer(self) -> Closer:
        return Closer(self.evaluator.numpy_evaluator().fork(), *self.errors, self.resolved)


def goes_far(a: Moving, b: Moving, scale: Array) -> bool:
    """Does a coordinate go farther in a step than the watch sees with the states inside alone?"""
    fastest = (np.maximum(np.abs(a.xd), np.abs(b.xd)) / scale).max(initial=0.0)
    return bool((b.t - a.t) * fastest > FAR_APART)


def strayed(a: Moving, b: Moving, scale: Array) -> bool:
    """Is there a coordinate whose way from a to b is not that of its velocity at a, even with MORE times its
    acceleration?"""
    h = b.t - a.t
    way = h * np.abs(a.xd)
    noise = NOISE * scale * (way / scale).max(initial=0.0)
    return bool((np.abs(b.x - a.x - h * a.xd) > MORE * h * h * np.abs(a.xdd) + 0.5 * way + noise).any())


class Fold(NamedTuple):
    """Smallest singular value s of the position at a step, its vector w (len(U),), its rate ds/dt along the motion, and
    whether the dead point is nearer than the degrees of freedom are known, and whether rounding tells it from there."""

    s: float
    w: Array
    rate: float
    near: bool
    single: bool


class Closer:
    """Looks at steps with a NumPy evaluator of its own. Its checks raise AnalysisError."""

    def __init__(self, dynamics: Dynamics, atol: float, rtol: float, resolved: bool) -> None:
        self.d, self.atol, self.rtol, self.resolved = dynamics, atol, rtol, resolved
        self.scale = dynamics.mechanism.scale
        self.found: dict[int, tuple[Accepted, Fold]] = {}

    def goes_on(self, a: Accepted, b: Accepted) -> bool:
        """Does the motion that is not determined at a dead point between both go on in its direction?"""
        before, after = self._along([a, b])
        return bool(before * after >= 0.0)

    def turned_in_steps(self, steps: list[Accepted]) -> bool:
        """Did the motion that is not determined at the dead point turn in steps, or jump to its opposite in one?"""
        along = self._along(steps)
        return bool(np.abs(np.diff(along)).max() <= TURNING * np.abs(along).max())

    def _along(self, steps: list[Accepted]) -> Array:
        """Velocities (steps,) of the motion that is not determined between the first and the last of them."""
        w = min((self._fold(p) for p in (steps[0], steps[-1])), key=lambda found: found.s).w
        return np.array([w @ (p.at.xd / self.scale)[self.d.kinematics.U] for p in steps])

    def near(self, p: Accepted) -> bool:
        """Is the dead point nearer than the degrees of freedom are known?"""
        return self._fold(p).near

    def meets(self, p: Accepted, within: float) -> bool:
        """Is the dead point as near, or reached within that time?"""
        found = self._fold(p)
        return found.near or -found.rate * within >= found.s

    def stands(self, steps: list[Accepted]) -> bool:
        """Are these steps all nearer to the dead point than rounding resolves?"""
        return len(steps) == STANDING and not any(self._fold(p).single for p in steps)

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
        """Follow the path of the degrees of freedom from a to b, by halving the step."""
        if depth > DEEPEST:
            return
        if not self._reaches(a, b) and (not unexplained(a.at, b.at, self.scale).any() or self._joined(a, b)):
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

    def _reaches(self, a: Accepted, b: Accepted) -> bool:
        h = b.at.t - a.at.t
        return any(h * abs(fold.rate) > APART * fold.s for fold in (self._fold(a), self._fold(b)))

    def _joined(self, a: Accepted, b: Accepted) -> bool:
        """Is the position at b that which is reached from a? Velocities may be those of a fast vibration."""
        try:
            found = self._place(a, b.at.t, b.y)
        except AnalysisError:
            return False
        return bool(np.abs((found.at.x - b.at.x) / self.scale).max(initial=0.0) <= SAME)

    def _fold(self, p: Accepted) -> Fold:
        """The fold at a step, which is computed once."""
        if id(p) not in self.found:
            self.found[id(p)] = p, self._find(p)  # p too: so that no other step gets its id
        return self.found[id(p)][1]

    def _find(self, p: Accepted) -> Fold:
        d = self.d
        self._derivative(p)
        k, n = d.kinematics, d.numbering
        s, u, w, bend = k.fold(k.of_velocity)
        sigma = np.zeros(n.ne)
        sigma[k.E] = u / d.mechanism.deformation_scale[k.E]
        xs, es = n.x_class["dynamic"], n.e_class["dynamic"]
        force, m = k.sweep.rate_transposed(sigma)[xs], d.n_xm
        error = self.atol + self.rtol * np.abs(p.y[: n.nddof])
        known = float(np.abs(force) @ error[:m] + np.abs(sigma[es]) @ error[m:])
        speed = float(np.abs(p.at.xd / self.scale).max(initial=0.0))
        rate = 0.0
        if speed > 0.0:
            along, v = np.zeros(n.nx), p.at.xd / speed
            along[k.U] = w * k.scale[k.U]
            both = k.sweep.convective(v + along) - k.sweep.convective(v - along)
            rate = 0.25 * speed * float(sigma @ both)
        rounding = k.rounding(k.x, k.sweep.e[k.h])
        distance, unit = s * s, 2.0 * abs(bend)
        return Fold(s, w, rate, bool(distance <= unit * known), bool(distance > unit * rounding))


def _stopped(t: float, what: str) -> AnalysisError:
    return AnalysisError(
        f"singular position at t = {t:.9g}: at this dead point of the degrees of freedom {what}; choose other degrees"
        " of freedom, or a smaller ERROR",
        "position.singular",
        t=t,
    )
