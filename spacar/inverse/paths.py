"""Paths of trajectories: from the arc length p (or angle, or deformation) to prescribed values (theory-system.md 7.2).

A path knows where its values go (`rows` of the prescribed coordinates or deformations), how long it is, and gives the
values, rates and accelerations for p, dp/dt, d2p/dt2. Lengths are in metres, angles in radians. Arrays have the shape
(len(rows),).
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array, Index

Values = tuple[Array, Array, Array]
# Chosen, for the digits of a file: sine of the angle below which two directions do not span a plane.
PARALLEL = 1e-9


class BadPath(ValueError):
    """The numbers of a path statement do not describe a path."""


class StraightPath(NamedTuple):
    """Values start + p u with a constant direction u: TRANS, TRE (u = +-1) and planar TROT (u = +-1)."""

    rows: Index
    start: Array
    direction: Array
    length: float

    def at(self, p: float, rate: float, acceleration: float) -> Values:
        u = self.direction
        return self.start + p * u, rate * u, acceleration * u


class ArcPath(NamedTuple):
    """Positions c + R (cos psi e1 + sin psi e2) on a circle, psi = p/R: TRCIRL."""

    rows: Index
    centre: Array
    e1: Array
    e2: Array
    radius: float
    length: float

    def at(self, p: float, rate: float, acceleration: float) -> Values:
        c, s = cos(p / self.radius), sin(p / self.radius)
        outward, along = c * self.e1 + s * self.e2, c * self.e2 - s * self.e1
        value = self.centre + self.radius * outward
        return value, rate * along, acceleration * along - rate * rate / self.radius * outward


class TurnPath(NamedTuple):
    """lambda = (cos p/2, h sin p/2) o lambda_start about the fixed global axis h: spatial TROT.

    `components` are the numbers (0 to 3) of the Euler parameters that are prescribed.
    """

    rows: Index
    components: Index
    axis: Array
    start: Array  # (4,)
    length: float

    def at(self, p: float, rate: float, acceleration: float) -> Values:
        turned = self._left(self.start)
        c, s = cos(0.5 * p), sin(0.5 * p)
        value, along = c * self.start + s * turned, 0.5 * (c * turned - s * self.start)
        second = acceleration * along - 0.25 * rate * rate * value
        k = self.components
        return value[k], (rate * along)[k], second[k]

    def _left(self, lam: Array) -> Array:
        """(0, h) o lambda."""
        l0, l = lam[0], lam[1:]
        return np.concatenate(([-self.axis @ l], l0 * self.axis + np.cross(self.axis, l)))

    @property
    def smallest_scalar(self) -> float:
        """Smallest lambda0 on the path; the mechanism is singular where it vanishes (half a turn)."""
        a, b = self.start[0], self._left(self.start)[0]
        size, phase = float(np.hypot(a, b)), float(np.arctan2(b, a))
        first, last = -phase, 0.5 * self.length - phase  # lambda0 = size cos(p/2 - phase)
        return -size if last >= np.pi else size * min(cos(first), cos(last))


Path = StraightPath | ArcPath | TurnPath


def straight(rows: Index, start: Array, end: Array) -> StraightPath:
    """Line from start to end [m]."""
    way = end - start
    length = float(np.linalg.norm(way))
    return StraightPath(rows, start, way / length if length > 0.0 else 0.0 * way, length)


def change(rows: Index, start: Array, total: float) -> StraightPath:
    """A single value that changes by `total`: an angle [rad], or a deformation in its unit."""
    return StraightPath(rows, start, np.array([1.0 if total >= 0.0 else -1.0]), abs(total))


def arc(rows: Index, start: Array, centre: Array, end: Array) -> ArcPath:
    """Circle about the centre from start to the ray from the centre through `end`, the shorter way round.

    Raises BadPath when the radius vanishes, or the direction of the end or, in space, the plane is undefined.
    """
    first, last = start - centre, end - centre
    radius, reach = float(np.linalg.norm(first)), float(np.linalg.norm(last))
    if radius <= 0.0:
        raise BadPath("the centre is the present position: the radius is zero")
    if reach <= PARALLEL * radius:
        raise BadPath("the end point is the centre: the direction of the end of the arc is undefined")
    e1, d = first / radius, last / reach
    if len(start) == 2:
        e2 = np.array([-e1[1], e1[0]])
        angle = float(np.arctan2(d @ e2, d @ e1))
        return ArcPath(rows, centre, e1, np.copysign(1.0, angle) * e2, radius, radius * abs(angle))
    across = d - (d @ e1) * e1
    size = float(np.linalg.norm(across))
    if size <= PARALLEL:
        if d @ e1 > 0.0:
            return ArcPath(rows, centre, e1, 0.0 * e1, radius, 0.0)
        raise BadPath("start, centre and end point lie on one line: the plane of the arc is undefined; use two arcs")
    return ArcPath(rows, centre, e1, across / size, radius, radius * float(np.arctan2(size, d @ e1)))


def turn(rows: Index, components: Index, start: Array, total: float, axis: Array) -> TurnPath:
    """Rotation by `total` [rad] about a fixed axis (3,) from the orientation `start` (4,).

    Raises BadPath when it reaches half a turn from the reference orientation.
    """
    h = axis / np.linalg.norm(axis) * (1.0 if total >= 0.0 else -1.0)
    path = TurnPath(rows, components, h, start, abs(total))
    if path.smallest_scalar <= 1e-6:
        raise BadPath(
            "the rotation reaches half a turn from the reference orientation, where three prescribed Euler parameters"
            " no longer determine the fourth; prescribe a hinge instead (INPUTE, TRE)"
        )
    return path
