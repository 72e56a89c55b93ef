"""`spacar trade FILE`: what accuracy costs, and the cheapest setting for the accuracy that is wanted."""

import json
import math
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, ExitStatus, tell
from spacar_cli.input_files import input_file
from spacar_cli.row_output import ROWS, counted, csv_text, finite, of_studies, say_table

TABLES, DIAGRAMS = (".csv", ".json"), (".png", ".svg", ".pdf")
CODES, TOLERANCES, JUDGES = "0,155,853", "1e-3:1e-9:7:log", "853,0"  # where only some of the lists are given
STOPPED = "stopped"  # how the reason of a run begins that a cheaper one has ended
HEADER = ("model", "integration", "error", "processor time [s]", "right-hand sides", "note")


@words.command("trade", epilog="The error norm and the reference: `spacar help studies`.")
@words.option("mode", ": 1, 7, 8, 9 or 10. Default: 1 with TIMESTEP, else 7.")
@words.option("integrators", "Default: those that suit the model, within --budget.")
@words.option("tolerances", "Default: as far as --target needs, within --budget.")
@words.option("grids", ", of methods with fixed step", default="1,4,16,64")
@words.option("meshes", "Default: one.")
@words.option("rigid")
@words.option("linear")
@words.option("perturbation")
@words.option("variables", ", as in `spacar sweep`: 'x[6,1]'. Default: all free coordinates.", multiple=True)
@words.option("target", default=1e-6)
@words.option("repeats", default=3)
@words.option("judges", "Default: 853,0; without lists, what suits the model.")
@words.option("budget", ", when no settings are given as lists (-i, -t, --reference ...).", default=60.0)
@words.option("compiled", default=None)
@words.option(
    "output", ": the table as .csv or .json, of which what is finished is kept in FILE.rows.jsonl and not run again; "
    "the work-precision diagram as .png, .svg or .pdf. May be repeated.", type=ROWS, multiple=True,
)  # fmt: skip
@of_studies
def command(
    environment: Environment, file: Path, mode: int | None, integrators: str | None, tolerances: str | None,
    grids: str, meshes: str | None, budget: float, rigid: bool, linear: bool, perturbation: bool,
    variables: tuple[str, ...], target: float, repeats: int, judges: str | None, compiled: bool | None,
    output: tuple[Path, ...], jobs: int | None, as_json: bool, duration: float | None, n_steps: int | None,
) -> ExitStatus:  # fmt: skip
    """Run FILE with many settings, compare with a reference, and recommend the cheapest setting for --target.

    The reference and its error come from two methods at a tight tolerance and, where meshes are compared, from
    extrapolation over three meshes. With --jobs the runs share the processor, which disturbs the times.
    """
    from spacar.studies.policies.trade import assess, recommend, reference, reference_setups
    from spacar.studies.runs.setting import setups
    from spacar.studies.study_calls import trade_of

    for path in output:
        if path.suffix.lower() not in (*TABLES, *DIAGRAMS):
            raise UsageError(f"{path}: its name must end with {', '.join((*TABLES, *DIAGRAMS))}", "usage.trade")
    source = input_file(file)
    options = {"duration": duration, "n_steps": n_steps, "compiled": compiled}
    options = {name: value for name, value in options.items() if value is not None}
    trade = trade_of(source, mode, variables, repeats, options)
    lists = (integrators, tolerances, meshes, judges)
    if all(v is None for v in lists) and not (rigid or linear or perturbation) and jobs in (None, 1):
        found = _within_budget(environment, trade, target, budget, source)
        return _told(environment, trade, source.name, output, as_json, target, *found)
    integrators, tolerances = integrators or CODES, tolerances or TOLERANCES
    divided = _whole(meshes or "1", "--elements")
    cases = setups(
        trade, _whole(integrators, "--integrators"), _numbers(tolerances), _whole(grids, "--substeps"), divided, rigid,
        linear, perturbation,
    )  # fmt: skip
    judging = _whole(judges or JUDGES, "--reference")
    against = reference_setups(trade, divided, min(target, *_numbers(tolerances)), judging)
    table_file = next((path for path in output if path.suffix.lower() in TABLES), None)
    rows = _rows(environment, trade, list(dict.fromkeys([*against, *cases])), table_file, jobs or 1)
    ref = reference(trade, rows, against)
    entries = assess(trade, rows, cases, ref)
    best = recommend(entries, target, ref)
    return _told(environment, trade, source.name, output, as_json, target, target, ref, entries, best)


