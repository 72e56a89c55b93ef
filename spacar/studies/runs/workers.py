"""Independent cases on this process or on local processes.

`run` yields (case, outcome) as cases finish; an outcome is what the function returned or the text of what went wrong
outside of it. A local process that dies (killed, out of memory) takes only its own case with it: the cases that were
under way are run again, one process each, and the one that dies once more is given up.
"""

import os
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import chain, islice
from threading import Thread
from typing import Any, NamedTuple

HERE = 2.0  # seconds on this process before others are started
AHEAD = 2  # cases handed over per process
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class Lost(NamedTuple):
    """A case whose process died."""

    reason: str


Function = Callable[[Any], Any]
Engine = Callable[[Function, Iterable[Any]], Iterator[tuple[Any, Any]]]
"""Runs a picklable function of a module on every case: `run`, or that of a cluster."""


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run(function: Function, cases: Iterable[Any], jobs: int | None = 1) -> Iterator[tuple[Any, Any]]:
    """Outcomes of function(case) in the order in which they finish; exceptions of the function come through.

    `cases` are taken as they are needed: they may be more than fit into memory. `jobs` processes; None: this one for
    HERE seconds, and what is left then on all cores: it takes about as long to start processes.
    """
    coming = iter(cases)
    if jobs is None:
        until = time.monotonic() + HERE
        for case in coming:
            yield case, function(case)
            if time.monotonic() > until:
                break
        jobs = cores()
    first = list(islice(coming, jobs))
    coming = chain(first, coming)
    if len(first) <= 1:
        for case in coming:
            yield case, function(case)
    else:
        yield from _on_processes(function, coming, len(first))


def _on_processes(function: Function, cases: Iterator[Any], jobs: int) -> Iterator[tuple[Any, Any]]:
    from concurrent.futures import FIRST_COMPLETED, wait
    from concurrent.futures.process import BrokenProcessPool

    suspects: list[Any] = []
    waiting = list(islice(cases, 1))  # the next case, none at the end
    while waiting:
        with _pool(jobs) as pool:
            under_way: dict[Any, Any] = {}
            try:
                while waiting or under_way:
                    while waiting and len(under_way) < AHEAD * jobs:
                        under_way[pool.submit(function, waiting[0])] = waiting[0]
                        waiting = list(islice(cases, 1))
                    for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                        outcome = future.result()
                        yield under_way.pop(future), outcome
            except BrokenProcessPool:
                suspects += under_way.values()
    for case in suspects:
        with _pool(1) as pool:
            try:
                outcome = pool.submit(function, case).result()
            except BrokenProcessPool:
                outcome = Lost("the process died while it ran this case (killed, or out of memory)")
        yield case, outcome


def _end_with_parent() -> None:
    """Runs first in every process: without it, processes of a killed parent would wait for work for ever."""
    from multiprocessing import parent_process

    parent = parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    Thread(target=watch, daemon=True).start()


@contextmanager
def _pool(jobs: int) -> Iterator[Any]:
    """Fresh processes with one thread each; interrupted, it does not wait for cases that have not begun."""
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    unset = [name for name in THREADS if name not in os.environ]
    os.environ.update(dict.fromkeys(unset, "1"))
    pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_end_with_parent)
    try:
        yield pool
    except BaseException:
        for process in list((pool._processes or {}).values()):
            process.terminate()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
        for name in unset:
            os.environ.pop(name, None)
