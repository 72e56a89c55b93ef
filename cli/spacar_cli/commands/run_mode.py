"""`spacar MODE FILE`: one analysis, its log and its result files."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from spacar_formats.disk_room import require_room
from spacar_formats.log import LogSink
from spacar_formats.result_files import ResultSink, begin, result_sinks

from spacar.calls import BEAMS, check_modes, frames, integrator
from spacar.errors import InputError, SpacarError, UsageError
from spacar.modes import Mode, find_mode
from spacar.stream import Outcome, Run
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, ExitStatus, tell, tell_error, tell_messages, tell_notes
from spacar_cli.input_files import PIPED, STANDARD_INPUT, input_file, parse_piped, piped_text, result_stem
from spacar_cli.progress import Progress
from spacar_cli.vocabulary import TOLERANCE, Whole

if TYPE_CHECKING:
    from spacar_drawing.window import LivePlot

    from spacar_cli import releasing

WARNING = "warning: "
# Options of integrated modes that replace a number of the input file, and what.
OVERRIDES = {
    "atol": "ERROR", "rtol": "ERROR", "integrator": "INTEGRAT", "n_steps": "TIMESTEP", "compiled": "",
    "duration": "TIMESTEP",
}  # fmt: skip
FLAGS = ("beams", "elements", "rigid_beams", "modes")
MEASURE = ""  # the value of --accuracy without a target


def command_of_mode(word: str) -> click.Command:
    """The command for a word such as `1` or `-7`, with the options that this mode has. Raises UsageError."""
    mode = find_mode(int(word))
    accurate = mode.integrated or mode.stationary
    needed = mode.forces and not accurate  # else the word may have gone to an option
    params = [
        click.Argument(["file"], type=click.Path(path_type=Path), required=needed),
        words.parameter("output_dir", ": the log and the results"),
        words.parameter(
            "beams", ": angle is of fourth order in the element length, sine of second.", type=click.Choice(BEAMS)
        ),
        words.parameter("elements", " that can be divided; results are those of the divided model."),
        words.parameter("rigid_beams", " (DYNE)."),
    ]
    for name, keyword in OVERRIDES.items():
        if mode.integrated or (mode.forces and not keyword):
            params.append(words.parameter(name, f", instead of {keyword}" if keyword else "", default=None))
    if accurate:
        runs = "choose method, tolerance and mesh" if mode.integrated else "choose the mesh of the beams"
        text = f": several runs {runs}, estimate the error and keep it below TARGET; without it that of this run is "
        params.append(words.parameter("accuracy", f"{text}estimated.", is_flag=False, flag_value=MEASURE, type=str))
        all_of = ", reactions, lowest frequencies and load multipliers" if mode.stationary else ""
        text = f": 'x[6,1]'. Default: all free coordinates{all_of}."
        params.append(words.parameter("variables", text, multiple=True))
    if mode.integrated:
        params.append(words.parameter("fixed_mesh"))
    if mode.stationary or mode.third == "linearization" or mode.takes_setpoints:
        text = ", instead of MODES; 0: all of them, with the reduced matrices."
        if mode.third:
            text = ", of a large model (instead of MODES); 0: A, B, C, D and reduced matrices of any size."
        if mode.takes_setpoints:
            text = "; 0: A, B, C, D and reduced matrices of a model of any size."
        params.append(words.parameter("modes", text, type=Whole(min=0)))
    if mode.takes_setpoints:
        params.append(words.parameter("setpoints", type=str))
    if not mode.forces:
        text = (
            "They are RLSE of flexible deformations, which keep the physics, and are printed; with a name the input "
            "file with these lines is written to OUTPUT."
        )
        params.append(words.parameter("release", text, is_flag=False, flag_value="", type=str))
    if not word.startswith("-"):
        params.append(words.parameter("show", ": the mechanism while it runs"))
    params += [words.parameter("regardless"), words.parameter("wait"), words.parameter("as_json", ": a summary")]
    short = f"Mode {mode.number}: {mode.title}. Writes FILE.log and " + ", ".join(f"FILE.{k}" for k in mode.files) + "."
    short += " FILE - is standard input, its results are stdin.* in the current folder."
    return words.Command(word, params=params, callback=click.pass_obj(partial(run_mode, mode)), help=short)


def _accuracy_asked(file: Path | None, options: dict[str, Any]) -> tuple[Path | None, dict[str, Any]]:
    """The input file, and the arguments of `spacar.frames` for the accuracy, which are taken out of `options`.

    In `spacar 1 --accuracy FILE` the word is the file. Raises UsageError for a target that is no number.
    """
    word, variables = options.pop("accuracy", None), tuple(options.pop("variables", ()))
    fixed = options.pop("fixed_mesh", False)
    if word is None:
        for given, text in ((variables, "--variable says whose"), (fixed, "--fixed-mesh says whose")):
            if given:
                raise UsageError(f"{text} --accuracy is meant; give --accuracy too", "usage.accuracy")
        return file, {}
    asked = {"variables": variables} | ({"mesh": False} if fixed else {})
    if file is None and word != MEASURE:
        file, word = Path(word), MEASURE
    if word == MEASURE:
        return file, asked | {"accuracy": True}
    try:
        target = TOLERANCE.convert(word, None, None)
    except click.UsageError as error:
        raise UsageError(f"--accuracy: {error.message}", "usage.accuracy") from None
    return file, asked | {"accuracy": target}


def run_mode(
    mode: Mode, environment: Environment, *, file: Path | None, output_dir: Path | None, as_json: bool,
    wait: bool = False, regardless: bool = False, setpoints: str | None = None, show: bool = False,
    release: str | None = None, **options: Any,
) -> ExitStatus:  # fmt: skip
    """Run the analysis and report. Errors before the log exists are raised, others are told and logged."""
    file, asked = _accuracy_asked(file, options)
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
    if not overrides.get("rigid_beams", True):  # a flag that was not given
        del overrides["rigid_beams"]
    if "integrator" in overrides:
        integrator(overrides["integrator"], "--integrator")
    check_modes(mode, overrides.get("modes"))
    stem = result_stem(source, output_dir)
    outcome = Outcome()
    run: Run | None = None
    window: LivePlot | None = None
    with result_sinks(stem, mode.files, wait) as results:
        log = LogSink(
            stem.with_name(f"{stem.name}.log"), mode, Path("standard input") if piped else source,
            _flags(overrides, asked, setpoints),
        )  # fmt: skip
        try:
            try:
                run = frames(mode.number, model, **overrides, **asked)
            except InputError:
                begin(results)  # an earlier result is none of this input
                raise
            if mode.takes_setpoints:
                run = _along(run, source, setpoints)
            _check_timestep(run)
            if not regardless:
                require_room(run, stem.parent)
            begin(results)  # not before: an earlier result may be the one to linearize along
            severities = ("warning", "information")[: 1 + environment.verbose]
            tell_messages(environment, run.mechanism.deck.messages, severities)
            if show:
                from spacar_drawing.window import LivePlot

                window = LivePlot()
            outcome = run.consume(Progress(environment), *results, log, window=window)
        except (Exception, KeyboardInterrupt) as error:  # before the first step
            log.finish(error)
            outcome.error = error
    told = [] if run is None else run.report.lines
    tell_notes(environment, (line.removeprefix(WARNING) for line in told if line.startswith(WARNING)))
    told = [line for line in told if not line.startswith(WARNING)]
    status = _status(environment, outcome, results)
    done: releasing.Done | None = None
    if release is not None and run is not None and status == ExitStatus.DONE:
        from spacar_cli import releasing

        done = releasing.solve(source, release)
        status = done.status
    # mode 0 tells of over- and under-constraints even where no terminal is
    diagnosis = None if run is None else run.header.get("diagnosis")
    ill_defined = diagnosis is not None and bool(diagnosis.over or diagnosis.under)
    if as_json:
        environment.say_json(_record(mode, source, outcome, status, log, results, run, done))
    elif run is not None and (environment.verbose or environment.output_is_terminal or ill_defined):
        if environment.verbose or not mode.forces:
            environment.wrote(*told)
        if outcome.error is None:
            names = " ".join(str(p) for p in (log.path, *(s.path for s in results)))
            steps = f"{outcome.steps} step{'s' * (outcome.steps != 1)}"
            environment.wrote(f"{source.name}: {mode.title}, {steps} in {outcome.seconds:.2f} s: {names}")
    if done is not None and not as_json:
        done.tell(environment)
    if window is not None:
        window.wait()
    return status


def _flags(overrides: dict[str, Any], asked: dict[str, Any], setpoints: str | None) -> dict[str, Any]:
    """The given options under their names on the command line, for the log."""
    given: dict[str, Any] = {}
    for name in (*OVERRIDES, *FLAGS):
        if name in overrides:
            yes, _, no = words.VOCABULARY[name].spelled.partition("/")
            given[yes if overrides[name] or not no else no] = True if no else overrides[name]
    target = asked.get("accuracy")
    more = {
        "--accuracy": "measured" if target is True else target, "--variable": ", ".join(asked.get("variables", ())),
        "--fixed-mesh": "mesh" in asked, "--setpoints": setpoints,
    }  # fmt: skip
    return given | {name: value for name, value in more.items() if value}


def _check_timestep(run: Run) -> None:
    """A duration without a number of steps, or the reverse, is no TIMESTEP."""
    s = run.mechanism.settings
    if (s.duration is None) != (s.n_steps < 1):
        text = "--time needs --steps" if s.n_steps < 1 else "--steps needs --time"
        raise UsageError(f"{text}, because the input file has no TIMESTEP", "usage.timestep")


def _along(run: Run, source: Path, setpoints: str | None) -> Run:
    """The run with the motion along which it linearizes."""
    from spacar_formats.setpoint_files import find_setpoints

    from spacar.inverse.nominal import check_same_mechanism

    nominal = find_setpoints(source, setpoints)
    check_same_mechanism(nominal, run.mechanism.numbering)
    return replace(run, nominal=nominal)


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


def _record(
    mode: Mode, source: Path, outcome: Outcome, status: ExitStatus, log: LogSink, results: list[ResultSink],
    run: Run | None, done: releasing.Done | None,
) -> dict[str, Any]:  # fmt: skip
    report: dict[str, Any] = {
        "mode": mode.number, "analysis": mode.title, "input": str(source), "status": int(status),
        "steps": outcome.steps, "t": outcome.last, "seconds": outcome.seconds, "log": str(log.path),
        "results": [str(s.written_to) for s in results if s.written_to is not None],
    }  # fmt: skip
    if run is not None:
        n, header = run.mechanism.numbering, run.header
        report |= {"ndof": n.ndof, "nddof": n.nddof, "nx": n.nx, "ne": n.ne, "information": run.report.lines}
        report["messages"] = [str(m) for m in run.mechanism.deck.messages]
        if "engine" in header:
            report["engine"], report["engine_note"] = header["engine"]
        if "integrator" in header:
            report["integrator"], report["integrator_note"] = run.mechanism.settings.integrator, header["integrator"]
        if "accuracy" in header:
            report["accuracy"] = header["accuracy"].record()
        if (diagnosis := header.get("diagnosis")) is not None:
            from spacar_cli import releasing

            report["constraints"] = releasing.as_record(diagnosis)
    if done is not None:
        report["release"] = done.record()
    if outcome.error is not None:
        interrupted = isinstance(outcome.error, KeyboardInterrupt)
        report["error"] = str(outcome.error) or type(outcome.error).__name__
        report["code"] = "interrupted" if interrupted else getattr(outcome.error, "code", "internal")
    return report
