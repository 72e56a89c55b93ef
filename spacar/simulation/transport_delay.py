"""Transport delay: y(t) = u(t - lag), and `initial` for t - lag before the start.

The input is remembered over every accepted step, as a polynomial of degree 4 through five Chebyshev points; where it is
not within the tolerance of a step at two points between them, the interval is halved. No step is longer than the lag,
so that only remembered values are asked for. A jump of the input comes out one lag later as a jump, and a step ends
there (Bellen and Zennaro, chapter 4); kinks are left to the control of the step size.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterator

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.integrators import Tolerance
from spacar.simulation.blocks import NONE, Block
from spacar.simulation.switching_blocks import Numbers, spread

NODES = np.sin(0.25 * np.pi * np.arange(-2.0, 3.0))  # in [-1, 1]
WEIGHTS = np.array([0.5, -1.0, 1.0, -1.0, 0.5])  # barycentric weights of these nodes
BETWEEN = (-0.35, 0.35)  # places in [-1, 1] where the polynomial is compared with the input
MOST_HALVES = 30  # halvings of a step


class TransportDelay(Block):
    """y(t) = u(t - lag). Raises UsageError for a lag (s) that is not positive, or another number of `initial`."""

    def __init__(self, name: str, lag: float, initial: Numbers = 0.0, size: int = 1) -> None:
        super().__init__(name, size, size)
        if not 0.0 < lag < np.inf:
            raise UsageError(f"{name}: the delay must be positive, not {lag}", "simulation.delay")
        self.lag = float(lag)
        (self.initial,) = spread(name, "initial values", "simulation.size", size, initial)
        self.direct = np.zeros(size, bool)
        self.start()

    def start(self) -> Array:
        self.begins: list[float] = []  # of the pieces, increasing
        self.pieces: list[tuple[float, float, Array]] = []  # start and end of each [s], values at its nodes (5, n)
        self.end = self.initial
        self.begin: float | None = None
        return NONE

    def state_outputs(self, t: float, x: Array) -> Array:
        k = bisect_right(self.begins, t - self.lag) - 1
        return self.initial if k < 0 else _between(*self.pieces[k], t - self.lag)

    def jumped(self, u: Array, tolerance: Tolerance) -> bool:
        """Does the input u (n,) at the start of a piece differ from that at the end of the last one?"""
        return bool(np.any(np.abs(u - self.end) > tolerance.absolute + tolerance.relative * np.abs(u)))

    def jumps_out(self, t: float) -> None:
        """The jump that was seen last comes out at t [s], which is one lag later up to rounding."""
        self.begin = t - self.lag

    def remember(self, t0: float, t1: float, u: Callable[[float], Array], tolerance: Tolerance) -> None:
        """The input u(t) (n,) in an accepted step from t0 to t1 [s]."""
        old = bisect_right(self.begins, t0 - self.lag) - 1
        if old > 0:
            del self.begins[:old], self.pieces[:old]
        begin, self.begin = self.begin, None
        for a, b, values in _pieces(t0, t1, u, tolerance):
            self.begins.append(a if begin is None or a > t0 else begin)
            self.pieces.append((a, b, values))
            self.end = values[-1]


def _pieces(
    a: float, b: float, u: Callable[[float], Array], tolerance: Tolerance, halves: int = 0
) -> Iterator[tuple[float, float, Array]]:
    """Intervals of [a, b] in which the polynomial through the values at the nodes is u(t) within the tolerance."""
    values = np.array([u(0.5 * (a + b + (b - a) * z)) for z in NODES])
    middle = 0.5 * (a + b)

    def fits(t: float) -> bool:
        true = u(t)
        error = np.abs(_between(a, b, values, t) - true)
        return bool(np.all(error <= tolerance.absolute + tolerance.relative * np.abs(true)))

    if halves == MOST_HALVES or not a < middle < b or all(fits(middle + 0.5 * (b - a) * z) for z in BETWEEN):
        yield a, b, values
        return
    yield from _pieces(a, middle, u, tolerance, halves + 1)
    yield from _pieces(middle, b, u, tolerance, halves + 1)


def _between(a: float, b: float, values: Array, t: float) -> Array:
    """The polynomial through `values` at the nodes of [a, b], at a time in it."""
    z = min(max((2.0 * t - a - b) / (b - a), -1.0), 1.0)
    away = z - NODES
    hit = np.flatnonzero(np.abs(away) < 1e-15)
    if len(hit):
        return values[hit[0]]
    part = WEIGHTS / away
    return part @ values / part.sum()
