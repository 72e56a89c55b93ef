"""Cases of a sweep in batches (spacar.studies.ensemble), where that is possible.

A batch is one piece of work for a process, or for threads on all cores of this one, as C lets go of Python's lock; its
rows appear together. Where a case comes to a dead point or leaves the range of a theory, all cases in the lanes beside
it are run alone, so that the row of each says what is wrong with that case.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain, islice

from spacar.deck import Deck
from spacar.errors import SpacarError
from spacar.modes import find_mode
from spacar.studies.affine_cases import affine_cases
from spacar.studies.assignments import change
from spacar.studies.ensemble import motions, why_not
from spacar.studies.followers import GroupMotions
from spacar.studies.rows import Row
from spacar.studies.side_by_side import alike, side_by_side
from spacar.studies.sweep import LOST, Case, Study, Values, row, run_case
from spacar.studies.workers import Engine, Lost, cores

SIZE = 64  # cases of a batch of a process: a killed one loses them
QUICK, LARGEST = 0.5, 1024  # seconds of a batch in this process below which the next one is larger, up to so many cases


@dataclass(frozen=True)
class Chunk:
    """Cases that run as one batch."""

    study: Study
    cases: tuple[Values, ...]
    threads: int = 1


def in_batches(study: Study, cases: Iterable[Values], engine: Engine, jobs: int | None = 1) -> Iterator[Row]:
    """Rows of all cases. `engine` runs on `jobs` processes, 1: here; None: here, in threads on all cores."""
    coming = iter(cases)
    processes = jobs or 1
    first = list(islice(coming, SIZE * processes))
    size = max(1, min(SIZE, -(-len(first) // processes)))
    threads = cores() if jobs is None else 1
    chunks = _chunks(study, chain(first, coming), size, threads, growing=processes == 1)
    for chunk, outcome in engine(run_chunk, chunks) if processes > 1 else ((c, run_chunk(c)) for c in chunks):
        if isinstance(outcome, Lost):
            for values in chunk.cases:
                yield {**row(study, values, {}, 0.0, outcome.reason), "status": LOST}
        else:
            yield from outcome


def _chunks(study: Study, cases: Iterator[Values], size: int, threads: int, growing: bool) -> Iterator[Chunk]:
    while batch := tuple(islice(cases, size)):
        begun = time.perf_counter()
        yield Chunk(study, batch, threads)
        if growing and time.perf_counter() - begun < QUICK:
            size = min(4 * size, LARGEST)


def is_motion(study: Study) -> bool:
    """Is the mode of the study one that an ensemble can integrate, a motion without linearized equations?"""
    mode = find_mode(study.mode)
    return mode.integrated and not mode.linearized


def reason(study: Study, values: Values) -> str:
    """Why the cases of a study, the first of which has these values, cannot run together; empty when they can.

    Raises SpacarError where the model itself cannot be built.
    """
    if not is_motion(study):
        return "only mode 1 runs in batches"
    try:
        return why_not(change(study.deck, study.settings, values), **study.options)
    except SpacarError:  # this case cannot be; the others may
        return why_not(study.deck, **study.options)


def run_chunk(chunk: Chunk) -> list[Row]:
    """Rows of the cases of a chunk, run together where they are alike and singly where not, or where one fails."""
    study = chunk.study
    begun = time.perf_counter()
    found: dict[int, tuple[float | complex, ...]] = {}
    try:
        _run_together(study, chunk, found)
    except (SpacarError, ArithmeticError):
        found.clear()
    seconds = (time.perf_counter() - begun) / max(len(found), 1)
    names = [q.name for q in study.quantities]
    together = [
        row(study, chunk.cases[k], dict(zip(names, found[k], strict=True)), seconds, "") for k in sorted(found)
    ]
    alone = (values for k, values in enumerate(chunk.cases) if k not in found)
    return together + [run_case(Case(study, values)) for values in alone]


def _run_together(study: Study, chunk: Chunk, found: dict[int, tuple[float | complex, ...]]) -> None:
    """Put the quantities of the cases that can be run together under their places."""
    cases = affine_cases(study.deck, study.settings, chunk.cases, **study.options)
    if cases is None:
        chosen, decks = _alike(study, chunk.cases)
        if not decks:
            return
        cases = side_by_side(decks, **study.options)
    else:
        chosen = list(cases.chosen)

    def keep(motion: GroupMotions) -> None:
        if not motion.own:
            return
        columns = [q.numbers(motion, len(motion.own)) for q in study.quantities]
        results = dict(motion.results()) if any(column is None for column in columns) else {}
        for lane, k in enumerate(motion.own):
            if any(column is None for column in columns):
                result = results[k]
                found[chosen[k]] = tuple(q.number(result) for q in study.quantities)
            else:
                values = tuple(column[lane] for column in columns)  # type: ignore[index]
                if None not in values:
                    found[chosen[k]] = values  # type: ignore[assignment]

    for _ in motions(cases, keep, threads=chunk.threads, **study.options):
        pass


def _alike(study: Study, cases: Sequence[Values]) -> tuple[list[int], list[Deck]]:
    """Places and decks of the cases that can be run together; `run_case` records why the others cannot."""
    chosen: list[int] = []
    decks: list[Deck] = []
    for k, values in enumerate(cases):
        with suppress(SpacarError):
            deck = change(study.deck, study.settings, values)
            if alike(decks[0], deck) if decks else not why_not(deck, **study.options):
                chosen.append(k)
                decks.append(deck)
    return chosen, decks
