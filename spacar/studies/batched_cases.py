"""Cases of a sweep in batches (spacar.studies.ensemble), where that is possible.

A chunk is one piece of work for a process, or for threads on all cores of this one, as C lets go of Python's lock. Its
cases are followed in groups, whose rows appear together. Where a case comes to a dead point or leaves the range of a
theory, all cases in the lanes beside it are run alone, so that the row of each says what is wrong with that case.
"""

import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from itertools import chain, islice
from typing import NamedTuple

from spacar.deck import Deck
from spacar.errors import SpacarError
from spacar.mechanism import Mechanism, build
from spacar.modes import find_mode
from spacar.studies.affine_cases import affine_cases
from spacar.studies.assignments import Values, change
from spacar.studies.ensemble import GroupMotions, motions, why_not, why_not_of
from spacar.studies.policies.sweep import LOST, Case, Study, done_row, failed_row, run_case
from spacar.studies.runs.rows import Row
from spacar.studies.runs.workers import Engine, Lost, cores
from spacar.studies.side_by_side import Cases, alike, side_by_side

SIZE = 64  # cases of a chunk of a process: a killed one loses them; and of cases that are built side by side
LARGEST = 1024  # cases of a chunk in this process, whose numbers are made together
STATEMENTS = 100_000  # of all its cases, unless they are SIZE: with some 100 numbers each, 80 MB
Numbers = tuple[float | complex, ...]


class Chunk(NamedTuple):
    """Cases whose numbers are made together."""

    study: Study
    cases: tuple[Case, ...]
    threads: int = 1
    built: Mechanism | None = None


def in_batches(
    study: Study, cases: Iterable[Case], engine: Engine, jobs: int | None = 1, built: Mechanism | None = None
) -> Iterator[list[Row]]:
    """Rows of all cases. `engine` runs on `jobs` processes, 1: here; None: here, in threads on all cores. `built`: the
    mechanism of one of them, where there is one."""
    coming = iter(cases)
    processes = jobs or 1
    if processes == 1:
        threads = cores() if jobs is None else 1
        size = min(LARGEST, max(SIZE, STATEMENTS // len(study.deck.statements)))
        while batch := tuple(islice(coming, size)):
            yield from groups_of_rows(Chunk(study, batch, threads, built))
        return
    first = list(islice(coming, SIZE * processes))
    size = max(1, min(SIZE, -(-len(first) // processes)))
    every = chain(first, coming)
    chunks = (Chunk(study, batch) for batch in iter(lambda: tuple(islice(every, size)), ()))
    for chunk, outcome in engine(run_chunk, chunks):
        if isinstance(outcome, Lost):
            yield [failed_row(case, 0.0, outcome.reason, LOST) for case in chunk.cases]
        else:
            yield outcome


def is_motion(study: Study) -> bool:
    """Is the mode of the study one that an ensemble can integrate, a motion without linearized equations?"""
    mode = find_mode(study.mode)
    return mode.integrated and not mode.linearized


def reason(study: Study, values: Values) -> tuple[str, Mechanism | None]:
    """Why the cases of a study, the first of which has these values, cannot run together; empty when they can. And the
    mechanism that was built to see it.

    Raises SpacarError where the model itself cannot be built.
    """
    if not is_motion(study):
        return "only mode 1 runs in batches", None
    try:
        built = build(change(study.deck, study.settings, values), 1, **study.options)
    except SpacarError:  # this case cannot be; the others may
        built = build(study.deck, 1, **study.options)
    return why_not_of(built), built


def run_chunk(chunk: Chunk) -> list[Row]:
    return list(chain.from_iterable(groups_of_rows(chunk)))


def groups_of_rows(chunk: Chunk) -> Iterator[list[Row]]:
    """Rows of the cases of a chunk, run together where they are alike and singly where not, or where one fails."""
    study = chunk.study
    done: set[int] = set()
    begun = time.perf_counter()
    try:
        for cases in _cases(chunk):
            numbers_of = partial(_numbers, study, cases.chosen)
            for found in motions(cases, numbers_of, threads=chunk.threads, **study.options):
                now = time.perf_counter()
                seconds, begun = (now - begun) / max(len(found), 1), now
                done.update(found)
                yield [done_row(chunk.cases[k], numbers, seconds) for k, numbers in found.items()]
    except (SpacarError, ArithmeticError):
        pass  # the run of a case says why
    for k, case in enumerate(chunk.cases):
        if k not in done:
            yield [run_case(case)]


def _cases(chunk: Chunk) -> Iterator[Cases]:
    """Those that can be run together, with their places: all at once, or built side by side a few at a time."""
    study = chunk.study
    values = [case.values for case in chunk.cases]
    cases = affine_cases(study.deck, study.settings, values, chunk.built, **study.options)
    if cases is not None:
        yield cases
        return
    for first in range(0, len(values), SIZE):
        chosen, decks = _alike(study, values[first : first + SIZE])
        if decks:
            yield side_by_side(decks, **study.options)._replace(chosen=[first + k for k in chosen])


def _numbers(study: Study, chosen: Sequence[int], group: GroupMotions) -> dict[int, Numbers]:
    """The quantities of the cases of a group, by their places; without those whose run says what is wrong."""
    if not group.own:
        return {}
    columns = [q.numbers(group, len(group.own)) for q in study.quantities]
    if any(column is None for column in columns):
        return {chosen[k]: tuple(q.number(result) for q in study.quantities) for k, result in group.results()}
    rows = zip(*columns, strict=True)
    return {chosen[k]: numbers for k, numbers in zip(group.own, rows, strict=True) if None not in numbers}


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
