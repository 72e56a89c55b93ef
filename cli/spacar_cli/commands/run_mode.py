"""`spacar MODE FILE`: one analysis, its log and its result files."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from spacar_formats.log import LogSink
from spacar_formats.sinks import ResultSink, begin, give_up, result_sinks

from spacar.calls import frames
from spacar.errors import SpacarError, UsageError
from spacar.modes import Mode, find_mode
from spacar.options import BEAMS, check_modes, integrator
from spacar.stream import Outcome, Run, Sink
from spacar_cli import accuracy_options
from spacar_cli.environment import Environment
from spacar_cli.input_files import PIPED, STANDARD_INPUT, input_file, parse_piped, piped_text, result_stem
from spacar_cli.number_types import POSITIVE, TOLERANCE, Whole
from spacar_cli.progress import Progress
from spacar_cli.status import ExitStatus, tell, tell_error, tell_messages

if TYPE_CHECKING:
    from spacar_drawing.window import LivePlot

    from spacar_cli import releasing

ENGINE = ("--compiled/--general", "compiled", bool, "Equations in C (default where that is possible) or in NumPy.")
# Options of integrated modes that replace a number of the input file: flag, field of Settings, type, help.
OVERRIDES: tuple[tuple[str, str, Any, str], ...] = (
    ("--atol", "atol", POSITIVE, "Absolute error tolerance, instead of ERROR."),
    ("--rtol", "rtol", TOLERANCE, "Relative error tolerance, instead of ERROR."),
    ("--integrator", "integrator", Whole(), "Integration method, instead of INTEGRAT."),
    ("--steps", "n_steps", Whole(min=1), "Number of output steps, instead of TIMESTEP."),
    ENGINE,
    ("--time", "duration", POSITIVE, "Length of the time interval, instead of TIMESTEP [s]."),
)


def command_of_mode(word: str) -> click.Command:
    """The command for a word such as `1` or `-7`, with the options that this mode has. Raises UsageError."""
    mode = find_mode(int(word))
    releases = not mode.forces
    needed = not (releases or accuracy_options.of(mode))  # there the word may have gone to an option
    params: list[click.Parameter] = [click.Argument(["file"], type=click.Path(path_type=Path), required=needed)]
    params.append(
        click.Option(
            ["--output-dir", "-o"],
            type=click.Path(path_type=Path),
            help="Folder for the log and the results.",
        )
    )
    text = (
        "Measure of the deformations of all beams and tubes, instead of ADEFORM: angle is of fourth order in the "
        "element length, sine of second."
    )
    params.append(click.Option(["--beams"], type=click.Choice(BEAMS), help=text))
    text = "Equal beams in the place of each flexible beam that can be divided; results are those of the divided model."
    params.append(click.Option(["--elements"], type=Whole(min=1), help=text))
    for flag, field, kind, text in OVERRIDES if mode.integrated else (ENGINE,) if mode.forces else ():
        switch = {"is_flag": True, "default": None} if kind is bool else {"type": kind}
        params.append(click.Option([flag, field], help=text, **switch))
    if accuracy_options.of(mode):
        params += accuracy_options.options(mode)
    if mode.stationary or mode.third == "linearization" or mode.takes_setpoints:
        text = "Number of lowest modes, instead of MODES; 0: all of them, with the reduced matrices."
        if mode.third:
            text = "Lowest modes of a large model (instead of MODES); 0: A, B, C, D and reduced matrices of any size."
        if mode.takes_setpoints:
            text = "0: A, B, C, D and reduced matrices of a model of any size."
        params.append(click.Option(["--modes"], type=Whole(min=0), help=text))
    if mode.takes_setpoints:
        params.append(
            click.Option(["--setpoints"], help="Result of mode 2 to linearize along, instead of the search by name.")
        )
    if releases:
        text = (
            "Solve over-constraints by RLSE of flexible deformations, which keeps the physics, and print the lines; "
            "with a name write the input file with these lines to OUTPUT."
        )
        params.append(click.Option(["--release"], is_flag=False, flag_value="", metavar="[OUTPUT]", help=text))
    if not word.startswith("-"):
        params.append(click.Option(["--plot"], is_flag=True, help="Show the mechanism in a window while it runs."))
    params += [
        click.Option(["--wait"], is_flag=True, help="Wait when another run is writing the same results."),
        click.Option(["--quiet", "-q"], is_flag=True, help="Print errors only."),
        click.Option(["--verbose", "-v"], is_flag=True, help="Print warnings, information and a summary."),
        click.Option(["--json", "as_json"], is_flag=True, help="Print a summary in JSON."),
    ]
    short = f"Mode {mode.number}: {mode.title}. Writes FILE.log and " + ", ".join(f"FILE.{k}" for k in mode.files) + "."
    short += " FILE - is standard input, its results are stdin.* in the current folder."
    return click.Command(word, params=params, callback=click.pass_obj(partial(run_mode, mode)), help=short)


def run_mode(
    mode: Mode,
    environment: Environment,
    *,
    file: Path | None,
    output_dir: Path | None,
    quiet: bool,
    verbose: bool,
    as_json: bool,
    wait: bool = False,
    setpoints: str | None = None,
    plot: bool = False,
    release: str | None = None,
    **options: Any,
) -> ExitStatus:
    """Run the analysis and report. Errors before the log exists are raised, others are told and logged."""
    file, asked = accuracy_options.taken(file, options)
    if file is None:  # `spacar 0 --release FILE`: the word belongs to the argument
        if not release:
            raise UsageError("Missing argument 'FILE'.", "usage")
        file, release = Path(release), ""
    piped = str(file) == STANDARD_INPUT
    if piped and release is not None:
        raise UsageError("--release needs an input file, not standard input", "usage")
    source = PIPED if piped else input_file(file)
    model = parse_piped(piped_text(environment), mode.number) if piped else source
    if release:
        from spacar_cli import releasing

        releasing.check_output(Path(release), source)
    overrides = {field: value for field, value in options.items() if value is not None}
    if "integrator" in overrides:
        integrator(overrides["integrator"], "--integrator")
    check_modes(mode, overrides.get("modes"))
    stem = result_stem(source, output_dir)
    results = result_sinks(stem, mode.files, wait)
    try:
        log = LogSink(
            stem.with_name(f"{stem.name}.log"),
            mode,
            Path("standard input") if piped else source,
            _flags(overrides, setpoints) | accuracy_options.flags(asked),
        )
    except BaseException:
        give_up(results)
        raise
    outcome = Outcome()
    run: Run | None = None
    window: LivePlot | None = None
    try:
        begin(results)
        run = frames(mode.number, model, **overrides, **asked)
        if mode.takes_setpoints:
            _set_nominal(run, source, setpoints)
        _check_timestep(run)
        if not quiet:
            tell_messages(environment, run.mechanism.deck.messages, ("warning", "information")[: 1 + verbose])
        show: list[Sink] = [] if quiet else [Progress(environment)]
        if plot:
            from spacar_drawing.window import LivePlot

            window = LivePlot()
        outcome = run.consume(*show, *results, log, window=window)
    except (Exception, KeyboardInterrupt) as error:  # before the first step
        log.finish(error)
        outcome.error = error
    finally:
        give_up(results)
    if run is not None and not quiet:
        for line in run.report.lines:
            if line.startswith("warning: "):
                tell(environment, "warning", line.removeprefix("warning: "))
    status = _status(environment, outcome, results)
    done: releasing.Done | None = None
    if release is not None and run is not None and status == ExitStatus.DONE:
        from spacar_cli import releasing

        done = releasing.solve(source, release)
        status = done.status
    if as_json:
        environment.say(_as_json(mode, source, outcome, status, log, results, run, done))
    elif not quiet and run is not None and (verbose or environment.output_is_terminal or _ill_defined(run)):
        if verbose or not mode.forces:
            for line in run.report.lines:
                environment.say(line)
        if outcome.error is None:
            names = " ".join(str(p) for p in (log.path, *(s.path for s in results)))
            steps = f"{outcome.steps} step{'s' * (outcome.steps != 1)}"
            environment.say(f"{source.name}: {mode.title}, {steps} in {outcome.seconds:.2f} s: {names}")
    if done is not None and not as_json:
        done.tell(environment, quiet)
    if window is not None:
        window.wait()
    return status


def _ill_defined(run: Run) -> bool:
    """Did mode 0 find over- or under-constraints? They are told even where no terminal is."""
    diagnosis = run.header.get("diagnosis")
    return diagnosis is not None and bool(diagnosis.over or diagnosis.under)


def _flags(overrides: dict[str, Any], setpoints: str | None) -> dict[str, Any]:
    """The given options under their names on the command line, for the log."""
    given: dict[str, Any] = {}
    for flag, field, kind, _ in OVERRIDES:
        if field in overrides:
            yes, _, no = flag.partition("/")
            given[no if kind is bool and not overrides[field] else yes] = True if kind is bool else overrides[field]
    given |= {f"--{name}": overrides[name] for name in ("beams", "elements", "modes") if name in overrides}
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
    from spacar_formats.setpoint_files import check_same_model, find_setpoints

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
    done: releasing.Done | None = None,
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
        if "engine" in run.header:
            report["engine"], report["engine_note"] = run.header["engine"]
        if "integrator" in run.header:
            report["integrator"] = run.mechanism.settings.integrator
            report["integrator_note"] = run.header["integrator"]
        if "accuracy" in run.header:
            report["accuracy"] = run.header["accuracy"].record()
        diagnosis = run.header.get("diagnosis")
        if diagnosis is not None:
            from spacar_cli import releasing

            report["constraints"] = releasing.as_record(diagnosis)
    if done is not None:
        report["release"] = done.record()
    if outcome.error is not None:
        interrupted = isinstance(outcome.error, KeyboardInterrupt)
        report["error"] = str(outcome.error) or type(outcome.error).__name__
        report["code"] = "interrupted" if interrupted else getattr(outcome.error, "code", "internal")
    return json.dumps(report)
