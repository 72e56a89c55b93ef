"""Cases of a sweep in batches (spacar.studies.ensemble), where that is possible and measures faster.

A few cases run singly first, then one batch; the faster way per case runs the rest. A batch is one piece of work for a
process and its rows appear together. When a case of a batch fails, all its cases run one by one, so that the row says
what is wrong with that case alone.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain, islice

from spacar.deck import Deck
from spacar.errors import SpacarError
from spacar.modes import find_mode
from spacar.studies.assignments import change
from spacar.studies.ensemble import alike, ensemble, why_not
from spacar.studies.rows import Row
from spacar.studies.sweep import LOST, Case, Study, Values, row, run_case, singly
from spacar.studies.workers import Engine, Lost

SAMPLE = 4  # cases that are run singly to know what one costs; the first of them also imports
SIZE = 64  # cases of a batch: more gain little, and a killed process loses them
FEWEST = 16  # cases for which a batch is tried


@dataclass(frozen=True)
class Chunk:
    """Cases that run as one batch."""

    study: Study
    cases: tuple[Values, ...]


def in_batches(
    study: Study, cases: Iterable[Values], engine: Engine, jobs: int = 1, always: bool = False
) -> Iterator[Row]:
    """Rows of all cases; `always` batches without measuring. `engine` runs on `jobs` processes."""
    coming = iter(cases)
    if not always:
        first = list(islice(coming, FEWEST))
        coming = chain(first, coming)
        if len(first) < FEWEST or reason(study, first[0]):
            yield from singly(study, coming, engine)
            return
        seconds = []
        for values in islice(coming, SAMPLE):
            found = run_case(Case(study, values))
            seconds.append(found["seconds"])
            yield found
        batch = tuple(islice(coming, SIZE))
        begun = time.perf_counter()
        yield from run_chunk(Chunk(study, batch))
        batched = (time.perf_counter() - begun) / len(batch)
        if batched > min(seconds[1:]):
            yield from singly(study, coming, engine)
            return
    first = list(islice(coming, SIZE * jobs))
    chunks = _chunks(study, chain(first, coming), max(1, min(SIZE, -(-len(first) // jobs))))
    for chunk, outcome in engine(run_chunk, chunks):
        if isinstance(outcome, Lost):
            for values in chunk.cases:
                yield {**row(study, values, {}, 0.0, outcome.reason), "status": LOST}
        else:
            yield from outcome


def _chunks(study: Study, cases: Iterator[Values], size: int) -> Iterator[Chunk]:
    while batch := tuple(islice(cases, size)):
        yield Chunk(study, batch)


def is_motion(study: Study) -> bool:
    """Is it what the ensemble integrates, without linearized equations?"""
    mode = find_mode(study.mode)
    return mode.integrated and not mode.linearized


def reason(study: Study, values: Values) -> str:
    """Why the cases of a study cannot run together; empty when they can."""
    if not is_motion(study):
        return "only mode 1 runs in batches"
    try:
        return why_not(change(study.deck, study.settings, values), **study.options)
    except SpacarError as error:
        return str(error)


def run_chunk(chunk: Chunk) -> list[Row]:
    """Rows of the cases of a chunk, run together where they are alike and singly where not, or where one fails."""
    study = chunk.study
    begun = time.perf_counter()
    together: list[tuple[Values, Deck]] = []
    others: list[Values] = []
    for values in chunk.cases:
        try:
            deck = change(study.deck, study.settings, values)
            fits = not why_not(deck, **study.options) if not together else alike(together[0][1], deck)
        except SpacarError:
            fits = False  # run_case records why
        if fits:
            together.append((values, deck))
        else:
            others.append(values)
    rows = []
    try:
        results = ensemble([deck for _, deck in together], **study.options) if together else []
        found = [{q.name: q.number(result) for q in study.quantities} for result in results]
        seconds = (time.perf_counter() - begun) / max(len(together), 1)
        rows = [row(study, values, own, seconds, "") for (values, _), own in zip(together, found, strict=True)]
    except (SpacarError, ArithmeticError):
        others = list(chunk.cases)
    return rows + [run_case(Case(study, values)) for values in others]
