"""Cases on a Dask cluster that is already running; the package is an optional extra."""

from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any

from spacar.errors import UsageError
from spacar.studies.runs.workers import Lost

PATIENCE = "10s"
AHEAD = 4  # cases handed over for every thread of the cluster: workers that come later get work, too
FEWEST = 256


def run_on_cluster(function: Callable[[Any], Any], cases: Iterable[Any], scheduler: str) -> Iterator[tuple[Any, Any]]:
    """Outcomes of function(case) as they finish on the cluster at `scheduler` (host:port or a scheduler file).

    Scheduler and workers need spacar, the workers also the files that the model refers to, under the same path. A case
    whose worker dies, or that never got there, is `Lost`. Raises UsageError when Dask is missing or the scheduler does
    not answer.
    """
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
