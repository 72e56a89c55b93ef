"""`spacar MODE FILE`: one analysis, its log and its result files."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import click
from spacar_formats.log import LogSink
from spacar_formats.sinks import ResultSink, Sink, result_sinks

from spacar.errors import SpacarError, UsageError
from spacar.modes import Mode, Run, find_mode, frames
from spacar.options import integrator
from spacar_cli.environment import Environment
from spacar_cli.progress import Progress
from spacar_cli.source import input_file, result_stem
from spacar_cli.status import ExitStatus, tell, tell_error, tell_messages

POSITIVE = click.FloatRange(min=0.0, min_open=True)
INTEGRATED, LINEARIZED = (1, 4), (3,)

# Options that replace a number of the input file: flag, field of Settings, type, help, modes that have it.
OVERRIDES: tuple[tuple[str, str, Any, str, tuple[int, ...]], ...] = (
    ("--atol", "atol", POSITIVE, "Absolute error tolerance, instead of ERROR.", INTEGRATED),
    ("--rtol", "rtol", POSITIVE, "Relative error tolerance, instead of ERROR.", INTEGRATED),
    ("--integrator", "integrator", int, "Integration method, instead of INTEGRAT.", INTEGRATED),
    ("--steps", "n_steps", click.IntRange(min=1), "Number of output steps, instead of TIMESTEP.", INTEGRATED),
    ("--compiled", "compiled", bool, "Right-hand side in C: faster, needs a C compiler.", INTEGRATED),
    ("--time", "duration", POSITIVE, "Length of the time interval, instead of TIMESTEP [s].", INTEGRATED),
)


@dataclass
class Outcome:
    """What a run did, for the summary and for --json."""

    steps: int = 0
    last: float | None = None
    seconds: float = 0.0
    error: BaseException | None = None


def command_of_mode(word: str) -> click.Command:
    """The command for a word such as `1` or `-7`, with the options that this mode has. Raises UsageError."""
    mode = find_mode(int(word))
    params: list[click.Parameter] = [click.Argument(["file"], type=click.Path(path_type=Path))]
    params.append(
        click.Option(
            ["--output-dir", "-o"],
            type=click.Path(path_type=Path),
            help="Folder for the log and the results.",
        )
    )
    for flag, field, kind, text, modes in OVERRIDES:
        if mode.number in modes:
            switch = {"is_flag": True, "flag_value": True, "default": None} if kind is bool else {"type": kind}
            params.append(click.Option([flag, field], help=text, **switch))
    if mode.number in LINEARIZED:
        params.append(
            click.Option(["--setpoints"], help="Result of mode 2 to linearize along, instead of the search by name.")
        )
    if not word.startswith("-"):
        params.append(click.Option(["--plot"], is_flag=True, help="Show the mechanism in a window while it runs."))
    params += [
        click.Option(["--quiet", "-q"], is_flag=True, help="Print errors only."),
        click.Option(["--verbose", "-v"], is_flag=True, help="Print warnings, information and a summary."),
        click.Option(["--json", "as_json"], is_flag=True, help="Print a summary in JSON."),
    ]
    short = f"Mode {mode.number}: {mode.title}. Writes FILE.log and " + ", ".join(f"FILE.{k}" for k in mode.files) + "."
    return click.Command(word, params=params, callback=click.pass_obj(partial(run_mode, mode)), help=short)


def run_mode(
    mode: Mode,
    environment: Environment,
    *,
    file: Path,
    output_dir: Path | None,
    quiet: bool,
    verbose: bool,
    as_json: bool,
    setpoints: str | None = None,
    plot: bool = False,
    **options: Any,
) -> ExitStatus:
    """Run the analysis and report. Errors before the log exists are raised, others are told and logged."""
    source = input_file(file)
    overrides = {field: value for field, value in options.items() if value is not None}
    if "integrator" in overrides:
        integrator(overrides["integrator"], "--integrator")
    stem = result_stem(source, output_dir)
    log = LogSink(stem.with_name(f"{stem.name}.log"), mode, source, _flags(overrides, setpoints))
    outcome = Outcome()
    results: list[ResultSink] = []
    run: Run | None = None
    try:
        results = result_sinks(stem, mode.files)
        run = frames(mode.number, source, **overrides)
        if mode.number in LINEARIZED:
            _set_nominal(run, source, setpoints)
        _check_timestep(run)
        if not quiet:
            tell_messages(environment, run.mechanism.deck.messages, ("warning", "information")[: 1 + verbose])
        show: list[Sink] = [] if quiet else [Progress(environment)]
        if plot:
            from spacar_cli.drawing.window import LivePlot

            show.append(LivePlot())
        outcome = consume(run, [*show, *results, log])
    except (Exception, KeyboardInterrupt) as error:  # before the first step
        log.finish(error)
        outcome.error = error
    if run is not None and not quiet:
        for line in run.report.lines:
            if line.startswith("warning: "):
                tell(environment, "warning", line.removeprefix("warning: "))
    status = _status(environment, outcome, results)
    if as_json:
        environment.say(_as_json(mode, source, outcome, status, log, results, run))
    elif not quiet and run is not None and (verbose or environment.output_is_terminal or _ill_defined(run)):
        if verbose or mode.number == 0:
            for line in run.report.lines:
                environment.say(line)
        if status == ExitStatus.DONE:
            names = " ".join(str(p) for p in (log.path, *(s.path for s in results)))
            steps = f"{outcome.steps} step{'s' * (outcome.steps != 1)}"
            environment.say(f"{source.name}: {mode.title}, {steps} in {outcome.seconds:.2f} s: {names}")
    return status


def _ill_defined(run: Run) -> bool:
    """Did mode 0 find over- or under-constraints? They are told even where no terminal is."""
    diagnosis = run.header.get("diagnosis")
    return diagnosis is not None and bool(diagnosis.over or diagnosis.under)


def consume(run: Run, sinks: Sequence[Sink]) -> Outcome:
    """Hand every frame to every sink; however the run ends, finish the sinks with what ended it.

    They are finished in their order: the log is the last one, so that it also tells of a result that could not
    be completed.
    """
    outcome = Outcome()
    begun = time.perf_counter()
    try:
        for sink in sinks:
            sink.start(run)
        for frame in run:
            for sink in sinks:
                sink.frame(frame)
            outcome.steps += 1
            outcome.last = frame.t
    except (Exception, KeyboardInterrupt) as error:
        outcome.error = error
    for sink in sinks:
        try:
            sink.finish(outcome.error)
        except (SpacarError, OSError) as error:
            outcome.error = outcome.error or error
    outcome.seconds = time.perf_counter() - begun
    return outcome


def _flags(overrides: dict[str, Any], setpoints: str | None) -> dict[str, Any]:
    """The given options under their names on the command line, for the log."""
    given = {flag: overrides[field] for flag, field, *_ in OVERRIDES if field in overrides}
    return given | ({"--setpoints": setpoints} if setpoints else {})


def _check_timestep(run: Run) -> None:
    """A duration without a number of steps, or the reverse, is no TIMESTEP."""
    s = run.mechanism.settings
    if s.duration is not None and s.n_steps < 1:
        raise UsageError("--time needs --steps, because the input file has no TIMESTEP", "usage.timestep")
    if s.duration is None and s.n_steps > 0:
        raise UsageError("--steps needs --time, because the input file has no TIMESTEP", "usage.timestep")


def _set_nominal(run: Run, source: Path, setpoints: str | None) -> None:
    """Give the run the motion along which it linearizes."""
    from spacar_formats.setpoints import check_same_model, find_setpoints

    run.nominal = find_setpoints(source, setpoints)
    check_same_model(run.nominal, run.mechanism.numbering)


def _status(environment: Environment, outcome: Outcome, results: list[ResultSink]) -> ExitStatus:
    """Explain how the run ended when it did not end well."""
    error = outcome.error
    if error is None:
        return ExitStatus.DONE
    kept = " ".join(str(s.written_to) for s in results if s.written_to is not None)
    if isinstance(error, KeyboardInterrupt):
        at = f" after {outcome.steps} steps at t = {outcome.last:.10g}" if outcome.last is not None else ""
        kept = f"; results so far are kept in {kept}" if kept else ""
        tell(environment, "error", f"interrupted{at}{kept}")
        return ExitStatus.INTERRUPTED
    if not isinstance(error, (SpacarError, OSError, MemoryError)) and environment.debug:
        raise error
    return tell_error(environment, error)


def _as_json(
    mode: Mode,
    source: Path,
    outcome: Outcome,
    status: ExitStatus,
    log: LogSink,
    results: list[ResultSink],
    run: Run | None,
) -> str:
    import json

    report: dict[str, Any] = {
        "mode": mode.number,
        "analysis": mode.title,
        "input": str(source),
        "status": int(status),
        "steps": outcome.steps,
        "t": outcome.last,
        "seconds": outcome.seconds,
        "log": str(log.path),
        "results": [str(s.written_to) for s in results if s.written_to is not None],
    }
    if run is not None:
        n = run.mechanism.numbering
        report |= {"ndof": n.ndof, "nddof": n.nddof, "nx": n.nx, "ne": n.ne, "information": run.report.lines}
        report["messages"] = [str(m) for m in run.mechanism.deck.messages]
    if outcome.error is not None:
        interrupted = isinstance(outcome.error, KeyboardInterrupt)
        report["error"] = str(outcome.error) or type(outcome.error).__name__
        report["code"] = "interrupted" if interrupted else getattr(outcome.error, "code", "internal")
    return json.dumps(report)
