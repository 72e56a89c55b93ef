"""Along the equilibrium path by arc length (Riks, updated normal plane), past limit points of the loading.

The place on the load step is another unknown; a correction stays in the plane across the tangent at the start of the
arc, in scaled coordinates. One factorization serves two right-hand sides (bordering). The loads and the prescribed
values are at most quadratic in the place (rates and the flow in tubes enter as squares), so the central difference of
the residual over any distance is its derivative.

Along the path the change of the place with the length of the arc has the sign of the determinant of the tangent
stiffness, but for a constant factor. Where it changes sign is a limit point; it is found to PLACED of the load step by
the secant method from the last state before it. At a bifurcation the determinant changes its sign, and the change of
the place does not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError
from spacar.kinematics.kinematics import largest
from spacar.linear_systems import SingularMatrixError
from spacar.stationary.level_evaluator import LevelEvaluator
from spacar.stationary.loading import LoadLevel
from spacar.stationary.newton import Corrections, Demand, correction
from spacar.stationary.stability import critical_motion
from spacar.stationary.stationary_equations import Astray, Iterate, Prescribed, StationaryEquations, Tangent

At = Callable[[float], tuple[StationaryEquations, Tangent, Prescribed]]  # puts the loads of a place on the evaluator
DISTANCE = 0.5  # of the two evaluations of the derivative
MOST_ARCS = 500
FIRST_ARC, SMALLEST_ARC, LARGEST_ARC = (1e-3, 0.02), 1e-6, 0.2  # model lengths, or rad
BENT = 0.5  # of an arc: what its end may be off the tangent at its begin; more is a state of another path, or too long
EASY = 4  # iterations after which the next arc is longer
PLACED, SECANTS = 1e-10, 20  # of a load step: what a limit point is off; tries


@dataclass(frozen=True)
class PathPoint:
    """A state, its place on the load step (0 to 1), the direction of the path there, the corrections that led to it.

    x, sigma of `point` change by u (nx,), stress (ne,), the place by `rise`, with every unit of arc; largest u is one
    model length or rad. At a limit point `rise` is zero.
    """

    point: Iterate
    place: float
    u: Array
    stress: Array
    rise: float
    iterations: int


@dataclass(frozen=True)
class Arrived:
    """A state near the end, the places of the limit points on the way, the number of iterations."""

    x: Array
    sigma: Array
    turns: list[float]
    iterations: int


class LimitPoint(Exception):
    """The loading has its extreme value on the path at this place; `point` is a state near it. `followed`: the path
    beyond it does not come to the load either."""

    def __init__(self, place: float, point: Iterate, followed: bool = False) -> None:
        super().__init__(place)
        self.place, self.point, self.followed = place, point, followed


def follow(
    at: At, x: Array, sigma: Array, place: float, before: Array, end: float, limit: int, beyond: bool,
    backward: bool = False,
) -> Arrived:  # fmt: skip
    """From the state x (nx,), sigma (ne,) at a place to the place `end`; `before` (nx,): the motion that led there.

    beyond    go on beyond limit points of the loading
    backward  begin towards smaller places. Raises Astray, SingularMatrixError, LimitPoint: the first one where `end` is
              not reached
    """
    q, _, _ = at(place)
    s = min(max(largest(before / q.scale), FIRST_ARC[0]), FIRST_ARC[1])
    here = _arc(at, x, sigma, place, before, None, limit)
    if backward:
        here = replace(here, u=-here.u, stress=-here.stress, rise=-here.rise)
    turns, total, first = list[float](), 0, None
    for _ in range(MOST_ARCS):
        branch = q.d.sweep.branch.copy()
        try:
            ahead = _along(at, here, s, limit)
        except (Astray, SingularMatrixError):
            q.d.sweep.branch[:] = branch
            s *= 0.5
            if s < SMALLEST_ARC:
                break
            continue
        q.d.sweep.follow(ahead.point.x, q.d.sweep.e)
        total += ahead.iterations
        last = ahead
        if (here.rise > 0.0) != (ahead.rise > 0.0):
            branch = q.d.sweep.branch.copy()
            last, turn = _limit_point(at, here, ahead, s, limit)
            q.d.sweep.branch[:] = branch
            if turn < end:
                if not beyond:
                    raise LimitPoint(turn, last.point)
                first = first or LimitPoint(turn, last.point, followed=True)
                turns.append(turn)
                last = ahead
        if last.place >= end > here.place:
            part = (end - here.place) / (last.place - here.place)
            dx, ds = last.point.x - here.point.x, last.point.sigma - here.point.sigma
            return Arrived(here.point.x + part * dx, here.point.sigma + part * ds, turns, total)
        here = ahead
        if ahead.iterations <= EASY:
            s = min(1.5 * s, LARGEST_ARC)
    if first is not None:
        raise first
    raise Astray("the equilibrium path could not be followed by arc length either")


def _along(at: At, start: PathPoint, s: float, limit: int) -> PathPoint:
    """The state at the arc length s [model lengths, rad] from another one. Raises Astray, SingularMatrixError."""
    p = start.point
    return _arc(at, p.x + s * start.u, p.sigma + s * start.stress, start.place + s * start.rise, start.u, s, limit)


def _arc(at: At, x: Array, sigma: Array, place: float, before: Array, s: float | None, limit: int) -> PathPoint:
    """The state in the plane across `before` (nx,) that is near; without s the state itself, which is known."""
    path: Corrections | None = None
    begin = x
    while True:
        slope, given_slope = _slope(at, x, sigma, place)
        q, tangent, given = at(place)
        normal = before / q.scale**2
        path = path or Corrections(Demand(limit).exactly(), tangent.exact)
        p = q.point(x, sigma, given)
        met = s is None or (path.sizes and path.ended(p))
        size = q.flexibility.size
        try:
            tangent.factor(p)
            z, noise = correction(q, tangent, p, np.zeros_like(x), slope - tangent.along(given_slope))
        except SingularMatrixError:
            if s is None or not met:
                raise
            return PathPoint(p, place, before / largest(before / q.scale), np.zeros_like(sigma), 0.0, len(path.sizes))
        r, u = np.zeros_like(x), given_slope.copy()
        r[q.F], u[q.F] = z[: q.nf, 0], z[: q.nf, 1]
        stress = size * z[q.nf :, 1]
        if met:
            if s is not None and largest((x - begin) / q.scale) > BENT * s:
                raise Astray("the path is too curved")
            moved = largest(u / q.scale)
            if not (np.isfinite(moved) and moved > 0.0):
                raise Astray("the loading moves nothing")
            unit = (1.0 if normal @ u >= 0.0 else -1.0) / moved
            return PathPoint(p, place, unit * u, unit * stress, unit, len(path.sizes))
        dp = -float(normal @ r) / (float(normal @ u) or 1.0)
        dx, ds = r + dp * u, size * z[q.nf :, 0] + dp * stress
        path.add(largest(dx / q.scale) if np.isfinite(ds).all() else np.inf, noise)
        q.d.sweep.follow(x, q.d.sweep.e)
        x, sigma, place = x + dx, sigma + ds, place + dp


def _limit_point(at: At, a: PathPoint, b: PathPoint, s: float, limit: int) -> tuple[PathPoint, float]:
    """The state nearest to the limit point between two states, the second at the arc length s from the first, and its
    place, with what the parabola there adds."""
    low, high, qa, qb, best = 0.0, s, a.rise, b.rise, min(a, b, key=lambda p: abs(p.rise))
    for k in range(SECANTS):
        slope = (qb - qa) / (high - low)
        added = -(best.rise**2) / (2.0 * slope)
        if abs(added) <= PLACED:
            break
        share = min(max(qa / (qa - qb), 0.05), 0.95) if k % 3 < 2 else 0.5
        t = low + share * (high - low)
        try:
            found = _along(at, a, t, limit)
        except (Astray, SingularMatrixError):
            break
        best = min(best, found, key=lambda p: abs(p.rise))
        if (found.rise > 0.0) == (a.rise > 0.0):
            low, qa = t, found.rise
        else:
            high, qb = t, found.rise
    return best, best.place + added


def _slope(at: At, x: Array, sigma: Array, place: float) -> tuple[Array, Array]:
    """Derivatives of the right-hand side (n,) and of the prescribed coordinates (nx,) with respect to the place."""
    q, _, ahead = at(place + DISTANCE)
    right = q.point(x, sigma, ahead).right
    q, _, behind = at(place - DISTANCE)
    right = (right - q.point(x, sigma, behind).right) / (2.0 * DISTANCE)
    given = np.zeros_like(x)
    given[q.P] = (ahead.x - behind.x)[q.P] / (2.0 * DISTANCE)
    return right, given


def at_limit(e: LevelEvaluator, reached: LoadLevel, target: LoadLevel, limit: LimitPoint) -> AnalysisError:
    """The loads grow and the path turns back before the target."""
    e.load(reached)
    e.dynamics.sweep.strain(limit.point.x)
    motion = critical_motion(e.equations, e.tangent, limit.point, negative=False)
    text = (
        f"the equilibrium path has a limit point at {reached.initial:.8g} x initial + {reached.additional:.8g} x"
        f" additional loading, before {target} is reached: no static solution is near beyond it, the mechanism"
        " jumps" + (f" (the motion is largest at {motion})" if motion else "")
    )
    if limit.followed:
        text += "; the path beyond it was followed by arc length and was not seen to come to this loading"
    else:
        text += (
            "; prescribe the displacement instead of the load, or give ITERSTEP position 7 the value 1 to follow the"
            " path beyond limit points"
        )
    text += "; where beams bend by tens of degrees in one element, the model with more elements may have none"
    if e.fading_force is not None:
        text += (
            "; the start values (STARTDX, STARTDE) are held by forces that fade on this way, so that this is no limit"
            " load"
        )
    return AnalysisError(text, "statics.limit-point", level=reached)


def unsupported(e: LevelEvaluator, coordinate: int, target: LoadLevel) -> AnalysisError:
    """The load works on a motion without stiffness, mainly of this coordinate of x."""
    text = (
        f"no stationary solution at {target}: the stiffness matrix is singular and the load works on a motion"
        f" without stiffness, mainly {e.mechanism.numbering.x_name(coordinate)}; support it (FIX), prescribe it"
        " (INPUTX, INPUTE) or give it a stiffness (ESTIFF)"
    )
    return AnalysisError(text, "statics.no-solution")


def given_up(reached: LoadLevel, target: LoadLevel, smallest: float, reason: Exception, known: str) -> AnalysisError:
    """Parts as small as `smallest` do not converge; `known` of the last solution, at the level that was reached."""
    how = reason if isinstance(reason, Astray) else Astray(str(reason))
    text = (
        f"the stationary solution did not converge at {target}: {how}; the step was cut to {smallest:.3g} of its"
        f" size, the last solution is at {reached.initial:.6g} x initial + {reached.additional:.6g} x additional"
        f" loading {known}; try {how.remedy}"
    )
    return AnalysisError(text, how.code, level=target)
