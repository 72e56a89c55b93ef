"""Given values that go on over many turns: one period is followed, the others repeat it.

Along a straight way of given values the position x(s) and its deformations e(s) are analytic functions of the way s. If
x(s + p) - x(s) and e(s + p) - e(s) are constant over one period p, they are constant on the whole branch: n periods add
n times the same to coordinates and deformations (turns to the angle of a crank, length to the span of a belt, nothing
to the slider). Two periods are followed, and compared in eight places a turn. The period is a turn of the largest given
value or several of them: gears need some, and Euler parameters two, as they change their sign in one.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array

PLACES = 8  # of a turn
LONGEST_PERIOD = 8  # turns; chosen
FEWEST = 3.0  # turns: below, all of them are followed


class Period(NamedTuple):
    """What it adds to the given values, and to coordinates and deformations, (nx + ne,) each in their scales."""

    way: Array
    shift: Array

    def times(self, way: Array) -> int:
        """Whole periods in a way, to the nearest."""
        return round(float(way @ self.way) / float(self.way @ self.way))

    def divides(self, way: Array, known: float) -> bool:
        """Has the way the same direction, of values that are `known` to so much?"""
        part = float(way @ self.way) / float(self.way @ self.way)
        return bool(np.abs(way - part * self.way).max() <= known)


def followed(way: Array, follow: Callable[[float], Array], known: float) -> Period | None:
    """The period of a way, (nx + ne,) scaled, along which `follow` goes to a part of it and returns the state there.

    States are `known` to so much. None, somewhere on the way, where there is no period or the way is short.
    """
    turns = float(np.abs(way).max()) / (2.0 * np.pi)
    if turns < FEWEST:
        return None
    states = [follow(0.0)]
    for k in range(1, PLACES * min(2 * LONGEST_PERIOD, int(turns)) + 1):
        states.append(follow(k / (PLACES * turns)))
        if k % (2 * PLACES) == 0:
            half = k // 2
            shifts = np.array(states[half:]) - np.array(states[: half + 1])
            if np.ptp(shifts, axis=0).max() <= known:
                return Period((half / (PLACES * turns)) * way, shifts[-1])
    return None
