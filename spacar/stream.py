"""A run: a mechanism with the analysis of a mode, iterated over as a stream of frames, and its consumers."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from spacar.errors import AnalysisError, Report, SpacarError
from spacar.frame import Frame, StoredFrames
from spacar.mechanism.rigid_search import rigid_parts
from spacar.modes import Mode, registered

if TYPE_CHECKING:
    from spacar.mechanism import Mechanism


class Sink(Protocol):
    """A consumer of frames: the log, a result file, a progress bar, a live plot.

    It is started with the run, gets every frame, and is finished with the error that ended the run, or None.
    """

    def start(self, run: Run) -> None: ...
    def frame(self, frame: Frame) -> None: ...
    def finish(self, error: BaseException | None) -> None: ...


@dataclass(frozen=True)
class AccuracyRequest:
    """The accuracy that is asked of a result: its error over the amplitude (None: the error is only estimated), for
    these expressions (none: those that `spacar.studies.runs.result_quantities` chooses). `mesh`: flexible beams may be
    divided for it."""

    target: float | None = None
    variables: tuple[str, ...] = ()
    mesh: bool = True


@dataclass
class Outcome:
    """How a consumed run ended: frames, the time of the last one [s, or load step], wall time [s], what ended it."""

    steps: int = 0
    last: float | None = None
    seconds: float = 0.0
    error: BaseException | None = None


@dataclass(repr=False)
class Run:
    """One analysis, ready to be iterated over. It writes `report`, `header` and `n_frames`, nothing else; a run with an
    accuracy gives `mechanism` the settings that it has chosen.

    report    warnings and information for the log, complete when the iteration has ended
    header    scalars and arrays that the analysis states before its first frame (NNOM, NU, NY, condition ...)
    n_frames  number of frames to come, None if unknown
    nominal   mode 3 only: the result of mode 2, or of modes 7 to 10, along which it linearizes
    accuracy  None, or the error of the result that is estimated and kept by several runs
    end       processor time at which the run is stopped [s]

    >>> import spacar
    >>> run = spacar.frames(1, "data/crank.dat")
    >>> sum(1 for frame in run)
    101
    """

    mode: Mode
    mechanism: Mechanism
    report: Report = field(default_factory=Report)
    header: dict[str, Any] = field(default_factory=dict)
    n_frames: int | None = None
    nominal: Any = None
    accuracy: AccuracyRequest | None = None
    end: float = np.inf

    def __repr__(self) -> str:
        model = self.mechanism.deck.source
        return f"Run of {model}, mode {self.mode.number}: {self.mode.title}\n  for frame in run: ...; run.save('name')"

    def blocks(self) -> Iterator[Sequence[Frame]]:
        """The frames, in blocks that became ready together. Stresses of a user function that cannot act are reported
        with the first block that has them."""
        made = self._made()
        while True:
            # What is infinite or undefined is found where it matters, and named.
            with np.errstate(all="ignore"):
                block = next(made, None)
            if block is None:
                return
            yield block

    def _made(self) -> Iterator[Sequence[Frame]]:
        reported, given = set[int](), 0
        parts = None if self.accuracy else rigid_parts(self.mechanism, self.mode)
        if parts is None:
            made = registered("accuracy" if self.accuracy else self.mode.analysis)(self)
        else:
            made = registered("without_rigid_parts")(self, parts)
        for block in made:
            for lost in block.lost if isinstance(block, StoredFrames) else [frame.lost for frame in block]:
                for row, sentence in lost.items():
                    if row not in reported:
                        reported.add(row)
                        self.report.add(sentence)
            yield block
            given += len(block)
            if given != self.n_frames:
                self.require_time(block[-1].t)

    def require_time(self, t: float | None) -> None:
        """Raises AnalysisError 'study.stopped' when the processor time is beyond `end`; t: where the run is."""
        if self.end < np.inf and time.process_time() > self.end:
            where = "" if t is None else f" at t = {t:.6g}"
            text = f"stopped{where}: a cheaper setting is better, or the budget is used"
            raise AnalysisError(text, "study.stopped")

    def __iter__(self) -> Iterator[Frame]:
        for block in self.blocks():
            yield from block

    def save(self, name: str | Path, wait: bool = False) -> tuple[Path, ...]:
        """Run, and write every frame to NAME.log, NAME.sbd ... as it comes: nothing is kept in memory. Their paths.

        name   of the files without ending;  wait   for another run that is writing them, instead of an error

        Raises UsageError when they cannot be written, and what ended the run; frames up to there stay in NAME.sbd.part.
        """
        paths: tuple[Path, ...] = registered("save_run")(self, name, wait)
        return paths

    def consume(self, *sinks: Sink, window: Sink | None = None) -> Outcome:
        """Hand every frame to every sink; however the run ends, finish the sinks with what ended it.

        They are finished in their order: the log is the last one that writes, so that it also tells of a result that
        could not be completed. `window` comes behind all of them: it shows what is written and counted already, and
        nothing is lost when it is closed or killed. Raises nothing: `error` of the outcome says what happened, also an
        interruption.
        """
        outcome = Outcome()
        begun = time.perf_counter()
        watching = () if window is None else (window,)
        try:
            for sink in (*sinks, *watching):
                sink.start(self)
            for frame in self:
                for sink in sinks:
                    sink.frame(frame)
                outcome.steps += 1
                outcome.last = frame.t
                if window is not None:
                    window.frame(frame)
        except (Exception, KeyboardInterrupt) as error:
            outcome.error = error
        for sink in (*sinks, *watching):
            try:
                sink.finish(outcome.error)
            except (SpacarError, OSError) as error:
                outcome.error = outcome.error or error
        outcome.seconds = time.perf_counter() - begun
        return outcome
