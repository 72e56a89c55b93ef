"""All frames of a run in memory, with access by coordinate, by node and by element."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.arrays import Array, Index
from spacar.errors import UsageError
from spacar.expressions.evaluation import frequencies
from spacar.expressions.result_places import ELEMENT, NODE, place, places
from spacar.frame import E_FIELDS, X_FIELDS, Frame, StoredFrames, column, joined
from spacar.mechanism.result_tables import model_tables
from spacar.modes import find_mode, registered
from spacar.summary import LINES, counted, few, with_picture

if TYPE_CHECKING:
    from spacar.mechanism import Mechanism
    from spacar.stream import Run

X_VARIABLES = (*X_FIELDS, "xcompl", "xerr")
E_VARIABLES = E_FIELDS


@dataclass(frozen=True, repr=False)
class Result:
    """A finished run. `result['x']` is (steps, nx); `lnp` and `le` are the 1-based tables of the result files.

    What a file holds once (rl0, einit, estiff, rxyz, nxp, ndof ...) has the same name here: `result['rl0']`; all
    of them are in `tables`. `header` holds what the analysis states: NNOM, NU, NY, condition ...; `nominal` is the
    motion that mode 3 linearized along.

    >>> import spacar
    >>> result = spacar.run(7, "data/plbeam5.dat")
    >>> result.frequencies.shape  # steps, modes [Hz]
    (1, 10)
    """

    mechanism: Mechanism
    mode: int
    frames: Sequence[Frame]
    report: tuple[str, ...]
    header: Mapping[str, Any]
    nominal: Any = None

    @classmethod
    def collect(cls, run: Run) -> Result:
        """Iterate over a run to its end."""
        frames = joined(tuple(run.blocks()))
        return cls(run.mechanism, run.mode.number, frames, tuple(run.report.lines), run.header.copy(), run.nominal)

    def draw(self, path: str | Path | None = None, **options: Any) -> Any:
        """A matplotlib figure of one or more steps, also written to `path`; options as `spacar_drawing.draw`."""
        return registered("draw")(self, path, **options)

    def animate(self, path: str | Path | None = None, **options: Any) -> Any:
        """Write an animation (gif, mp4) and return its path; without `path` one that a notebook shows.

        options   as `spacar_drawing.animate`
        """
        return registered("animate")(self, path, **options)

    def plot(self, *expressions: str, path: str | Path | None = None, against: str = "t") -> Any:
        """A matplotlib figure of expressions such as 'x[6,1]' over `against`, also written to `path`."""
        return registered("plot")(self, *expressions, path=path, against=against)

    def stress(self, **options: Any) -> Any:
        """Stress resultants and stresses along the beams as numbers; options as `spacar_drawing.stress`."""
        return registered("stress")(self, **options)

    def ss(self, step: int = 1) -> Any:
        """A, B, C, D of a step (from 1, -1 the last) of mode 3, 4 or 9, with the names of states, inputs and outputs.

        `A, B, C, D = result.ss()`; `.to_scipy()`, `.to_control()` for other libraries. Raises UsageError for another
        mode or step.
        """
        return registered("state_space_of")(self, step)

    def save(self, name: str | Path, wait: bool = False) -> tuple[Path, ...]:
        """Write NAME.log, NAME.sbd and what else the mode fills, as `spacar MODE NAME` does. Their paths, log first.

        name   path without ending;  wait   for another run that is writing them, instead of an error

        Raises UsageError when they cannot be written.
        """
        paths: tuple[Path, ...] = registered("save_result")(self, name, wait)
        return paths

    def to_pandas(self, *expressions: str) -> Any:
        """A pandas.DataFrame, one row a step, a column for each of `expressions`, default all: `x[6,1]`, `sig[1,1]` ...
        Units are in `attrs`.

        Raises UsageError without pandas (`pip install 'spacar[tables]'`) and for an expression that is none.
        """
        return registered("to_pandas")(self, expressions)

    def to_xarray(self) -> Any:
        """An xarray.Dataset over t, coordinate (node, number) and deformation (element, mode), with the matrices of the
        linearized equations. Raises UsageError without xarray (`pip install 'spacar[tables]'`).
        """
        return registered("to_xarray")(self)

    def __repr__(self) -> str:
        return result_summary(self)

    def _repr_html_(self) -> str:
        """The summary with a picture, for notebooks; without the picture where it cannot be drawn."""
        return with_picture(repr(self), "inline_picture", self)

    @property
    def frequencies(self) -> Array:
        """(steps, n) |eigenvalue| / 2 pi [Hz] from low to high, one for each pair of complex eigenvalues; nan fills up
        steps with fewer. Raises UsageError when the mode computes no eigenvalues.
        """
        return frequencies(self["eigval"])

    @property
    def lnp(self) -> Index:
        """(nodes, 4) places of the coordinates of every node in x, from 1; 0 for none (files.md section 4)."""
        return self.mechanism.numbering.lnp

    @property
    def le(self) -> Index:
        """(elements, n) places of the deformations of every element in e, from 1; 0 for none (files.md section 4)."""
        return self.mechanism.numbering.le

    @cached_property
    def tables(self) -> dict[str, Any]:
        """Sizes, tables and parameters of the model by their names in the result files, without a step axis."""
        return model_tables(self.mechanism)

    @property
    def t(self) -> Array:
        """(steps,) time [s]; in the stationary modes the number of the load step."""
        return np.asarray(self["t"])

    def _column(self, name: str) -> Any:
        """A variable of all steps, which may be a part of the frames; None where they do not have it."""
        return column(self.frames, name) if len(self.frames) or name == "t" else None

    def __getitem__(self, name: str) -> Any:
        """A variable of all steps, step first, or one of `tables`. Raises UsageError for a name that is neither."""
        found = self._column(name) if isinstance(name, str) else None
        if found is not None:
            return found.copy() if isinstance(self.frames, StoredFrames) else found
        if name in self.tables:  # made when somebody asks for one of them
            return self.tables[name]
        text = f"the variable {name} was not computed in this run of mode {self.mode}; result.keys() lists what was"
        raise UsageError(text, "result.missing")

    def keys(self) -> list[str]:
        """Names of the variables of the steps, then those of `tables`: what `result[name]` gives."""
        first = self.frames[0] if len(self.frames) else None
        stored = [] if first is None else [*(f.name for f in fields(first)), *first.matrices, *first.state_space]
        inner = ("matrices", "state_space", "log", "statistics", "lost")
        return list(dict.fromkeys([*(n for n in stored if n not in inner and n in self), *self.tables]))

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and (self._column(name) is not None or name in self.tables)

    def __iter__(self) -> Iterator[str]:
        return iter(self.keys())

    def __len__(self) -> int:
        """The number of names, as of a dictionary; of steps: `len(result.t)`."""
        return len(self.keys())

    def node(self, number: int, coordinate: int | None = None, variable: str = "x") -> Array:
        """(steps,) one coordinate (from 1) of the node of this number, or (steps, n) all of them; variable: x, xd, xdd,
        fx, fxgrav, fxtot, xcompl or xerr.
        """
        return self._entry(variable, X_VARIABLES, self.lnp, number, coordinate, NODE)

    def element(self, number: int, mode: int | None = None, variable: str = "e") -> Array:
        """(steps,) one deformation mode (from 1) of the element `number`, or (steps, n) all of them; variable: e, ed,
        edd or sig.
        """
        return self._entry(variable, E_VARIABLES, self.le, number, mode, ELEMENT)

    def _entry(
        self, variable: str, known: tuple[str, ...], table: Index, number: int, k: int | None, words: tuple[str, str]
    ) -> Array:
        """(steps,) what `place` finds, of its own; without k (steps, n) what `places` finds."""
        if variable not in known:
            text = f"{variable} is no variable of {words[0]}s; these are {', '.join(known)}"
            raise UsageError(text, "result.variable")
        found = self._column(variable)
        if found is None:
            found = self[variable]  # says what is wrong
        if k is None:
            return np.asarray(found).take(places(table, number, words), 1)
        return np.array(found[:, place(table, number, k, words)])


def result_summary(result: Result) -> str:
    """Model, mode, steps, degrees of freedom, frequencies of the last step, warnings."""
    mode, numbering = find_mode(result.mode), result.mechanism.numbering
    n = len(result.frames)
    lines = [f"Result of {result.mechanism.deck.source}, mode {mode.number}: {mode.title}"]
    t = result.t
    span = f", t = {t[0]:.6g} to {t[-1]:.6g}{' s' * mode.timed}" if n > 1 else ""
    lines.append(f"  steps       {n}{span}")
    coordinates, deformations = counted(numbering.nx, "coordinate"), counted(numbering.ne, "deformation")
    lines.append(f"  size        {coordinates} x, {deformations} e")
    lines.append(f"  freedom     {counted(numbering.ndof, 'degree')} of freedom, {numbering.nddof} of them dynamic")
    if n and "eigval" in result.frames[-1].matrices:
        lines.append(f"  frequencies {few(result.frequencies[-1])} Hz (last step)")
    if n and "lmult" in result.frames[-1].matrices:
        lines.append(f"  multipliers {few(np.ravel(result['lmult'][-1]))} (last step)")
    if "accuracy" in result.header:
        found, target = result.header["accuracy"], result.header["accuracy"].target
        estimate = f"{found.estimate:.2e} of the amplitudes" if np.isfinite(found.estimate) else "not known"
        lines.append(f"  accuracy    {estimate}" + (f", asked for {target:g}" if target is not None else ""))
    warnings = [line for line in result.report if line.startswith("warning")]
    room = LINES - 1 - len(lines)
    lines += [f"  {line}" for line in warnings[:room]]
    if len(warnings) > room:
        lines[-1] = f"  ... {len(warnings) - room + 1} more warnings in .report"
    positions = np.flatnonzero((result.lnp[:, 1] > 0) & (result.lnp[:, 3] == 0))
    node = int(positions[-1]) + 1
    lines.append(f"  result.node({node}, 1), .element(1, 1), ['x'], .plot('x[{node},1]'), .draw()")
    return "\n".join(lines)
