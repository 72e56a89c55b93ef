"""`spacar sweep FILE --set TARGET=VALUES --result QUANTITY`: parameter studies."""

import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, ExitStatus, tell
from spacar_cli.input_files import input_file
from spacar_cli.row_output import ROWS, counted, of_studies

PATIENCE = "10s"
AHEAD = 4  # cases handed over for every thread of the cluster: workers that come later get work, too
FEWEST = 256


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
@of_studies
def command(
    environment: Environment, file: Path, assignments: tuple[str, ...], table_file: Path | None, together: bool,
    mode: int | None, results: tuple[str, ...], output: Path | None, scheduler: str | None, regardless: bool,
    retry_failed: bool, batch: bool | None, jobs: int | None, as_json: bool, **options: Any,
) -> ExitStatus:  # fmt: skip
    """Run FILE for many values of its numbers and keep quantities of every case.

    Every case is one row of the output, written when it has finished. Started again, the command runs what is not
    there yet.
    """
    from spacar_formats.disk_room import require_room_for_rows

    from spacar.studies.policies.sweep import DONE, sweep
    from spacar.studies.runs.workers import run
    from spacar.studies.study_calls import batches_of, study_of

    source = input_file(file)
    if not results:
        raise UsageError("nothing to keep: give at least one --result, for instance 'x[6,1]@end'", "usage.sweep")
    given = {name: value for name, value in options.items() if value is not None}
    settings, cases = _cases(assignments, table_file, together)
    study = study_of(source, mode, settings, results, given)
    path = output or source.with_name(f"{source.stem}.sweep.csv")
    if path.suffix.lower() not in (".csv", ".jsonl"):
        raise UsageError(f"--output {path}: the rows are written as .csv or .jsonl", "usage.sweep")
    if not regardless:
        require_room_for_rows(len(cases), 3 + len(settings) + len(results), path.parent)
    engine: Any = partial(run, jobs=jobs)
    if scheduler is not None:
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
        environment.say_json(summary)
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


def run_on_cluster(function: Callable[[Any], Any], cases: Iterable[Any], scheduler: str) -> Iterator[tuple[Any, Any]]:
    """Outcomes of function(case) as they finish on the cluster at `scheduler` (host:port or a scheduler file).

    Scheduler and workers need spacar, the workers also the files that the model refers to, under the same path. A case
    whose worker dies, or that never got there, is `Lost`. Raises UsageError when Dask is missing or the scheduler does
    not answer.
    """
    from spacar.studies.runs.workers import Lost

    try:
        from distributed import Client, as_completed
    except ImportError:
        text = "--scheduler needs Dask, which is not installed: pip install 'spacar[dask]', here and on the cluster"
        raise UsageError(text, "study.dask") from None
    where = {"scheduler_file": scheduler} if scheduler.endswith(".json") else {"address": scheduler}
    try:
        client = Client(**where, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise UsageError(f"no Dask scheduler answers at {scheduler}: {error}", "study.dask") from None
    with client:
        coming = iter(cases)
        case_of: dict[str, Any] = {}

        def hand_over(count: int) -> list[Any]:
            chosen = list(islice(coming, count))
            futures: list[Any] = client.map(function, chosen, pure=False)
            case_of.update((future.key, case) for future, case in zip(futures, chosen, strict=True))
            return futures

        under_way = as_completed(hand_over(max(FEWEST, AHEAD * sum(client.nthreads().values()))))
        for future in under_way:
            under_way.update(hand_over(1))
            case = case_of.pop(future.key)
            if future.status == "finished":
                yield case, future.result()
            else:
                reason = future.exception()
                yield case, Lost(f"{type(reason).__name__} on the cluster: {reason}")