def _within_budget(environment: Environment, trade: Any, target: float, budget: float, source: Path) -> tuple[Any, ...]:
    """The settings that suit the model, cheapest first, until the time is used; the recommendation as a command.

    Gives what `_told` tells: goal, reference, entries, the best one, lines and parts of the document.
    """
    from spacar.studies.policies.simplification import cheapest, command_line, run_options, simpler_deck

    def tick(what: str, left: float) -> None:
        environment.progress(f"{what}, at most {left:.0f} s to go ")

    try:
        found, prices = cheapest(trade, target, budget, tick)
    finally:
        environment.progress("")
    best, name, command = found.best, source.name, ""
    simpler = simpler_deck(trade, best)
    if simpler is not None:
        name = _written(source, simpler.text)
    if best is not None and best.setup is not None:
        command = command_line(trade.mode, run_options(trade, best.setup), name)
    skipped = f"{found.skipped} settings were not tried: the budget of {budget:g} s is used (--budget)"
    undivided = {str(beam): why for beam, why in found.undivided.items()}
    unknown = "the error of the mesh of beam {} is not known: it cannot be divided: {}"
    lines = [
        *[skipped] * bool(found.skipped), *(unknown.format(*one) for one in undivided.items()),
        *(price.line(found.goal) for price in prices), *[command] * bool(command),
    ]  # fmt: skip
    more = {
        "command": command or None, "reached": found.goal, "undivided": undivided,
        "prices": finite([vars(p) for p in prices]),
    }  # fmt: skip
    return found.goal, found.reference, found.entries, best, lines, more


def _told(
    environment: Environment, trade: Any, name: str, output: tuple[Path, ...], as_json: bool, target: float,
    goal: float, ref: Any, entries: Any, best: Any, lines: Sequence[str] = (), more: Mapping[str, Any] = {},
) -> ExitStatus:  # fmt: skip
    """Write the files, print the table and the recommendation with further lines, or the document with more in it.

    goal   the error for which the answer is given, `target` where that is reached
    """
    document = _document(entries, ref, target, best)
    for path in output:
        if path.suffix.lower() in TABLES:
            _write(path, document)
        else:
            from spacar_drawing.files import save
            from spacar_drawing.study_figures import work_precision_figure

            title = f"{name}, mode {trade.mode}"
            save(work_precision_figure(entries, ref.error, target, trade.stationary, title), path, dpi=120.0)
    if as_json:
        environment.say_json(document | dict(more))
    elif not environment.quiet:
        say_table(environment, HEADER, [_cells(e) for e in entries], None if best is None else entries.index(best))
        environment.say(f"reference: {ref.text}; its estimated error is {ref.error:.2e}")
        if goal > target:
            environment.say(f"{target:.3g} is not reached: within its time the reference has that error only")
        if best is not None and best.error + ref.error > goal:
            environment.say(f"no setting reaches {goal:.3g}; the most accurate one:")
        environment.say(_sentence(best, goal, ref), *lines)
    for entry in entries:
        if entry.reason and not entry.reason.startswith(STOPPED):
            tell(environment, "warning", f"{' '.join(filter(None, entry.label))}: {entry.reason}")
    return ExitStatus.DONE


