"""Along the equilibrium path by arc length, past limit points of the loading, to the end of a load step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.kinematics.kinematics import largest
from spacar.linear_systems import SingularMatrixError
from spacar.stationary.arc import At, arc
from spacar.stationary.contract import Astray
from spacar.stationary.stationary_equations import Iterate

MOST_ARCS = 500
FIRST_ARC, SMALLEST_ARC, LARGEST_ARC = (1e-3, 0.02), 1e-6, 0.2  # model lengths, or rad
BACKWARDS = 1e-5  # model lengths or rad: a first arc as short as this that goes back starts at the limit point
STEPPED = 1e-6  # model lengths or rad: least distance of two states that gives a direction
EASY = 4  # iterations after which the next arc is longer


@dataclass(frozen=True)
class Arrived:
    """A state near the end of the step, the places of the limit points on the way, the number of iterations."""

    x: Array
    sigma: Array
    turns: list[float]
    iterations: int


class LimitPoint(Exception):
    """The loading has its extreme value on the path at this place; `point` is a state near it."""

    def __init__(self, place: float, point: Iterate | None) -> None:
        super().__init__(place)
        self.place, self.point = place, point


def around(at: At, known: Sequence[tuple[Array, Array]], place: float, limit: int, follow: bool) -> Arrived:
    """From the last of the known states (x, sigma) at this place to place 1. Raises Astray, LimitPoint."""
    x, sigma = known[-1]
    q, _, _ = at(place)
    forward, s = np.zeros_like(x), FIRST_ARC[0]
    for before, _ in reversed(known[:-1]):
        forward = x - before
        s = largest(forward / q.scale)
        if s > STEPPED:
            break
    s = min(max(s, FIRST_ARC[0]), FIRST_ARC[1])
    places, lengths, turns, total = [place], [0.0], [], 0
    for _ in range(MOST_ARCS):
        near = q.d.sweep.near.copy()
        try:
            step = arc(at, x, sigma, place, forward, s, limit)
        except (Astray, SingularMatrixError):
            q.d.sweep.near[:] = near
            s *= 0.5
            if s < SMALLEST_ARC:
                break
            continue
        if len(places) == 1 and step.place <= place and s > BACKWARDS:  # turned within the first arc: where?
            q.d.sweep.near[:] = near
            s *= 0.25
            continue
        q.d.sweep.near[:] = q.d.sweep.e
        total += step.iterations
        lengths.append(lengths[-1] + largest((step.point.x - x) / q.scale))
        places.append(step.place)
        rising = len(places) == 2 or places[-2] > places[-3]
        if rising != (places[-1] > places[-2]):
            turn = _extreme(lengths[-3:], places[-3:]) if len(places) > 2 else places[0]
            if not follow:
                raise LimitPoint(turn, step.point)
            turns.append(turn)
        if step.place >= 1.0:  # the end of the step is between the two states
            part = (1.0 - place) / (step.place - place)
            dx, ds = step.point.x - x, step.point.sigma - sigma
            return Arrived(x + part * dx, sigma + part * ds, turns, total)
        forward, x, sigma, place = step.point.x - x, step.point.x, step.point.sigma, step.place
        if step.iterations <= EASY:
            s = min(1.5 * s, LARGEST_ARC)
    raise Astray("the equilibrium path could not be followed by arc length either")


def _extreme(s: Sequence[float], p: Sequence[float]) -> float:
    """The extreme value of the parabola through three points (s, p)."""
    a, b = (p[1] - p[0]) / (s[1] - s[0]), (p[2] - p[1]) / (s[2] - s[1])
    curvature = (b - a) / (s[2] - s[0])
    if not curvature:
        return p[1]
    top = 0.5 * (s[0] + s[1] - a / curvature)
    return float(p[0] + a * (top - s[0]) + curvature * (top - s[0]) * (top - s[1]))
