"""The log file of a run, written while the run goes on (reference/files.md section 2).

Opened before the input is read, so that it also explains wrong input; every line reaches the operating system at once,
so a process that is killed leaves all lines that were printed. It always has its final name.
"""

import os
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import spacar
from spacar.deck import echo
from spacar.errors import AnalysisError, InputError, SpacarError, UsageError
from spacar.frame import Frame
from spacar.modes import Mode
from spacar.stream import Run
from spacar_formats.log import linear_sections, model_sections, step_sections
from spacar_formats.log.model_sections import beam_sections
from spacar_formats.log.text_layout import heading, real, table
from spacar_formats.safety import backup_path

NOTICE = "Licensed under the Apache License, version 2.0; provided without warranty of any kind."

# Failures that docs/convergence.md explains, by the beginning of their codes.
EXPLAINED = ("position.", "statics.", "integrator.", "dynamics.singular-mass", "mechanism.count")
ADVICE = "Causes, and what to try, by message: `spacar help convergence`."


class LogSink:
    """Writes NAME.log. Raises UsageError when the file cannot be created.

    `options` are the command line's overrides of the deck, echoed at the top.
    """

    def __init__(self, path: Path, mode: Mode, source: Path, options: Mapping[str, Any] | None = None) -> None:
        self.path = path
        self._run: Run | None = None
        self._steps = step_sections.StepList()
        self._frames = 0
        self._last: Frame | None = None
        self._begun = time.perf_counter()
        if path.is_dir():
            raise UsageError(f"cannot write {path}: it is a folder", "files.open")
        try:
            if path.exists():
                os.replace(path, backup_path(path))
            self._file = open(path, "w", buffering=1, encoding="utf-8", errors="backslashreplace")  # noqa: SIM115 (open during the run)
        except OSError as error:
            raise UsageError(f"cannot write {path}: {error.strerror}", "files.open") from None
        lines = [f"spacar {spacar.__version__}   {time.strftime('%Y-%m-%d %H:%M:%S %z')}", NOTICE, ""]
        lines += [f"Mode {mode.number}: {mode.title}", f"Input file: {source}"]
        if options:
            lines += ["", "Options of the command line that replace settings of the input file", ""]
            lines += table(["option", "value"], options.items())
        self._write(lines)

    def start(self, run: Run) -> None:
        """Print the echo of the input, the messages about it, and the numbering."""
        self._run = run
        deck, n = run.mechanism.deck, run.mechanism.numbering
        lines = [f"SHA-256 of the input file: {deck.sha256}", *heading("Kinematics"), *echo(deck, 1), ""]
        if deck.messages:
            lines += ["Messages about the input", "", *(f"{m} [{m.code}]" for m in deck.messages), ""]
        lines += [*beam_sections(deck), *model_sections.elements(n), *model_sections.measures(run.mechanism)]
        self._write([*lines, *model_sections.nodes(n), *model_sections.degrees_of_freedom(n)])

    def frame(self, frame: Frame) -> None:
        """Print a line for the step, or all that is known of a stationary solution."""
        run = self._run
        assert run is not None
        n = run.mechanism.numbering
        timed = run.mode.timed
        self._frames += 1
        self._last = frame
        if self._frames == 1:
            self._write([*_condition(run), *_dynamics(run), *_settings(run)])
            self._write(heading("Initial state" if timed else "Solution" if run.mode.forces else "Configuration"))
            self._write(step_sections.state(n, frame, run.mode.forces, run.mechanism.deck.metre))
            if timed:
                found = linear_sections.matrices(n, frame) if frame.matrices or frame.state_space else []
                self._write([*found, *heading("Steps")])
        if timed:
            if run.mechanism.settings.log_level:
                self._write(step_sections.transfer_functions(run, frame))
            self._write([self._steps.line(frame)])
            return
        if self._frames > 1:
            title = f"Solution {self._frames}, load step {real(frame.t)}"
            self._write([*heading(title), *step_sections.state(n, frame, metre=run.mechanism.deck.metre)])
        rows = [[step_sections.COUNTERS.get(k, k.replace("_", " ")), float(v)] for k, v in frame.statistics.items()]
        self._write([*table(["of the solution", "value"], rows), ""] if rows else [])
        self._write(step_sections.transfer_functions(run, frame))
        self._write(linear_sections.eigenvalues(n, frame))
        self._write(linear_sections.buckling(n, frame))
        self._write(linear_sections.compliances(n, frame, run.mechanism.deck.metre))
        self._write(linear_sections.matrices(n, frame))

    def finish(self, error: BaseException | None) -> None:
        """Print the report of the run and how it ended, and close the file."""
        if self._file.closed:
            return
        with self._file:
            if self._run is not None and not self._frames:
                self._write([*_condition(self._run), *_dynamics(self._run)])
            if self._run is not None and self._run.report.lines:
                title = "Warnings and information" if self._run.mode.forces else "Diagnosis"
                self._write([*heading(title), *self._run.report.lines])
            self._write([*heading("End"), *self._ending(error)])

    def _ending(self, error: BaseException | None) -> list[str]:
        seconds = time.perf_counter() - self._begun
        stored = f"{self._frames} step{'s' * (self._frames != 1)} stored"
        if self._last is not None and self._run is not None and self._run.mode.timed:
            stored += f"; the last one at t = {real(self._last.t)} s"
        summary = f"{stored}; {seconds:.3f} s of wall time"
        if error is None:
            return ["The analysis is complete.", summary]
        kept = [f"{summary}; kept in the files {self.path.stem}.*.part"] if self._frames else []
        if isinstance(error, KeyboardInterrupt):
            return ["The analysis was interrupted by the user. [interrupted]", *kept]
        if isinstance(error, InputError):
            found = [f"{m} [{m.code}]" for m in error.messages]
            return [*found, "The input is wrong; nothing was analysed."]
        code = error.code if isinstance(error, SpacarError) else "internal"
        name = "" if isinstance(error, SpacarError) else f"{type(error).__name__}: "
        advice = [ADVICE] if code.startswith(EXPLAINED) else []
        return [f"error: {name}{error} [{code}]", "The analysis failed.", *advice, *kept]

    def _write(self, lines: Iterable[str]) -> None:
        text = "\n".join(lines)
        if not text:
            return
        try:
            self._file.write(text + "\n")
        except OSError as error:
            raise AnalysisError(f"cannot write {self.path}: {error.strerror}", "files.write") from None


