"""Blocks without states that are smooth only piecewise: saturation, dead zone, relay, quantizer, look-up table.

Each signal of such a block is in one piece, the mode of the block (blocks.Block). With u the input and y the output:

    saturation     y = lower for u < lower, u, or upper for u > upper
    dead zone      y = u - lower for u < lower, 0, or u - upper for u > upper
    relay          on for u > upper, off for u < lower, as before in between; y = on or off value
    quantizer      y = q floor(u/q + 1/2), q the interval: the nearest level, and half-way the upper one
    look-up table  y by linear or cubic interpolation of (x_k, y_k), or of the x_k that is not above u (step)

The cubic interpolation is the one that keeps the monotony of the values (Fritsch and Butland, as in scipy's PCHIP).
"""

from collections.abc import Sequence

import numpy as np

from spacar.arrays import Array, Index
from spacar.errors import AnalysisError, UsageError
from spacar.simulation.blocks import Affine, Block, without_states

Numbers = Sequence[float] | float | Array


class Piecewise(Block):
    """Base: y_i depends on u_i and on the piece `mode[i]` that it is in; `lower`, `upper`: its limits, if any."""

    lower: Array
    upper: Array

    def __init__(self, name: str, size: int, events_each: int) -> None:
        super().__init__(name, size, size)
        self.n_events = events_each * size
        self.mode0 = np.zeros(size, np.int64)
        self.mode = self.mode0.copy()

    def start(self) -> Array:
        self.mode = self.mode0.copy()
        return self.x0.copy()

    def piece(self, t: float, x: Array, u: Array) -> Index:
        raise NotImplementedError

    def switch(self, t: float, x: Array, u: Array) -> bool:
        before, self.mode = self.mode, self.piece(t, x, u)
        return not np.array_equal(before, self.mode)

    def capped(self, middle: Array | float) -> Array:
        """(n_out,) the lower limit, what holds between the limits, or the upper one, by the mode -1, 0, 1."""
        return np.where(self.mode > 0, self.upper, np.where(self.mode < 0, self.lower, middle))

    @property
    def free(self) -> Array:
        """(n_out, n_out) diagonal: 1 for signals between their limits, else 0."""
        return np.diag((self.mode == 0).astype(float))


class Limited(Piecewise):
    """Base: below, between and above two limits of every signal, or of a `limited` number made of it."""

    def __init__(self, name: str, lower: Numbers, upper: Numbers, size: int = 1) -> None:
        super().__init__(name, size, 2)
        self.lower, self.upper = limits(name, lower, upper, size)

    def limited(self, x: Array, u: Array) -> Array:
        return u

    def piece(self, t: float, x: Array, u: Array) -> Index:
        v = self.limited(x, u)
        return (v > self.upper).astype(np.int64) - (v < self.lower)

    def events(self, t: float, x: Array, u: Array) -> Array:
        """(2 size,) distances to the ends of the region, not negative inside it; two for every signal."""
        v, mode = self.limited(x, u), self.mode
        below, above = self.lower - v, v - self.upper
        first = np.where(mode < 0, below, np.where(mode > 0, above, -below))
        return np.concatenate((first, np.where(mode == 0, -above, first)))


class Saturation(Limited):
    """y = u limited to [lower, upper]; the integration stops and starts again where a limit is met or left."""

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        return self.capped(u)

    def affine(self) -> Affine:
        return without_states(self.free, self.capped(0.0))


class DeadZone(Limited):
    """y = 0 while lower <= u <= upper, beyond it the distance to the nearer end."""

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        return u - self.capped(u)

    def affine(self) -> Affine:
        return without_states(np.eye(self.n_out) - self.free, 0.0 - self.capped(0.0))


class Relay(Piecewise):
    """Two values: on above `upper`, off below `lower`, unchanged in between. It starts off, unless `initially_on`."""

    event_word = "switch"

    def __init__(
        self, name: str, lower: Numbers, upper: Numbers, off: float = 0.0, on: float = 1.0, size: int = 1,
        initially_on: bool = False,
    ) -> None:  # fmt: skip
        super().__init__(name, size, 1)
        self.lower, self.upper = spread(name, "limits", "simulation.limits", size, lower, upper)
        if not np.all(self.lower <= self.upper):
            raise UsageError(f"{name}: the lower limit must not be above the upper one", "simulation.limits")
        self.off, self.on = float(off), float(on)
        self.mode0 = np.full(size, int(initially_on))
        self.start()

    def piece(self, t: float, x: Array, u: Array) -> Index:
        return np.where(u > self.upper, 1, np.where(u < self.lower, 0, self.mode))

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        return np.where(self.mode > 0, self.on, self.off)

    def events(self, t: float, x: Array, u: Array) -> Array:
        return np.where(self.mode > 0, u - self.lower, self.upper - u)