def _written(source: Path, text: str) -> str:
    """Name of the file, beside the given one, that has the recommended model; another text stays as .bak."""
    from spacar_formats.safety import backup_path, write_text

    path = source.with_name(f"{source.stem}.trade.dat")
    if path.exists() and path.read_bytes() != text.encode():
        path.replace(backup_path(path))
    write_text(path, text)
    return path.name


def _numbers(text: str) -> tuple[float, ...]:
    from spacar.studies.assignments import values

    found = values(text)
    if any(v <= 0.0 for v in found):
        raise UsageError(f"'{text}': the values must be positive", "usage.trade")
    return found


def _whole(text: str, option: str) -> tuple[int, ...]:
    from spacar.studies.assignments import values

    found = values(text)
    if any(v != int(v) or v < 0 for v in found):
        raise UsageError(f"{option} {text}: whole numbers are needed", "usage.trade")
    return tuple(int(v) for v in found)


def _rows(environment: Environment, trade: Any, wanted: list[Any], output: Path | None, jobs: int) -> list[Any]:
    """Rows of all setups: those of an earlier run of this study, and the others as they finish."""
    from spacar.studies.runs.rows import Rows
    from spacar.studies.runs.setting import Job, run_setup
    from spacar.studies.runs.workers import Lost, run

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rows.jsonl" if output is None else output.with_name(f"{output.name}.rows.jsonl")
        with Rows(path, ()) as rows:
            todo = [Job(trade, s) for s in wanted if trade.key(s) not in rows.done]
            outcomes = run(run_setup, todo, jobs=jobs)
            for job, outcome in counted(environment, outcomes, len(todo), "settings"):
                if isinstance(outcome, Lost):
                    outcome = {"case": trade.key(job.setup), "status": "failed", "reason": outcome.reason}
                rows.add(outcome)
            return list(rows.done.values())


def _cells(entry: Any) -> tuple[str, ...]:
    note = STOPPED if entry.reason.startswith(STOPPED) else "failed" if entry.reason else ""
    if not note and entry.estimate is not None:
        note = f"estimates {entry.estimate:.2e}"
    error = "" if math.isnan(entry.error) else f"{entry.error:.2e}"
    seconds = "" if math.isnan(entry.seconds) else f"{entry.seconds:.4g}"
    return (*entry.label, error, seconds, "" if entry.rhs is None else str(entry.rhs), note)


def _sentence(best: Any, target: float, ref: Any) -> str:
    if best is None:
        if ref.error > target:
            return f"no recommendation for {target:.3g}: the error of the reference itself is {ref.error:.2e}"
        return f"none of the settings reaches an error of {target:.3g}; try smaller tolerances or more elements"
    how = " with ".join(filter(None, best.label))
    return f"cheapest for an error of {target:.3g}: {how} ({best.seconds:.4g} s, error {best.error:.2e})"


def _document(entries: Any, ref: Any, target: float, best: Any) -> dict[str, Any]:
    def plain(e: Any) -> dict[str, Any]:
        setup = {} if e.setup is None else vars(e.setup)
        numbers = {"error": e.error, "seconds": e.seconds, "rhs": e.rhs, "estimate": e.estimate}
        numbers = {k: None if v != v else v for k, v in numbers.items()}
        return {"model": e.label[0], "integration": e.label[1], **setup, **numbers, "reason": e.reason}

    return {
        "reference": {"error": ref.error, "text": ref.text}, "target": target,
        "recommended": None if best is None else plain(best), "settings": [plain(e) for e in entries],
    }  # fmt: skip


def _write(path: Path, document: Mapping[str, Any]) -> None:
    """The whole table, complete or not at all."""
    from spacar_formats.safety import write_text

    if path.suffix.lower() == ".json":
        text = json.dumps(document, indent=1) + "\n"
    else:
        rows = document["settings"]
        names = list(dict.fromkeys(name for row in rows for name in row))
        text = csv_text(names, ([row.get(name) for name in names] for row in rows))
    write_text(path, text)
