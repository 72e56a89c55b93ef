"""Results of Python written as the command writes them: NAME.log, NAME.sbd, NAME.sbm, NAME.ltv.

`Run.save` hands every frame on as it comes, `Result.save` those that are in memory. The files grow as `.part` and get
their names at the end, an earlier result becomes `.bak` (docs/promises.md).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from spacar.calls import path_of
from spacar.errors import Report, UsageError
from spacar.frame import Frame
from spacar.modes import find_mode
from spacar.result import Result
from spacar.stream import Run
from spacar_formats.log import LogSink
from spacar_formats.result_files import begin, result_sinks

ENDINGS = (".dat", ".log", ".sbd", ".sbm", ".ltv")


@dataclass
class StoredRun(Run):
    """A run that has been made: its frames come from memory."""

    frames: Sequence[Frame] = field(default=(), kw_only=True)

    def blocks(self) -> Iterator[Sequence[Frame]]:
        return iter((self.frames,))


def save_result(result: Result, name: str | Path, wait: bool = False) -> tuple[Path, ...]:
    """Write the files of a result; see `save_run`."""
    run = StoredRun(
        find_mode(result.mode), result.mechanism, Report(list(result.report)), dict(result.header),
        len(result.frames), result.nominal, frames=result.frames,
    )  # fmt: skip
    return save_run(run, name, wait)


def save_run(run: Run, name: str | Path, wait: bool = False) -> tuple[Path, ...]:
    """Write NAME.log and the result files of the mode, and return their paths, the log first.

    name   path; one of the endings .dat .log .sbd .sbm .ltv is left out;  wait   for another run that writes them

    Raises UsageError when they cannot be written, and what ended the run: the log says it, the frames up to there are
    kept in NAME.sbd.part.
    """
    stem = path_of(name)
    stem = stem.with_name(stem.stem) if stem.suffix.lower() in ENDINGS else stem
    if not stem.name:
        raise UsageError(f"'{name}' is no name of a result", "files.open")
    source = run.mechanism.deck
    with result_sinks(stem, run.mode.files, wait) as results:
        log = LogSink(stem.with_name(f"{stem.name}.log"), run.mode, source.path or Path(source.source))
        begin(results)
        outcome = run.consume(*results, log)
    if outcome.error is not None:
        raise outcome.error
    return (log.path, *(sink.path for sink in results))
