"""Velocity profile along one path: rise, constant velocity, decline (theory-system.md 7.1, input-language.md t4).

Fronts with the normalized displacement s, velocity w and acceleration a of tau = 0 ... 1, s(1) = 1/2, w(1) = 1:

    0 constant       s = tau^2/2                              w = tau                          a = 1
    1 sine           s = tau/2 - sin(pi tau)/(2 pi)           w = (1 - cos pi tau)/2           a = pi/2 sin pi tau
    2 squared sine   s = tau^2/2 + (cos 2 pi tau - 1)/(4 pi^2)  w = tau - sin(2 pi tau)/(2 pi)   a = 2 sin^2 pi tau

All of them give L = v (T - rise/2 - decline/2) (21).
"""

from math import cos, pi, sin
from typing import NamedTuple

ROUNDING = 1e-13  # of the total time: sums of some hundred time steps, an eps each
TOLERANCE = 1e-9  # chosen: rise + decline may exceed the total time by this part: numbers in files are rounded


class IllegalProfile(ValueError):
    """The four numbers of a velocity profile do not fit together; the text says how, and what would."""


def constant(tau: float) -> tuple[float, float, float]:
    return 0.5 * tau * tau, tau, 1.0


def sine(tau: float) -> tuple[float, float, float]:
    return 0.5 * tau - sin(pi * tau) / (2 * pi), 0.5 * (1 - cos(pi * tau)), 0.5 * pi * sin(pi * tau)


def squared_sine(tau: float) -> tuple[float, float, float]:
    s = 0.5 * tau * tau + (cos(2 * pi * tau) - 1) / (4 * pi * pi)
    return s, tau - sin(2 * pi * tau) / (2 * pi), 2 * sin(pi * tau) ** 2


FRONTS = (constant, sine, squared_sine)


class Profile(NamedTuple):
    """Motion p(t) from 0 to `length` [m or rad] in `duration` [s], at most with `speed` [m/s or rad/s].

    rise, decline   duration of both phases [s];  front  index into FRONTS
    """

    length: float
    duration: float
    speed: float
    rise: float
    decline: float
    front: int = 0

    @property
    def breaks(self) -> tuple[float, ...]:
        """Times where the acceleration or its derivatives jump, the ends included."""
        return (0.0, self.rise, self.duration - self.decline, self.duration)

    def at(self, t: float) -> tuple[float, float, float]:
        """p, its rate and its acceleration at t [s]; where two phases meet, the acceleration of the later one."""
        if self.length == 0.0 or t < 0.0:
            return 0.0, 0.0, 0.0
        front, v, end = FRONTS[self.front], self.speed, self.duration
        small = ROUNDING * end  # an output time at the end of a phase may lie a rounding error before it
        if t < self.rise - small:
            s, w, a = front(t / self.rise)
            return v * self.rise * s, v * w, v / self.rise * a
        if t < end - self.decline - small:
            return 0.5 * v * self.rise + v * (t - self.rise), v, 0.0
        if t <= end + small:
            s, w, a = front(max(end - t, 0.0) / self.decline)
            return self.length - v * self.decline * s, v * w, -v / self.decline * a
        return self.length, 0.0, 0.0


def make_profile(
    length: float, duration: float, rise: float | None = None, speed: float | None = None, front: int = 0
) -> Profile:
    """Profile from what TRVMAX or TREPMAX gives. rise <= 0 stands for no value and means a symmetric profile.

    length >= 0 [m or rad], duration > 0 [s], speed > 0 [m/s or rad/s]. Raises IllegalProfile.
    """
    if length == 0.0:
        return Profile(0.0, duration, 0.0, 0.5 * duration, 0.5 * duration, front)
    symmetric = rise is None or rise <= 0.0
    if speed is None:
        speed = 2.0 * length / duration
        rise = 0.5 * duration if symmetric else rise
        decline = duration - rise  # type: ignore[operator]
    elif symmetric:
        rise = decline = duration - length / speed
    else:
        decline = 2.0 * (duration - length / speed) - rise  # type: ignore[operator]
    assert rise is not None
    # A decline time of the size of a rounding error counts as zero, which is refused.
    small = TOLERANCE * duration
    if not (rise > small and decline > small and rise + decline <= duration + small):
        raise IllegalProfile(_explanation(length, duration, rise, decline, speed, symmetric))
    return Profile(length, duration, speed, rise, min(decline, duration - rise), front)


def _explanation(length: float, duration: float, rise: float, decline: float, speed: float, symmetric: bool) -> str:
    """The numbers of an impossible profile and the range of speeds that would be possible."""
    text = (
        f"illegal velocity profile: path length {length:.9g}, time {duration:.9g} s, rise time {rise:.6g} s, speed"
        f" {speed:.9g} give {duration - rise - decline:.6g} s of constant velocity and a decline time of {decline:.6g}"
        " s"
    )
    if rise >= duration and not symmetric:
        return f"{text}; the rise time must be shorter than the total time"
    lowest = length / duration if symmetric else length / (duration - 0.5 * rise)
    return f"{text}; the speed must be above {lowest:.9g} and at most {2 * length / duration:.9g}"
