"""What an analysis yields: one Frame per stored step. Sinks (log, result files, progress, plot) consume the stream."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, overload

from spacar.arrays import Array


@dataclass(slots=True)
class Frame:
    """One stored state. Orders of x, e, q: files.md section 3. A field that the mode does not compute is None.

    t             time [s]; in the stationary modes the number of the stored load step
    x, xd, xdd    (nx,) coordinates and time derivatives [m, rad; Euler parameters 1]
    e, ed, edd    (ne,) deformations and time derivatives [m, rad]
    sig           (ne,) generalized stress resultants, dual to e [N, N m]
    fx, fxgrav    (nx,) applied nodal forces, gravity;  fxtot (nx,) total external forces, reactions included
    dx, de        (nx, nkdof), (ne, nkdof) configuration transfer functions (OUTLEVEL)
    dxc, dec      (nx, ndof), (ne, ndof) velocity transfer functions (OUTLEVEL)
    d2x, d2e      (nx, nkdof**2), (ne, nkdof**2) second order transfer functions (OUTLEVEL)
    bigd          (ne, nx) derivative of the deformations (mode 0);  bigds (entries, 3) the same of a large model: row,
                  column (from 1), value
    xcompl        (nx,) directional nodal compliances [m/N ...] (mode 8)
    xerr          (nx,) estimated largest error of the coordinates so far (accuracy)
    matrices      m0 c0 d0 k0 n0 g0 b0 ak0 bk0, and eigval eigvre eigvim lmult bmode, by their file name
    state_space   A B C D G sig0 u0 y0 m0 c0b k0b of the ltv file, by their file name
    log           transfer functions that only the log asks for: dx de d2x d2e d3x d3e bigd
    statistics    what the log prints of this step: right-hand sides, iterations, residuals
    lost          sentences about stresses of a user function that cannot act, by their row of e; each is reported once
    """

    t: float
    x: Array
    xd: Array
    xdd: Array
    e: Array
    ed: Array
    edd: Array
    sig: Array
    fx: Array
    fxgrav: Array
    fxtot: Array
    dx: Array | None = None
    de: Array | None = None
    dxc: Array | None = None
    dec: Array | None = None
    d2x: Array | None = None
    d2e: Array | None = None
    bigd: Array | None = None
    bigds: Array | None = None
    xcompl: Array | None = None
    xerr: Array | None = None
    matrices: dict[str, Array] = field(default_factory=dict)
    state_space: dict[str, Array] = field(default_factory=dict)
    log: dict[str, Array] = field(default_factory=dict)
    statistics: dict[str, Any] = field(default_factory=dict)
    lost: dict[int, str] = field(default_factory=dict)


class StoredFrames(Sequence[Frame]):
    """Frames of one run whose variables are kept as arrays, (steps, n) each by name; made when they are asked for."""

    def __init__(self, t: Array, variables: dict[str, Array], statistics: list[dict[str, Any]]) -> None:
        self.t, self.variables, self.statistics = t, variables, statistics

    def __len__(self) -> int:
        return len(self.t)

    @overload
    def __getitem__(self, i: int) -> Frame: ...
    @overload
    def __getitem__(self, i: slice) -> tuple[Frame, ...]: ...
    def __getitem__(self, i: int | slice) -> Frame | tuple[Frame, ...]:
        if isinstance(i, slice):
            return tuple(self[k] for k in range(*i.indices(len(self))))
        values = {name: array[i] for name, array in self.variables.items()}
        return Frame(t=float(self.t[i]), statistics=self.statistics[i], **values)
