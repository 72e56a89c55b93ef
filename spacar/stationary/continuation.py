"""From load level to load level along the equilibrium path (theory-system.md 6.3).

A level starts from the polynomial through up to four earlier states of the same loading, else from the last one. A
part of a load step whose iteration does not contract is halved, down to 1/1024 of the step, and doubled again after
parts that were easy. After every part the negative eigenvalues of the tangent stiffness are counted. When their number
has changed the state may be one of another branch: the part is repeated in smaller ones, down to 1/256 of the step.
What remains is a critical state that the path really passes; a warning says so. Large systems (a count costs five to
fifty iterations) are counted at the start and at stored levels, and in between where the sign of the determinant,
which comes with the last factorization, says that the number has become odd or even.

A prediction that overshoots a limit point may lie where another branch, stable too, attracts the iteration. So from a
part that moves much faster than the one before (or is the first) the iteration at the level before must lead back.

A start that is held by fading forces and not stable is a guess, which may lead to another unstable state. Then the path
is followed back to the largest holding force, where the stable branch begins, and along this.

Where parts become too small the path may end in a fork, beyond which a damped motion leads (`relaxed`), or it turns: it
is followed by arc length. A limit point of growing loads is an error, unless ITERSTEP position 7 asks to go on; at one
of fading forces the start is given up. Under prescribed displacement alone the path is followed, with a warning.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spacar.arrays import Array
from spacar.errors import Report
from spacar.kinematics.kinematics import largest
from spacar.linear_systems import SingularMatrixError
from spacar.stationary.arc_length import Arrived, LimitPoint, at_limit, follow, given_up, unsupported
from spacar.stationary.level_evaluator import StaticEquilibrium
from spacar.stationary.loading import LoadLevel, loads_grow
from spacar.stationary.newton import Converged, Demand, Known, predicted, relaxed
from spacar.stationary.singular import FreeMotion
from spacar.stationary.stability import Stability, critical_motion, is_regular
from spacar.stationary.stationary_equations import Astray, Iterate, Prescribed, StationaryEquations, Tangent

REMEMBERED = 4  # states that the prediction uses: a cubic polynomial
FASTER = 2.0  # change of x over that of the loading, against the part before, from which the iteration must lead back
ELSEWHERE = 0.1  # of the motion of a part: states that differ by more are not the same
RETURNED = 0.02  # of the motion of a part: last correction on the way back; it leaves an error of three times that
WIDE = 0.01  # model lengths or rad: from shorter parts it need not
SMALLEST_PART = 1.0 / 1024.0
CRITICAL_PART = 1.0 / 256.0  # of a load step, in which a critical state is looked for
STILL = 1e-6  # model lengths or rad: parts that move less (a straight column at its critical load) keep their branch
LARGE = 600  # unknowns; above, the count costs more than an iteration (`Continuation._odd`); so does `relaxed`
NEARLY, TAKEN_BACK = 1e-4, 8  # of the loading: what a state that is passed only may be off; times it is doubled
EASY = 6  # iterations after which the next part of a step may be twice as large


class Bifurcation(Exception):
    """The determinant changes its sign where the path does not turn: it crosses another one."""


class Continuation:
    """The path so far.

    point   the last state;  stable  its stability if known;  iterations  their number at the last level
    """

    def __init__(self, statics: StaticEquilibrium, point: Iterate, known: bool, report: Report) -> None:
        self.statics, self.evaluator, self.point, self.report = statics, statics.levels, point, report
        self.level = LoadLevel(0.0, 0.0)
        self.path = [Known(0.0, point.x, point.sigma)]
        self.stable: Stability | None = None
        self.iterations = 0
        self.noise, self._regular, self._factored = 0.0, False, False
        settings = self.evaluator.mechanism.settings
        self.limit, self.tolerance = settings.max_iterations, settings.tolerance
        self.follow = bool(settings.follow_path)
        self._count(stored=True)
        # A start that is held, or has no stiffness as long as no load acts, is not on the path and predicts nothing.
        # If it is not stable either, the first level may be reached from it in any way: there is no branch to be lost.
        negative, zero = (self.stable.negative, self.stable.zero) if self.stable else (None, 0)
        self._arbitrary = zero > 0 or not known
        self._guess = zero > 0 or not (known or negative == 0)
        self._unstable: tuple[Array, Array, Array] | None = None  # the start, if it is held and not stable
        if self._guess and not known:
            self._unstable = (point.x, point.sigma, self.evaluator.branch.copy()) if negative else None
            self.stable = None

    def advance(self, target: LoadLevel) -> None:
        """To a level. Raises AnalysisError 'statics.no-convergence', 'statics.limit-point', 'statics.no-solution'."""
        origin, place, part = self.level, 0.0, 1.0
        self.iterations = 0
        while place < 1.0:
            following = min(1.0, place + part)
            level = target if following == 1.0 else origin.towards(target, following)
            before, branch = (self.point, self.stable, self.path), self.evaluator.branch.copy()
            reason: Exception = Astray("the determinant of the tangent stiffness changes its sign")
            try:
                reached = origin.towards(target, place) if place else origin
                demand = Demand.of(self.limit, self.tolerance, target.store and following == 1.0)
                if part < 1.0:  # where parts are cut a limit may be near, beyond which there is only what nearly fits
                    demand = demand.exactly()
                steps = self._advance(reached, level, demand, part <= SMALLEST_PART)
                crossed = self._count(level.store)
            except (Astray, SingularMatrixError) as failure:
                reason, crossed, steps = failure, False, 0
            else:
                if not crossed or largest((self.point.x - before[0].x) / self.evaluator.scale) <= STILL:
                    if crossed:
                        self._say_passed(level, before[1])
                    self.iterations += steps
                    place = following
                    part = min(2.0 * part if steps <= EASY else part, 1.0)
                    continue
            found = self.point, self.stable, self.path
            self.point, self.stable, self.path = before
            self.evaluator.branch[:] = branch
            if isinstance(reason, FreeMotion) and len(self.path) == 1:
                raise unsupported(self.evaluator, reason.coordinate, target) from None
            if part > (CRITICAL_PART if crossed else SMALLEST_PART):
                if part == 1.0 and place == 0.0 and not crossed:
                    self.report.add(f"{target}: no convergence in one part, cut to 0.5 of its size")
                part *= 0.25 if crossed else 0.5
                continue
            # Too small: does the path turn back, or does it only cross another one?
            until = level if crossed else target
            try:
                self.iterations += self._turn(origin, until, target, place, reason)
            except Bifurcation:
                self.point, self.stable, self.path = found
                self.statics.load(level)
                self.statics.set_state(self.point)
                self.evaluator.follow(self.point.x)
                self._say_passed(level, before[1])
                self.iterations += steps
            place = following if crossed else 1.0
        if self._unstable is not None:
            self._settle(origin, target, *self._unstable)
        self._reach(target)

    @property
    def is_exact(self) -> bool:
        """Is the residual of the last state rounding, and its stability known exactly?"""
        return self.point.quiet and self.stable is not None and self.stable.exact and not self.stable.critical

    @property
    def is_firm(self) -> bool:
        """Does every motion have a stiffness at the last state?"""
        e = self.evaluator
        if self.stable is not None and self.stable.exact:
            return self.stable.zero == 0
        return is_regular(e.equations, e.tangent, self.point)

    def stay(self, target: LoadLevel) -> None:
        """At the last state, at a level at which the same acts."""
        self.statics.load(target)
        self.iterations = 0
        self._accept(target.path, Converged(self.point, 0, 0.0, regular=False))
        self._reach(target)

    def _reach(self, level: LoadLevel) -> None:
        self.level = level
        if self._arbitrary or (level.additional == 0.0 and level.initial >= 1.0):
            self.path = self.path[-1:]  # from here on the path of the additional loading
        self._arbitrary, self._guess, self._unstable = False, False, None
        if self.evaluator.fading_force is not None:
            self.evaluator.set_fading_force(None)
            self.statics.load(level)

    # -- one part -------------------------------------------------------------------------------------------------
    def _advance(self, reached: LoadLevel, level: LoadLevel, demand: Demand, ended: bool) -> int:
        """Newton's iteration at the level; the number of iterations. `ended`: where the path may end."""
        e = self.evaluator
        self.statics.load(level)
        branch = e.branch.copy()
        reason: Exception = Astray("no start")
        for start in self._starts(level.path, ended):
            e.branch[:] = branch
            try:
                known = start()
                found = self.statics.newton(known.x, known.sigma, demand)
            except (Astray, SingularMatrixError) as failure:
                reason = reason if isinstance(reason, FreeMotion) else failure
                continue
            if self._jumped(reached, level, found):
                reason = Astray("the state that was found does not lead back to the one before")
                self.statics.load(level)
                continue
            self._accept(level.path, found)
            return found.iterations
        raise reason

    def _jumped(self, reached: LoadLevel, level: LoadLevel, found: Converged) -> bool:
        """Does the iteration lead from the new state back to another one than the last? The evaluator stands at the
        new one, at its level, when it does not."""
        e, last = self.evaluator, self.path[-1]
        point, n = found.point, e.mechanism.numbering
        moved = largest((point.x - last.x) / e.scale)
        # With wheels, which turn as far as they roll, and where everything is prescribed there is no path to be lost.
        free = self._guess or not n.holonomic or not n.nddof
        if free or moved < WIDE or self._steady(level, moved):
            return False
        branch = e.branch.copy()
        self.statics.load(reached)  # with other equations, where the flow in tubes changes
        e.branch[:] = branch
        try:
            demand = Demand.of_return(self.limit, RETURNED * moved)
            back = self.statics.newton(point.x, point.sigma, demand)
            if largest((back.point.x - last.x) / e.scale) > ELSEWHERE * moved:
                return True
        except (Astray, SingularMatrixError):  # too far back, or from elsewhere: smaller parts tell
            return True
        self.statics.load(level)
        e.branch[:] = branch
        self.statics.set_state(point)
        return False

    def _steady(self, level: LoadLevel, moved: float) -> bool:
        """Is the path about as fast as in the part before, or slower?"""
        if len(self.path) < 2:
            return False
        before, last = self.path[-2:]
        change = largest((last.x - before.x) / self.evaluator.scale)
        return moved * (last.path - before.path) <= FASTER * change * (level.path - last.path)

    def _starts(self, path: float, ended: bool) -> list[Callable[[], Known]]:
        """Where Newton's iteration may begin, the best first: the prediction, the last state, the last configuration
        with stresses that balance the new loads (needed without other stiffness), what a damped motion comes to."""
        last, e = self.path[-1], self.evaluator
        n = e.mechanism.numbering

        def balanced(x: Array = last.x) -> Known:
            q = e.equations
            return Known(path, x, q.balanced(q.point(x, last.sigma, e.given)))

        def placed() -> Known:
            e.place()
            return balanced(e.dynamics.kinematics.x)

        def moved() -> Known:
            return Known(path, *relaxed(e.equations, e.tangent, last.x, last.sigma, e.given))

        if not n.holonomic:
            return [balanced, lambda: last]
        if not n.nddof:
            return [placed]
        first = [lambda: predicted(self.path, path, n.x_class["fixed"])] if len(self.path) > 1 else []
        others = [lambda: last, balanced]
        if not self._arbitrary and self.stable is not None and self.stable.zero:
            others.reverse()  # a motion without stiffness: the old stresses give it none against the new loads
        if ended and e.unknowns <= LARGE and not (self._guess or e.fading_force is not None):
            others.append(moved)
        return [*first, *others]

    def _accept(self, path: float, found: Converged) -> None:
        self.point, self.noise, self._regular = found.point, found.noise, found.regular
        self._factored = found.iterations > 0
        p = found.point
        self.path = [*self.path, Known(path, p.x, p.sigma)][-REMEMBERED:]
        self.evaluator.follow(p.x)

    # -- critical states ------------------------------------------------------------------------------------------
    def _count(self, stored: bool) -> bool:
        """Has the number of negative eigenvalues changed by more than those that were zero?"""
        e, before = self.evaluator, self.stable
        if (e.unknowns > LARGE or not e.plain) and not stored and not self._odd():
            return False
        self.stable = self.statics.stability(self.point, self.noise, self._regular, before)
        return before is not None and self.stable is not None and self.stable.differs(before)

    def _odd(self) -> bool:
        """Does the determinant of the last factorization say that the known number of negative eigenvalues is off by
        an odd number?"""
        if self.stable is None or self.stable.zero:
            return self.stable is None
        try:  # not factored: the prediction was the solution
            sign = self.statics.sign(self.point, self._factored)
        except SingularMatrixError:
            return True
        return sign * (-1.0) ** self.stable.negative < 0.0

    def _say_passed(self, level: LoadLevel, before: Stability | None) -> None:
        assert before is not None
        assert self.stable is not None
        e = self.evaluator
        if e.whole_from_start and not level.additional:
            return  # of a path along which only a force fades
        more = self.stable.negative > before.negative
        motion = critical_motion(e.equations, e.tangent, self.point, more)
        change = abs(self.stable.negative - before.negative)
        what = f"{change} negative eigenvalue{'s' * (change > 1)} {'more' if more else 'less'}"
        if not self.stable.exact:
            what = "changed the sign of its determinant"
        self.report.add(
            f"warning: {level}: a critical state is passed (bifurcation or limit point): the tangent stiffness has"
            f" {what}{f', the motion is largest at {motion}' * bool(motion)}"
            "; the solution stays on the same branch, a small imperfection shows the others"
        )

    # -- where natural parts do not help ----------------------------------------------------------------------------
    def _turn(self, origin: LoadLevel, until: LoadLevel, target: LoadLevel, place: float, reason: Exception) -> int:
        """Along the path by arc length to a level on the way to the target; the number of iterations.

        Raises Bifurcation where the path does not turn before a level that natural parts reached too.
        """
        e = self.evaluator
        whole = until is target
        end = 1.0 if whole else (until.path - origin.path) / (target.path - origin.path)
        try:
            beyond = self.follow or not (e.fading_force is not None or loads_grow(e.mechanism, target))
            found = self._follow(origin, target, end, self._before_turn(origin, target), beyond)
            if not (whole or found.turns):
                raise Bifurcation
            steps = self._land(found, until)
        except LimitPoint as limit:
            if limit.followed and not whole:
                raise Bifurcation from None
            raise at_limit(e, origin.towards(target, limit.place), target, limit) from None
        except (Astray, SingularMatrixError):
            if not whole:
                raise Bifurcation from None
            self.statics.load(origin.towards(target, place))
            raise given_up(origin.towards(target, place), target, SMALLEST_PART, reason, self._known_here()) from None
        before = self.stable
        self._count(until.store)
        if found.turns:
            places = ", ".join(f"{origin.towards(target, t).path:.8g}" for t in found.turns[:8])
            self.report.add(
                f"warning: {target}: limit points at {places} of the loading (initial 0 to 1, additional 1 to 2); the"
                " solution is where the equilibrium path beyond them first reaches the load: a slow loading would jump"
            )
        elif before is not None and self.stable is not None and self.stable.differs(before):
            self._say_passed(target, before)
        return steps

    def _settle(self, origin: LoadLevel, target: LoadLevel, x: Array, sigma: Array, branch: Array) -> None:
        """Where a start that was not stable led to another unstable state, away from it: the stable one that a motion
        from there comes to rest at, if the path of the holding force leads to it, first backward to its largest value.
        """
        e, found = self.evaluator, (self.point, self.stable, self.path, self.evaluator.branch.copy())
        far = largest((self.point.x - x) / e.scale) > WIDE
        if not far or self.stable is None or not self.stable.negative:
            return
        e.branch[:] = branch
        try:
            begin = x, sigma, 0.0, np.zeros_like(x)
            steps = self._land(self._follow(origin, target, 1.0, begin, True, backward=True), target)
            self.stable = self.statics.stability(self.point, self.noise, self._regular, None)
            if self.stable is not None and not self.stable.negative:
                self.iterations += steps
                return
        except (Astray, SingularMatrixError, LimitPoint):
            pass
        self.point, self.stable, self.path, e.branch[:] = found
        self.statics.load(target)
        self.statics.set_state(self.point)

    def _follow(
        self, origin: LoadLevel, target: LoadLevel, end: float, begin: tuple[Array, Array, float, Array], beyond: bool,
        backward: bool = False,
    ) -> Arrived:  # fmt: skip
        """As `follow`, on the way between two levels."""
        e = self.evaluator

        def at(p: float) -> tuple[StationaryEquations, Tangent, Prescribed]:
            self.statics.load(origin.towards(target, p))
            return e.equations, e.tangent, e.given

        return follow(at, *begin, end, self.limit, beyond, backward)

    def _land(self, found: Arrived, level: LoadLevel) -> int:
        """From near a level onto it; the number of iterations."""
        self.statics.load(level)
        last = self.statics.newton(found.x, found.sigma, Demand.of(self.limit, self.tolerance, level.store))
        self.path = []
        self._accept(level.path, last)
        return found.iterations + last.iterations

    def _known_here(self) -> str:
        """What is known of the last solution."""
        known = "" if self.stable is None else f"; the tangent stiffness there has {self.stable}"
        return f"(largest residual {self.point.force:.3g}, tolerance {self.tolerance:.3g}){known}"

    def _before_turn(self, origin: LoadLevel, target: LoadLevel) -> tuple[Array, Array, float, Array]:
        """The last state of the path that lies on it to the accuracy of results and before any change of the sign of
        the determinant: x, sigma, its place on the load step, the motion that led there. States that were passed only
        may lie off the path, where the load is a little above its extreme value: if all do, the load is taken back."""
        e, span, path = self.evaluator, target.path - origin.path, self.path
        tries = [(k, path[k].path) for k in range(len(path) - 1, -1, -1)]
        tries += [(0, path[0].path - back) for k in range(TAKEN_BACK) if (back := 2.0**k * NEARLY) < path[0].path % 1.0]
        for k, there in tries:
            known, place = path[k], (there - origin.path) / span
            motion = known.x - path[k - 1].x if k else np.zeros_like(known.x)
            self.statics.load(origin.towards(target, place))
            branch = e.branch.copy()
            try:
                found = self.statics.newton(known.x, known.sigma, Demand(self.limit).exactly()).point
                e.follow(found.x)
                if self.stable is None or self.statics.sign(found, False) * (-1.0) ** self.stable.negative > 0.0:
                    return found.x, found.sigma, place, motion
            except (Astray, SingularMatrixError):
                pass
            e.branch[:] = branch
        raise Astray("no state before the turn")
