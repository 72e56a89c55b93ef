"""`spacar sweep FILE --set TARGET=VALUES --result QUANTITY`: parameter studies."""

import json
import time
from functools import partial
from pathlib import Path
from typing import Any

from spacar.errors import UsageError
from spacar.modes import find_mode
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, ExitStatus, tell
from spacar_cli.input_files import input_file
from spacar_cli.studying import ROWS, common, counted


@words.command("sweep", epilog="Targets and quantities: `spacar help studies`. Exit status 1: cases failed.")
@words.option(
    "assignments", ": values of a number of the input file: 'ESTIFF.3[EI]=100,200,300', 'XM.8=1:100:7:log', "
    "'ESTIFF.*[EI]=@cases.csv:ei'. Several are combined.", multiple=True,
)  # fmt: skip
@words.option("table_file")
@words.option("together")
@words.option("mode", "; default 1 with TIMESTEP, else 7")
@words.option("results", ": 'x[6,1]@end', 'max(sig[1,1])', 'abs(eigval[1])'. May be repeated.", multiple=True)
@words.option("output", ": rows, .csv or .jsonl. Default: FILE.sweep.csv.", type=ROWS)
@words.option("scheduler")
@words.option("regardless")
@words.option("retry_failed")
@words.option("batch", "; default where that is possible.", default=None)
@words.option("atol", ", instead of ERROR")
@words.option("rtol", ", instead of ERROR")
@words.option("integrator", ", instead of INTEGRAT")
@words.option("compiled", default=None)
@common
def command(
    environment: Environment, /, file: Path, assignments: tuple[str, ...], table_file: Path | None, together: bool,
    mode: int | None, results: tuple[str, ...], output: Path | None, scheduler: str | None, regardless: bool,
    retry_failed: bool, batch: bool | None, jobs: int | None, as_json: bool, **options: Any,
) -> ExitStatus:  # fmt: skip
    """Run FILE for many values of its numbers and keep quantities of every case.

    Every case is one row of the output, written when it has finished. Started again, the command runs what is not
    there yet.
    """
    from spacar_formats.disk_room import require_room_for_rows

    from spacar.deck import read_deck
    from spacar.studies.policies.sweep import DONE, Study, sweep
    from spacar.studies.runs.quantities import quantity
    from spacar.studies.runs.workers import run
    from spacar.studies.study_calls import batches_of, mode_of, require_columns

    source = input_file(file)
    if not results:
        raise UsageError("nothing to keep: give at least one --result, for instance 'x[6,1]@end'", "usage.sweep")
    given = {name: value for name, value in options.items() if value is not None}
    number = find_mode(mode_of(source, given) if mode is None else mode).number
    settings, cases = _cases(assignments, table_file, together)
    study = Study(number, read_deck(source, number), settings, tuple(map(quantity, results)), given)
    require_columns(study)
    path = output or source.with_name(f"{source.stem}.sweep.csv")
    if path.suffix.lower() not in (".csv", ".jsonl"):
        raise UsageError(f"--output {path}: the rows are written as .csv or .jsonl", "usage.sweep")
    if not regardless:
        require_room_for_rows(len(cases), 3 + len(settings) + len(results), path.parent)
    engine: Any = partial(run, jobs=jobs)
    if scheduler is not None:
        from spacar_cli.cluster import run_on_cluster

        engine = partial(run_on_cluster, scheduler=scheduler)
    batches = None
    if scheduler is None:
        batches, why = batches_of(study, cases, engine, jobs, batch, "--batch")
        if why and not as_json:
            environment.wrote(f"the cases run one by one, not in batches: {why}")
    begun = time.perf_counter()
    failed = new = 0
    reasons: list[str] = []
    for row in counted(environment, sweep(study, cases, path, engine, retry_failed, batches), len(cases), "cases"):
        new += 1
        if row["status"] != DONE:
            failed += 1
            reasons.append(f"{', '.join(f'{s.name} = {row[s.name]:.9g}' for s in settings)}: {row['reason']}")
    seconds = time.perf_counter() - begun
    for reason in reasons[:5]:
        tell(environment, "warning", reason)
    if as_json:
        summary = {"cases": len(cases), "run": new, "failed": failed, "seconds": seconds, "output": str(path)}
        environment.say(json.dumps(summary))
    else:
        environment.wrote(f"{len(cases)} cases: {new} run in {seconds:.2f} s, {failed} of them failed; rows in {path}")
    return ExitStatus.FAILED if failed else ExitStatus.DONE


def _cases(assignments: tuple[str, ...], table_file: Path | None, together: bool) -> Any:
    """Settings and values of all cases; every row of --from is combined with every case of --set."""
    from spacar.studies import assignments as parameters

    if not assignments and table_file is None:
        raise UsageError("nothing to vary: give --set TARGET=VALUES or --from CSV", "usage.sweep")
    settings, cases = (
        parameters.combine([parameters.axis(a) for a in assignments], together) if assignments else ((), [()])
    )
    if table_file is not None:
        header, rows = parameters.table(table_file)
        settings = (*map(parameters.setting, header), *settings)
        cases = parameters.Combinations(rows, cases)
    if len({s.name for s in settings}) < len(settings):
        raise UsageError("a target is set by --set and by --from", "usage.sweep")
    return settings, cases
