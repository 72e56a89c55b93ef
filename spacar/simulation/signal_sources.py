"""Signals given in advance: constant, step, ramp, sine, pulses, a table over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.simulation.blocks import Block
from spacar.simulation.switching_blocks import Numbers
from spacar.simulation.time_tables import Table


class Source(Block):
    """Base: outputs `at(t)` that need no inputs."""

    def __init__(self, name: str, size: int) -> None:
        super().__init__(name, 0, size)

    def at(self, t: float) -> Array:
        """(n_out,) values at a time."""
        raise NotImplementedError

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        return self.at(t)

    def state_outputs(self, t: float, x: Array) -> Array:
        return self.at(t)

    def _spread(self, *values: Numbers) -> list[Array]:
        """Each as (n_out,). Raises UsageError for another number of values."""
        try:
            return [np.broadcast_to(np.asarray(v, float), (self.n_out,)).copy() for v in values]
        except ValueError:
            text = f"{self.name}: values are one number or {self.n_out}, one for each signal"
            raise UsageError(text, "simulation.size") from None


class Constant(Source):
    """y = value."""

    def __init__(self, name: str, value: Numbers) -> None:
        super().__init__(name, np.size(value))
        (self.value,) = self._spread(value)

    def at(self, t: float) -> Array:
        return self.value


class StepSignal(Source):
    """y = before for t < time [s], then after. A step of the integration ends exactly at that time."""

    def __init__(self, name: str, time: float = 0.0, after: Numbers = 1.0, before: Numbers = 0.0) -> None:
        super().__init__(name, max(np.size(after), np.size(before)))
        self.time, self.breaks = float(time), (float(time),)
        self.before, self.after = self._spread(before, after)

    def at(self, t: float) -> Array:
        return self.before if t < self.time else self.after


class Ramp(Source):
    """y = start for t < time, then start + slope (t - time)."""

    def __init__(self, name: str, slope: Numbers, time: float = 0.0, start: Numbers = 0.0) -> None:
        super().__init__(name, max(np.size(slope), np.size(start)))
        self.time, self.breaks = float(time), (float(time),)
        self.slope, self.begin = self._spread(slope, start)

    def at(self, t: float) -> Array:
        return self.begin + self.slope * max(t - self.time, 0.0)


class Sine(Source):
    """y = bias + amplitude sin(2 pi frequency t + phase); frequency [Hz], phase [rad]."""

    def __init__(
        self, name: str, amplitude: Numbers, frequency: Numbers, phase: Numbers = 0.0, bias: Numbers = 0.0
    ) -> None:
        super().__init__(name, max(map(np.size, (amplitude, frequency, phase, bias))))
        self.amplitude, self.frequency, self.phase, self.bias = self._spread(amplitude, frequency, phase, bias)

    def at(self, t: float) -> Array:
        return self.bias + self.amplitude * np.sin(2.0 * np.pi * self.frequency * t + self.phase)


class Pulses(Source):
    """y = high for a part `duty` (0 to 1) of every `every` seconds from `time`, otherwise low; edges are exact."""

    def __init__(
        self, name: str, every: float, duty: float = 0.5, high: Numbers = 1.0, low: Numbers = 0.0, time: float = 0.0
    ) -> None:
        super().__init__(name, max(np.size(high), np.size(low)))
        if not (every > 0.0 and 0.0 < duty < 1.0):
            text = f"{name}: pulses need every > 0 and a duty between 0 and 1, not {every:g} and {duty:g}"
            raise UsageError(text, "simulation.size")
        self.every, self.duty, self.time = float(every), float(duty), float(time)
        self.high, self.low = self._spread(high, low)

    def breaks_until(self, first: float, last: float) -> list[float]:
        """All edges between two times."""
        k = np.arange(max(np.ceil((first - self.time) / self.every) - 1.0, 0.0), (last - self.time) / self.every + 1.0)
        edges = np.concatenate((self.time + k * self.every, self.time + (k + self.duty) * self.every))
        return [float(t) for t in edges if first < t < last]

    def at(self, t: float) -> Array:
        if t < self.time:
            return self.low
        return self.high if (t - self.time) / self.every % 1.0 < self.duty else self.low


class TimeSeries(Source):
    """Stored values (k, n) at times (k,), interpolated "step", "linear" or "spline" (time_tables.Table)."""

    def __init__(
        self, name: str, times: Sequence[float] | Array, values: Array, interpolation: str = "linear",
        hold: bool = False,
    ) -> None:  # fmt: skip
        table = np.asarray(values, float)
        table = table[:, None] if table.ndim == 1 else table
        super().__init__(name, table.shape[1])
        self.table = Table(np.asarray(times, float), table, interpolation, hold, name)
        self.breaks = self.table.breaks

    def at(self, t: float) -> Array:
        return self.table(t)