class Quantizer(Piecewise):
    """y = the nearest multiple of `interval`."""

    event_word = "level"

    def __init__(self, name: str, interval: Numbers, size: int = 1) -> None:
        super().__init__(name, size, 2)
        (self.interval,) = spread(name, "intervals", "simulation.size", size, interval)
        if not np.all((self.interval > 0.0) & np.isfinite(self.interval)):
            raise UsageError(f"{name}: the interval of a quantizer must be positive, not {interval}", "simulation.size")

    def piece(self, t: float, x: Array, u: Array) -> Index:
        levels = np.floor(u / self.interval + 0.5)
        if not np.all(np.abs(levels) < 2.0**53):
            k = int(np.argmax(np.abs(levels)))
            text = f"{self.name} at t = {t:.9g}: input {k + 1} is {u[k]:.9g}, beyond 2^53 intervals"
            raise AnalysisError(text, "simulation.beyond-table")
        return levels.astype(np.int64)

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        return self.mode * self.interval

    def events(self, t: float, x: Array, u: Array) -> Array:
        place = u / self.interval + 0.5  # the same number as in `piece`, so that both agree to the last digit
        return np.concatenate((place - self.mode, self.mode + 1.0 - place))


class LookupTable(Piecewise):
    """y by interpolation in (points, values); every signal reads the same table.

    interpolation   "linear" (default), "cubic" (monotone, with continuous slope) or "step" (the value of the last
                    point that is not above u)
    beyond          "hold" the end values (default), "extrapolate" the end pieces, or "error" (AnalysisError)
    Raises UsageError for points that do not increase or another number of values.
    """

    event_word = "point"
    KINDS, ENDS = ("linear", "cubic", "step"), ("hold", "extrapolate", "error")

    def __init__(
        self, name: str, points: Sequence[float], values: Sequence[float], interpolation: str = "linear",
        beyond: str = "hold", size: int = 1,
    ) -> None:  # fmt: skip
        super().__init__(name, size, 2)
        x, y = np.asarray(points, float).ravel(), np.asarray(values, float).ravel()
        if len(x) != len(y) or len(x) < 2 or not np.isfinite([x, y]).all() or np.any(np.diff(x) <= 0.0):
            text = f"{name}: a table needs two or more increasing points and as many values, not {len(x)} and {len(y)}"
            raise UsageError(text, "simulation.table")
        if interpolation not in self.KINDS or beyond not in self.ENDS:
            text = (
                f"{name}: interpolation is one of {', '.join(self.KINDS)}, beyond one of {', '.join(self.ENDS)};"
                f" not {interpolation}, {beyond}"
            )
            raise UsageError(text, "simulation.table")
        self.points, self.beyond, self.stepwise = x, beyond, interpolation == "step"
        # Piece k = 0 ... n lies before point k. Its polynomial is c0 + c1 d + c2 d^2 + c3 d^3 of d = u - origin.
        inner = np.zeros((4, len(x) - 1))
        if interpolation == "cubic":
            from scipy.interpolate import PchipInterpolator

            inner = PchipInterpolator(x, y).c[::-1]
        else:
            inner[0] = y[:-1]
            if not self.stepwise:
                inner[1] = np.diff(y) / np.diff(x)
        ends = np.zeros((4, 2))
        ends[0] = y[0], y[-1]
        if beyond == "extrapolate" and not self.stepwise:
            d = x[-1] - x[-2]
            ends[1] = inner[1, 0], inner[1, -1] + 2.0 * inner[2, -1] * d + 3.0 * inner[3, -1] * d**2
        self.origin = np.concatenate((x[:1], x[:-1], x[-1:]))
        self.coefficients = np.column_stack((ends[:, 0], inner, ends[:, 1]))
        self.low = np.concatenate(([-np.inf], x))
        self.high = np.concatenate((x, [np.inf]))

    def piece(self, t: float, x: Array, u: Array) -> Index:
        found = np.searchsorted(self.points, u, side="right")
        last = u == self.points[-1]  # the end of the table belongs to its last piece
        found = np.where(last & ~np.full(len(u), self.stepwise), len(self.points) - 1, found)
        if self.beyond == "error" and np.any((found == 0) | (found == len(self.points)) & ~last):
            k = int(np.argmax((found == 0) | (found == len(self.points))))
            text = (
                f"{self.name} at t = {t:.9g}: input {k + 1} is {u[k]:.9g}, the table reaches from"
                f" {self.points[0]:.9g} to {self.points[-1]:.9g}; make it longer or choose beyond = hold"
            )
            raise AnalysisError(text, "simulation.beyond-table")
        return found

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        d, c = u - self.origin[self.mode], self.coefficients[:, self.mode]
        return c[0] + d * (c[1] + d * (c[2] + d * c[3]))

    def events(self, t: float, x: Array, u: Array) -> Array:
        return np.concatenate((u - self.low[self.mode], self.high[self.mode] - u))


def spread(name: str, what: str, code: str, size: int, *values: Numbers) -> list[Array]:
    """Each as (size,). Raises UsageError of this code for another number of values."""
    try:
        return [np.broadcast_to(np.asarray(v, float), (size,)).copy() for v in values]
    except ValueError:
        raise UsageError(f"{name}: {what} are one number or {size}, one for each signal", code) from None


def limits(name: str, lower: Numbers, upper: Numbers, size: int) -> tuple[Array, Array]:
    """(size,) each. Raises UsageError when a lower limit is not below the upper one, or their number is wrong."""
    low, high = spread(name, "limits", "simulation.limits", size, lower, upper)
    if not np.all(low < high):
        raise UsageError(f"{name}: every lower limit must be below the upper one", "simulation.limits")
    return low, high
