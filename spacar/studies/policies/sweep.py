"""Parameter studies: the same model with other numbers, one row of quantities for every case.

A case that fails is a row too, with the reason; exceptions that are no SpacarError are recorded in the same way, so
that one case cannot end a study of thousands. A case whose process died is marked lost, and is run again when the study
is started again. Rows are append-only and finished cases are skipped, see `rows`.
"""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from spacar.calls import frames
from spacar.deck import Deck
from spacar.errors import SpacarError, type_and_text
from spacar.mechanism.user_files import model_digest
from spacar.result import Result
from spacar.studies.assignments import Setting, Values, change
from spacar.studies.runs.quantities import Quantity
from spacar.studies.runs.rows import Row, Rows, key
from spacar.studies.runs.workers import Engine, Lost, run

DONE, FAILED, LOST = "done", "failed", "lost"


@dataclass(frozen=True)
class Study:
    """What is run for every case: the model in a mode, with options of `spacar.run`, and what is kept."""

    mode: int
    deck: Deck
    settings: tuple[Setting, ...]
    quantities: tuple[Quantity, ...]
    options: dict[str, Any] = field(default_factory=dict)

    @cached_property
    def columns(self) -> tuple[str, ...]:
        names = (s.name for s in self.settings), (q.name for q in self.quantities)
        return ("case", *names[0], *names[1], "status", "seconds", "reason")

    def key(self, values: Sequence[float]) -> str:
        """What tells this case from every other one: model, mode, options, parameters, quantities."""
        names, asked = [s.name for s in self.settings], [(q.name, q.text) for q in self.quantities]
        return key(self._model, self.mode, sorted(self.options.items()), names, list(values), asked)

    @cached_property
    def _model(self) -> str:
        return model_digest(self.deck)


class Case(NamedTuple):
    """One set of values of a study, on its way to a process; `key` as `Study.key`."""

    study: Study
    values: Values
    key: str


Batch = Callable[[Study, Iterable[Case]], Iterator[list[Row]]]


def sweep(
    study: Study,
    cases: Iterable[Values],
    output: Path | None,
    engine: Engine = run,
    retry: bool = False,
    batch: Batch | None = None,
    keys: Sequence[str] | None = None,
) -> Iterator[Row]:
    """Rows of the cases that are not in `output` yet, each after it has been written there; None: of all, without a
    file.

    `cases` holds values in the order of study.settings; `engine` runs them (spacar.studies.runs.workers); `retry` runs
    failed cases again; `batch`, if given, runs them instead, many at once; `keys`: those of the cases, where they
    are known. Raises UsageError for a file of another study.
    """

    def unfinished(done: Mapping[str, Row]) -> Iterator[Case]:
        """The cases that have to be run, each once, one after the other as they are asked for."""
        begun: set[str] = set()
        for k, values in enumerate(cases):
            key = study.key(values) if keys is None else keys[k]
            status = done[key]["status"] if key in done else LOST  # a case whose process died is always run again
            if key not in begun and status != DONE and (status != FAILED or retry):
                begun.add(key)
                yield Case(study, values, key)

    file: AbstractContextManager[Rows | None] = Rows(output, study.columns) if output is not None else nullcontext()
    with file as rows:
        todo = unfinished(rows.done if rows else {})
        for group in batch(study, todo) if batch is not None else singly(todo, engine):
            if rows:
                rows.add(*group)
            yield from group


def singly(cases: Iterable[Case], engine: Engine) -> Iterator[list[Row]]:
    """Rows of cases that run one by one on an engine."""
    for case, outcome in engine(run_case, cases):
        yield [failed_row(case, 0.0, outcome.reason, LOST) if isinstance(outcome, Lost) else outcome]


def run_case(case: Case) -> Row:
    """Run one case to a row; a failure is a row with its reason."""
    study, begun = case.study, time.perf_counter()
    try:
        deck = change(study.deck, study.settings, case.values)
        result = Result.collect(frames(study.mode, deck, **study.options))
        return done_row(case, [q.number(result) for q in study.quantities], time.perf_counter() - begun)
    except Exception as error:
        return failed_row(case, time.perf_counter() - begun, explain(error))


def explain(error: Exception) -> str:
    """A failure in one line."""
    text = " ".join(str(error).split())
    return text if isinstance(error, SpacarError) and text else type_and_text(error)


def done_row(case: Case, numbers: Iterable[float | complex], seconds: float) -> Row:
    return dict(zip(case.study.columns, (case.key, *case.values, *numbers, DONE, round(seconds, 6), ""), strict=True))


def failed_row(case: Case, seconds: float, reason: str, status: str = FAILED) -> Row:
    given = {s.name: value for s, value in zip(case.study.settings, case.values, strict=True)}
    return {"case": case.key, **given, "status": status, "seconds": round(seconds, 6), "reason": reason}
