"""What an analysis yields: blocks of frames, one Frame per stored step.

A block holds the frames that became ready together: one, or of motions in C many (`StoredFrames`), whose numbers stay
in columns. Sinks (log, result files, progress, plot) consume the stream frame by frame.
"""

from abc import abstractmethod
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, chain
from typing import Any

import numpy as np

from spacar.arrays import Array

X_FIELDS = ("x", "xd", "xdd", "fx", "fxgrav", "fxtot")  # (nx,) of every frame
E_FIELDS = ("e", "ed", "edd", "sig")  # (ne,)


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

    >>> import spacar
    >>> frame = spacar.run(1, "data/crank.dat").frames[-1]
    >>> f"{frame.t:.1f} s"
    '0.1 s'
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

    def value(self, name: str) -> Any:
        """What is stored under a name, in whatever place; None where nothing is."""
        return {**self.state_space, **self.matrices}.get(name, getattr(self, name, None))


class _Frames(Sequence[Frame]):
    """Frames that are made, or found, when they are asked for; slices are tuples."""

    __slots__ = ()

    @abstractmethod
    def _frame(self, i: int) -> Frame: ...

    def __getitem__(self, i: Any) -> Any:
        if isinstance(i, slice):
            return tuple(self._frame(k) for k in range(*i.indices(len(self))))
        return self._frame(i)


class StoredFrames(_Frames):
    """Frames that became ready together, or all of a run: columns from which each is made when it is asked for.

    t           (steps,) [s]
    variables   (steps, n) each, by name
    statistics  (steps,) each, by name; may be added later
    lost        of every step, as in a frame; empty where no step has any
    """

    __slots__ = ("lost", "statistics", "t", "variables")

    def __init__(
        self, t: Array, variables: dict[str, Array], statistics: Mapping[str, Array],
        lost: Sequence[dict[int, str]] = (),
    ) -> None:  # fmt: skip
        self.t, self.variables, self.statistics, self.lost = t, variables, statistics, lost

    def __len__(self) -> int:
        return len(self.t)

    def column(self, name: str) -> Array | None:
        """A variable of all steps; None where it is not kept as one."""
        return self.t if name == "t" else self.variables.get(name)

    def _frame(self, i: int) -> Frame:
        frame = Frame(t=float(self.t[i]), **{name: array[i] for name, array in self.variables.items()})
        frame.statistics = {name: int(array[i]) for name, array in self.statistics.items()}
        if self.lost:
            frame.lost = self.lost[i]
        return frame


class FramesInRows(StoredFrames):
    """The same, whose variables are parts of `rows` (steps, 6 nx + 4 ne or more): X_FIELDS, then E_FIELDS.

    sizes   nx, ne
    """

    __slots__ = ("rows",)

    def __init__(self, t: Array, rows: Array, sizes: tuple[int, int], lost: Sequence[dict[int, str]] = ()) -> None:
        self.rows = rows
        nx, ne = sizes
        variables = {name: rows[:, k * nx : (k + 1) * nx] for k, name in enumerate(X_FIELDS)}
        of_e = rows[:, len(X_FIELDS) * nx :]
        variables |= {name: of_e[:, k * ne : (k + 1) * ne] for k, name in enumerate(E_FIELDS)}
        super().__init__(t, variables, {}, lost)

    def __reduce__(self) -> Any:
        """A copy, here or in another process, has variables of its own."""
        return StoredFrames, (self.t, self.variables, self.statistics, self.lost)


class JoinedFrames(_Frames):
    """All frames of a run, in the blocks in which they became ready."""

    def __init__(self, blocks: Sequence[Sequence[Frame]]) -> None:
        self.blocks = blocks
        self._ends = list(accumulate(map(len, blocks)))

    def __len__(self) -> int:
        return self._ends[-1]

    def __iter__(self) -> Iterator[Frame]:
        return chain.from_iterable(self.blocks)

    def _frame(self, i: int) -> Frame:
        k = i + len(self) if i < 0 else i
        if not 0 <= k < len(self):
            raise IndexError(i)
        block = bisect_right(self._ends, k)
        return self.blocks[block][k - self._ends[block]]


def joined(blocks: Sequence[Sequence[Frame]]) -> Sequence[Frame]:
    """The frames of all blocks in one sequence; arrays that are kept stay where they are."""
    if len(blocks) == 1 and isinstance(blocks[0], StoredFrames):
        return blocks[0]
    if any(isinstance(block, StoredFrames) for block in blocks):
        return JoinedFrames(blocks)
    return tuple(chain.from_iterable(blocks))


def column(frames: Sequence[Frame], name: str) -> Array | None:
    """A variable of all frames, step first, which may be a part of them; None where one of them does not have it."""
    if isinstance(frames, JoinedFrames):
        parts = [column(block, name) for block in frames.blocks]
        found = [part for part in parts if part is not None]
        return np.concatenate(found) if len(found) == len(parts) else None
    whole = frames.column(name) if isinstance(frames, StoredFrames) else None
    if whole is not None:
        return whole
    values = [frame.value(name) for frame in frames]
    return None if any(value is None for value in values) else np.array(values)
