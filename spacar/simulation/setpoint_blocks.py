"""Blocks that read a stored result: SetpointU0, SetpointSigma0, ReferenceY0, TimesM0, Ltv
(reference/files.md section 7).

`interpolation` is "step", "linear" (default) or "spline"; M0 and the matrices of Ltv are stepwise or linear.
`hold` keeps the first and last values outside the stored times instead of raising an error.
"""

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.simulation.blocks import Block
from spacar.simulation.reduction import reduce_modes
from spacar.simulation.signal_sources import Source, Table
from spacar.simulation.time_varying import TimeVarying


class _StoredVector(Source):
    """A stored vector as a function of time."""

    field = ""

    def __init__(self, data: TimeVarying, name: str = "", interpolation: str = "linear", hold: bool = False) -> None:
        (values,) = data.need(self.field)
        count, n = values.shape[1], data.n_nominal
        known = {"u0": data.inputs[:n], "sigma0": data.inputs[n:], "y0": data.outputs}[self.field]
        super().__init__(
            name or self.field, known if len(known) == count else [f"{self.field} {k + 1}" for k in range(count)]
        )
        self.table = Table(data.t, values, interpolation, hold, f"{self.name} of {data.name}")
        self.breaks = self.table.breaks

    def state_outputs(self, t: float, x: Array) -> Array:
        return self.table(t)


class SetpointU0(_StoredVector):
    """Nominal inputs u0(t) of a mode 2 or 3 result."""

    field = "u0"


class SetpointSigma0(_StoredVector):
    """Stresses sigma0(t) of the rigidified deformations of a mode 3 result."""

    field = "sigma0"


class ReferenceY0(_StoredVector):
    """Reference outputs y0(t) of a mode 2 or 3 result."""

    field = "y0"


class TimesM0(Block):
    """y = M0(t) u with the leading block of M0 of the given size (default: all of it)."""

    def __init__(
        self, data: TimeVarying, name: str = "times_m0", size: int | None = None, interpolation: str = "linear",
        hold: bool = False,
    ) -> None:  # fmt: skip
        (m0,) = data.need("m0")
        full = m0.shape[1]
        size = full if size is None else size
        if not 1 <= size <= full:
            raise UsageError(f"{name}: the size {size} is not between 1 and {full}, the size of M0", "simulation.size")
        _no_spline(name, interpolation)
        super().__init__(name, size, size)
        self.table = Table(data.t, m0[:, :size, :size], interpolation, hold, f"M0 of {data.name}")
        self.breaks = self.table.breaks

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        return self.table(t) @ u


class Ltv(Block):
    """dz/dt = A(t) z + B(t) u, y = C(t) z + D(t) u; with `modes`, reduced to that many modes (reduction.py)."""

    def __init__(
        self, data: TimeVarying, name: str = "ltv", interpolation: str = "linear", hold: bool = False,
        modes: int | None = None,
    ) -> None:  # fmt: skip
        _no_spline(name, interpolation)
        if modes is not None:
            data = reduce_modes(data, modes).system
        A, B, C = data.need("A", "B", "C")
        D = np.zeros((len(A), C.shape[1], B.shape[2])) if data.D is None else data.D
        n, m, p = A.shape[1], B.shape[2], C.shape[1]
        inputs = data.inputs if len(data.inputs) == m else m
        super().__init__(name, inputs, data.outputs if len(data.outputs) == p else p)
        self.system = Table(data.t, np.block([[A, B], [C, D]]), interpolation, hold, f"{name} of {data.name}")
        self.n = n
        self.x0 = np.zeros(n) if data.x0 is None else np.ravel(data.x0).astype(float)
        self.direct = np.any(D != 0.0, axis=(0, 2))
        self.breaks = self.system.breaks

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        return self.system(t)[self.n :] @ np.concatenate((x, u))

    def derivative(self, t: float, x: Array, u: Array) -> Array:
        return self.system(t)[: self.n] @ np.concatenate((x, u))


def _no_spline(name: str, interpolation: str) -> None:
    if interpolation == "spline":
        raise UsageError(f"{name}: matrices are interpolated stepwise or linearly, not by a spline", "simulation.table")
