"""Signals given in advance: constant, step, ramp, sine, pulses, a table over time.

Values between the stored times of a result: stepwise, linear or by a cubic spline (reference/files.md section 7).

Stepwise: constant around each stored time, changing half-way to the next one. Beyond the last stored time SPACAR leaves
the value undefined; here it is an error unless `hold` is asked for, which keeps the last value. The same applies before
the first one.
"""

from bisect import bisect_right
from collections.abc import Sequence
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError, UsageError
from spacar.simulation.blocks import Block, Names
from spacar.simulation.switching_blocks import Numbers, spread

KINDS = ("step", "linear", "spline")
# Chosen, for times summed from decimal steps: a time outside by less than this part of the span is the first or last.
ROUNDING = 1e-9


class Table:
    """A time-varying array: `times` (k,) increasing [s], `values` (k, ...). Raises UsageError for wrong arguments."""

    def __init__(
        self, times: Array, values: Array, kind: str = "linear", hold: bool = False, name: str = "table"
    ) -> None:
        self.times = np.asarray(times, float)
        self.values = np.asarray(values, float)
        if kind not in KINDS:
            raise UsageError(
                f"{name}: interpolation '{kind}' does not exist; choose {', '.join(KINDS)}", "simulation.table"
            )
        if self.times.ndim != 1 or len(self.times) != len(self.values) or not len(self.times):
            shape = (self.times.shape, self.values.shape)
            raise UsageError(f"{name}: times and values have the shapes {shape[0]} and {shape[1]}", "simulation.table")
        if np.any(np.diff(self.times) <= 0.0):
            raise UsageError(f"{name}: the stored times do not increase", "simulation.table")
        self.kind, self.hold, self.name = kind, hold, name
        self._list = self.times.tolist()
        self._middles = (0.5 * (self.times[1:] + self.times[:-1])).tolist()
        self._spline: Any = None
        if kind == "spline" and len(self._list) > 1:
            from scipy.interpolate import CubicSpline

            self._spline = CubicSpline(self.times, self.values, axis=0)

    @property
    def breaks(self) -> tuple[float, ...]:
        """Times where the value jumps (step) or has a kink (linear)."""
        if len(self._list) == 1:
            return ()
        held = (self._list[0], self._list[-1]) if self.hold else ()
        return tuple({"step": self._middles, "linear": self._list, "spline": held}[self.kind])

    def __call__(self, t: float) -> Array:
        """Value at a time, with the shape of one stored value. Raises AnalysisError outside the stored times."""
        times = self._list
        if not times[0] <= t <= times[-1]:
            margin = np.inf if self.hold else ROUNDING * (times[-1] - times[0])
            if not times[0] - margin <= t <= times[-1] + margin:
                text = (
                    f"{self.name} is stored from t = {times[0]:.9g} to {times[-1]:.9g} s, but needed at t = {t:.9g};"
                    " make the trajectories longer, stop earlier, or hold the last value (hold)"
                )
                raise AnalysisError(text, "simulation.beyond-table")
            t = min(max(t, times[0]), times[-1])
        if self.kind == "step" or len(times) == 1:
            return np.asarray(self.values[bisect_right(self._middles, t)])
        if self._spline is not None:
            return self._spline(t)
        k = min(max(bisect_right(times, t) - 1, 0), len(times) - 2)
        w = (t - times[k]) / (times[k + 1] - times[k])
        return np.asarray((1.0 - w) * self.values[k] + w * self.values[k + 1])


class Source(Block):
    """Base: outputs that need no inputs. With `given` numbers there are as many as the longest of these has; `values`:
    these for each output."""

    def __init__(self, name: str, outputs: Names, *given: Numbers) -> None:
        super().__init__(name, 0, max(map(np.size, given)) if given else outputs)
        self.values = spread(name, "values", "simulation.size", self.n_out, *given)


class Constant(Source):
    """y = value."""

    def __init__(self, name: str, value: Numbers) -> None:
        super().__init__(name, 0, value)
        (self.value,) = self.values

    def state_outputs(self, t: float, x: Array) -> Array:
        return self.value


class StepSignal(Source):
    """y = before for t < time [s], then after. A step of the integration ends exactly at that time."""

    def __init__(self, name: str, time: float = 0.0, after: Numbers = 1.0, before: Numbers = 0.0) -> None:
        super().__init__(name, 0, before, after)
        self.time, self.breaks = float(time), (float(time),)
        self.before, self.after = self.values

    def state_outputs(self, t: float, x: Array) -> Array:
        return self.before if t < self.time else self.after


class Ramp(Source):
    """y = start for t < time, then start + slope (t - time)."""

    def __init__(self, name: str, slope: Numbers, time: float = 0.0, start: Numbers = 0.0) -> None:
        super().__init__(name, 0, slope, start)
        self.time, self.breaks = float(time), (float(time),)
        self.slope, self.begin = self.values

    def state_outputs(self, t: float, x: Array) -> Array:
        return self.begin + self.slope * max(t - self.time, 0.0)


class Sine(Source):
    """y = bias + amplitude sin(2 pi frequency t + phase); frequency [Hz], phase [rad]."""

    def __init__(
        self, name: str, amplitude: Numbers, frequency: Numbers, phase: Numbers = 0.0, bias: Numbers = 0.0
    ) -> None:
        super().__init__(name, 0, amplitude, frequency, phase, bias)
        self.amplitude, self.frequency, self.phase, self.bias = self.values

    def state_outputs(self, t: float, x: Array) -> Array:
        return self.bias + self.amplitude * np.sin(2.0 * np.pi * self.frequency * t + self.phase)


class Pulses(Source):
    """y = high for a part `duty` (0 to 1) of every `every` seconds from `time`, otherwise low; edges are exact."""

    def __init__(
        self, name: str, every: float, duty: float = 0.5, high: Numbers = 1.0, low: Numbers = 0.0, time: float = 0.0
    ) -> None:
        super().__init__(name, 0, high, low)
        if not (every > 0.0 and 0.0 < duty < 1.0):
            text = f"{name}: pulses need every > 0 and a duty between 0 and 1, not {every:g} and {duty:g}"
            raise UsageError(text, "simulation.size")
        self.every, self.duty, self.time = float(every), float(duty), float(time)
        self.high, self.low = self.values

    def stops_within(self, span: float) -> float:
        return 2.0 * span / self.every

    def breaks_until(self, first: float, last: float) -> list[float]:
        """All edges between two times."""
        k = np.arange(max(np.ceil((first - self.time) / self.every) - 1.0, 0.0), (last - self.time) / self.every + 1.0)
        edges = np.concatenate((self.time + k * self.every, self.time + (k + self.duty) * self.every))
        return [float(t) for t in edges if first < t < last]

    def state_outputs(self, t: float, x: Array) -> Array:
        if t < self.time:
            return self.low
        return self.high if (t - self.time) / self.every % 1.0 < self.duty else self.low


class TimeSeries(Source):
    """Stored values (k, n) at times (k,), interpolated "step", "linear" or "spline" (`Table`)."""

    def __init__(
        self, name: str, times: Sequence[float] | Array, values: Array, interpolation: str = "linear",
        hold: bool = False,
    ) -> None:  # fmt: skip
        table = np.asarray(values, float)
        table = table[:, None] if table.ndim == 1 else table
        super().__init__(name, table.shape[1])
        self.table = Table(np.asarray(times, float), table, interpolation, hold, name)
        self.breaks = self.table.breaks

    def state_outputs(self, t: float, x: Array) -> Array:
        return self.table(t)
