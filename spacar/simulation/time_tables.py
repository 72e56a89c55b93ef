"""Values between the stored times of a result: stepwise, linear or by a cubic spline (reference/files.md section 7).

Stepwise: constant around each stored time, changing half-way to the next one. Beyond the last stored time SPACAR leaves
the value undefined; here it is an error unless `hold` is asked for, which keeps the last value. The same applies before
the first one.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError, UsageError

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
        self._margin = ROUNDING * (self._list[-1] - self._list[0])
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
            if not self.hold and not times[0] - self._margin <= t <= times[-1] + self._margin:
                text = (
                    f"{self.name} is stored from t = {times[0]:.9g} to {times[-1]:.9g} s, but needed at t = {t:.9g};"
                    " make the trajectories longer, stop earlier, or hold the last value (hold)"
                )
                raise AnalysisError(text, "simulation.beyond-table")
            t = min(max(t, times[0]), times[-1])
        if self.kind == "step" or len(times) == 1:
            return np.asarray(self.values[bisect_right(self._middles, t)])
        if self._spline is not None:
            return np.asarray(self._spline(t))
        k = min(max(bisect_right(times, t) - 1, 0), len(times) - 2)
        w = (t - times[k]) / (times[k + 1] - times[k])
        return np.asarray((1.0 - w) * self.values[k] + w * self.values[k + 1])
