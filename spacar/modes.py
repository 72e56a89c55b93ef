"""The table mode -> analysis, and the two calls that everybody uses: `frames` (a stream) and `run` (a result)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spacar.errors import Report, UsageError
from spacar.frame import Frame
from spacar.options import checked_options

if TYPE_CHECKING:
    from spacar.deck import Deck
    from spacar.mechanism import Mechanism
    from spacar.result import Result


@dataclass(frozen=True)
class Mode:
    """One analysis: where its generator of frames is, and which result files it fills."""

    number: int
    title: str
    analysis: str  # "module:function" of a generator (run: Run) -> Iterator[Frame]
    files: tuple[str, ...]  # of "sbd", "sbm", "ltv"


MODES = {
    mode.number: mode
    for mode in (
        Mode(0, "kinematic check", "spacar.kinematics.analysis:check", ("sbd",)),
        Mode(1, "forward dynamics", "spacar.dynamics.analysis:forward", ("sbd",)),
        Mode(2, "inverse dynamics", "spacar.inverse.analysis:inverse", ("sbd", "ltv")),
        Mode(3, "linearization along set-points", "spacar.inverse.analysis:along", ("sbd", "sbm", "ltv")),
        Mode(4, "forward dynamics with linearization", "spacar.linear.analysis:forward", ("sbd", "sbm", "ltv")),
        Mode(7, "stationary solution, eigenvalues", "spacar.linear.analysis:eigenvalues", ("sbd", "sbm")),
        Mode(8, "stationary solution, buckling", "spacar.linear.analysis:buckling", ("sbd", "sbm")),
        Mode(9, "stationary solution, state space", "spacar.linear.analysis:state_space_matrices",
             ("sbd", "sbm", "ltv")),
        Mode(10, "stationary solution, eigenvalues and buckling", "spacar.linear.analysis:vibration_and_buckling",
             ("sbd", "sbm")),
    )
}  # fmt: skip


@dataclass
class Run:
    """One analysis, ready to be iterated over. Everything but `report` and `header` is fixed from the start.

    report    warnings and information for the log, complete when the iteration has ended
    header    scalars and arrays that the analysis states before its first frame (NNOM, NU, NY, condition ...)
    n_frames  number of frames to come, None if unknown
    nominal   mode 3 only: the earlier mode 2 result
    """

    mode: Mode
    mechanism: Mechanism
    report: Report = field(default_factory=Report)
    header: dict[str, Any] = field(default_factory=dict)
    n_frames: int | None = None
    nominal: Any = None

    def __iter__(self) -> Iterator[Frame]:
        module, _, name = self.mode.analysis.partition(":")
        analysis: Callable[[Run], Iterator[Frame]] = getattr(import_module(module), name)
        return _without_warnings(analysis(self))


def _without_warnings(frames: Iterator[Frame]) -> Iterator[Frame]:
    """The frames, without NumPy's warnings: what is infinite or undefined is found where it matters, and named."""
    import numpy as np

    while True:
        with np.errstate(all="ignore"):
            frame = next(frames, None)
        if frame is None:
            return
        yield frame


def find_mode(number: int) -> Mode:
    """The mode of this number; a minus sign (no drawing) does not matter. Raises UsageError."""
    if abs(number) not in MODES:
        known = ", ".join(str(m) for m in MODES)
        old = abs(number) in (5, 6)
        hint = "; modes 5 and 6 were experimental in the original and are not provided" if old else ""
        raise UsageError(f"mode {number} does not exist; the modes are {known}{hint}", "usage.mode")
    return MODES[abs(number)]


def frames(mode: int, source: str | Path | Deck, *, nominal: Any = None, **options: Any) -> Run:
    """Prepare an analysis: read, check and number the model; the frames come when the returned Run is iterated over.

    mode      0 to 4, 7 to 10, see MODES;  source   path of the input file, or a Deck
    nominal   mode 3 only: result of mode 2
    options   override the deck for this run: atol, rtol, integrator, step, duration, n_steps, compiled (see Settings)

    Raises UsageError (unknown mode or option, wrong value of one), InputError (bad input) now; AnalysisError while
    iterating.
    """
    from spacar.deck import Deck, read_deck
    from spacar.mechanism import build

    found = find_mode(mode)
    options, notes = checked_options(options)
    deck = source if isinstance(source, Deck) else read_deck(source, found.number)
    prepared = Run(found, build(deck, found.number, **options), nominal=nominal)
    for note in notes:
        prepared.report.add(f"warning: {note}")
    return prepared


def run(mode: int, source: str | Path | Deck, *, nominal: Any = None, **options: Any) -> Result:
    """Run an analysis to its end and keep all frames in memory. Errors as `frames`.

    mode      0 to 4, 7 to 10, see MODES;  source   path of the input file, or a Deck
    nominal   mode 3 only: result of mode 2;  options   override the deck for this run, see `frames`
    """
    from spacar.result import Result

    prepared = frames(mode, source, nominal=nominal, **options)
    return Result.collect(prepared)