def _condition(run: Run) -> list[str]:
    title = "Condition number of the part of the difference matrix that is inverted"
    return [f"{title}: {real(float(run.header['condition']))}", ""] if "condition" in run.header else []


def _dynamics(run: Run) -> list[str]:
    deck, n = run.mechanism.deck, run.mechanism.numbering
    lines = [*heading("Dynamics"), *echo(deck, 2), "", *model_sections.counts(n)]
    return [*lines, *model_sections.dynamics(run.mechanism)] if run.mode.forces else lines


def _settings(run: Run) -> list[str]:
    """How the analysis is done: third block, integrator or load steps, the nominal motion of mode 3."""
    mechanism, mode = run.mechanism, run.mode
    if not mode.forces:
        return []
    lines = heading(mode.title)
    third = echo(mechanism.deck, 3) if mode.third else []
    lines += [*third, "", *step_sections.definitions(mechanism)] if third else []
    if mode.integrated:
        lines += step_sections.integration(mechanism, run.header.get("engine"))
    elif "engine" in run.header:
        lines += [*step_sections.engine(run.header["engine"]), ""]
    if mode.stationary:
        lines += step_sections.iteration(mechanism)
    if run.nominal is not None:
        # called after its file, a result in memory after its input
        name = getattr(run.nominal, "name", None) or run.nominal.mechanism.deck.source
        lines += [f"Nominal motion: the mode {run.nominal.mode} result {name}", ""]
    return lines
