"""Studies in one line: `spacar.sweep` and `spacar.trade`, for users of Python; the commands ask the same questions.

What they answer, rows and settings, prints short, draws itself and becomes tables.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from spacar.calls import Source, checked_options, deck_of, has_interval, texts
from spacar.deck import Deck
from spacar.deck.rewrite.refine import flexible_beams
from spacar.errors import UsageError
from spacar.modes import MODES, Mode, find_mode, registered
from spacar.studies.assignments import Axis, Setting, Values, combine, setting
from spacar.studies.assignments import values as listed_values
from spacar.studies.batched_cases import in_batches, is_motion, reason
from spacar.studies.policies.simplification import cheapest, command_line, run_options, simpler_deck
from spacar.studies.policies.sweep import Batch, Study
from spacar.studies.policies.sweep import sweep as swept
from spacar.studies.policies.trade import Entry, Reference
from spacar.studies.runs.quantities import quantity
from spacar.studies.runs.rows import Row, Rows
from spacar.studies.runs.setting import Trade, default_variables
from spacar.studies.runs.workers import Engine, run
from spacar.summary import counted

INTERVAL = ("duration", "n_steps")  # options of trade, which chooses the others

SHOWN = 6  # rows in a summary


class SweepRows(list[Row]):
    """The rows of a sweep, a dict a case, in a list.

    source            name of the model
    changed, results  names of the columns that were set, and of those that were asked for

    >>> import spacar
    >>> rows = spacar.sweep("data/plbeam5.dat", {"ESTIFF.*[EI]": [10.0, 20.0]}, "tip: x[11,2]@end", mode=7)
    >>> rows.results, len(rows)
    (('tip',), 2)
    """

    def __init__(self, rows: list[Row], source: str, changed: tuple[str, ...], results: tuple[str, ...]) -> None:
        super().__init__(rows)
        self.source, self.changed, self.results = source, changed, results

    def __repr__(self) -> str:
        failed = sum(row["status"] != "done" for row in self)
        lines = [f"Sweep of {self.source}: {counted(len(self), 'case')}, {failed} failed"]
        for row in self[:SHOWN]:
            numbers = ", ".join(f"{name} = {row[name]:.6g}" for name in self.changed)
            answers = (f"{name} = {_shown(row.get(name))}" for name in self.results)
            lines.append(f"  {numbers}: {row['reason'] or ', '.join(answers)}")
        if len(self) > SHOWN:
            lines.append(f"  ... {len(self) - SHOWN} more")
        return "\n".join([*lines, "  rows[0], .plot(), .to_pandas()"])

    def plot(self, *names: str, path: str | Path | None = None, against: str | None = None) -> Any:
        """A matplotlib figure of results, default all, over a number that was changed, default the first; also written
        to `path`. The other numbers make a curve each. Raises UsageError for other names."""
        return registered("sweep_plot")(self, names, path, against=against)

    def to_pandas(self) -> Any:
        """A pandas.DataFrame, a row a case. Raises UsageError without pandas (`pip install 'spacar[tables]'`)."""
        return registered("frame_of_rows")(self)


@dataclass(frozen=True)
class TradeAnswer:
    """What `spacar.trade` found.

    best       the cheapest setting within `reached`: `error`, `seconds`, `label`; without one the most accurate
    options    of `spacar.run` for it, on the model `deck`;  command  the same on the command line, "" where `deck` is
               simpler than the model that was given
    reached    `target`, or the error that could be reached within the budget
    entries    all settings that were tried;  reference  what they were compared with, and its own `error`
    skipped    settings that the budget left no time for
    """

    target: float
    best: Entry | None
    options: dict[str, Any]
    command: str
    entries: tuple[Entry, ...] = field(repr=False)
    reference: Reference = field(repr=False)
    skipped: int = 0
    title: str = ""
    stationary: bool = False
    reached: float = 0.0
    deck: Deck | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        lines = [f"Trade for an error of {self.target:.3g} (that of the reference: {self.reference.error:.2e})"]
        shown = sorted((e for e in self.entries if not e.reason), key=lambda e: e.seconds)
        for entry in shown[:SHOWN]:
            mark = "->" if entry == self.best else "  "
            how = " ".join(filter(None, entry.label))
            lines.append(f"{mark} {how:<40} error {entry.error:.2e} {entry.seconds:.4g} s")
        if self.reached > self.target or (self.best and self.best.error > self.target):
            lines.append("none of the settings is known to be accurate enough")
        how = f"spacar.run({self.deck.mode}, answer.deck, **answer.options)" if self.deck else ""
        return "\n".join([*lines, self.command or how])

    def plot(self, path: str | Path | None = None) -> Any:
        """The work-precision diagram, a matplotlib figure, also written to `path`."""
        return registered("trade_plot")(self, path)

    def to_pandas(self) -> Any:
        """A pandas.DataFrame, a row a setting. Raises UsageError without pandas (`pip install 'spacar[tables]'`)."""
        rows = [
            {
                "model": e.label[0], "integration": e.label[1], "error": e.error, "seconds": e.seconds,
                "right-hand sides": e.rhs, "reason": e.reason,
            }
            for e in self.entries
        ]  # fmt: skip
        return registered("frame_of_rows")(rows)


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, int | float) else str(value)


def sweep(
    source: Source,
    change: Mapping[str, Iterable[float] | str],
    results: str | Sequence[str],
    *,
    mode: int | None = None,
    together: bool = False,
    jobs: int | None = None,
    output: str | Path | None = None,
    retry: bool = False,
    batch: bool | None = None,
    **options: Any,
) -> SweepRows:
    """Run a model for many values of its numbers. One row (a dict) a case: the values, the results, `status`
    ("done", "failed", "lost"), `seconds` and `reason`; `.plot()`, `.to_pandas()`.

    source    path of the input file, a Deck or a Model
    mode      that is run; default: 1 with TIMESTEP, else 7
    change    {"ESTIFF.*[EI]": [5.0, 10.0], "XM.8": "1:100:7:log"}: targets and values: `spacar help studies`; all
              combinations are run, with `together` the first values of all targets, then the second ones ...
    results   expressions that come to one number: "x[8,1]@end", "tip: max(abs(x[8,2]))"
    jobs      processes; with more than one, a script needs `if __name__ == "__main__":`. None: this one, batches in
              threads on all cores
    output    .csv or .jsonl that keeps the rows: cases that it holds are not run again, with `retry` failed ones are
    batch     many cases at once in the lanes of the processor's vectors; None: where that is possible
    options   of `spacar.run`, such as rtol, duration, n_steps

    A case that fails is a row. Raises UsageError for a target, a value or an expression that cannot be, and InputError.

    >>> import spacar
    >>> rows = spacar.sweep("data/crank.dat", {"XM.6": [0.03, 0.06]}, "x[6,1]@end", jobs=1)
    >>> [row["status"] for row in rows]
    ['done', 'done']
    """
    if not change or not isinstance(change, Mapping):
        raise UsageError("nothing to vary: give targets and their values, such as {'XM.8': [1, 2]}", "usage.sweep")
    wanted = texts("results", results)
    if not wanted:
        raise UsageError("nothing to keep: give at least one result, for instance 'x[6,1]@end'", "usage.sweep")
    options, _ = checked_options(options)
    axes = [Axis(setting(target), _numbers(target, given)) for target, given in change.items()]
    settings, cases = combine(axes, together)
    study = study_of(source, mode, settings, wanted, options)
    engine: Engine = partial(run, jobs=jobs or 1)
    path = None if output is None else Path(output)
    found: dict[str, Row] = {}
    if path is not None:
        if path.suffix.lower() not in (".csv", ".jsonl"):
            raise UsageError(f"output {path}: the rows are written as .csv or .jsonl", "usage.sweep")
        with Rows(path, study.columns) as rows:
            found = {key: _typed(row) for key, row in rows.done.items()}
    batches, _ = batches_of(study, cases, engine, jobs, batch, "batch")
    keys = [study.key(case) for case in cases]
    found.update((row["case"], row) for row in swept(study, cases, path, engine, retry, batches, keys))
    kept = [found[key] for key in keys]
    return SweepRows(kept, study.deck.source, tuple(s.name for s in settings), tuple(q.name for q in study.quantities))


def trade(
    source: Source, target: float = 1e-4, *, budget: float = 60.0, mode: int | None = None,
    variables: str | Sequence[str] = (), repeats: int = 3, **options: Any,
) -> TradeAnswer:  # fmt: skip
    """The cheapest model and setting of mesh and integration whose error is within `target`.

    source     path of the input file, a Deck or a Model
    target     error over the amplitude of the variables;  budget  seconds for everything
    mode       default: 1 with TIMESTEP, else 7
    variables  expressions whose error counts; default: all free coordinates
    repeats    runs of each setting, of which the median time counts
    options    of `spacar.run`: duration, n_steps, compiled

    Raises UsageError, InputError, and AnalysisError when the reference cannot be computed in the budget.

    >>> import spacar
    >>> answer = spacar.trade("data/plbeam5.dat", mode=7, target=1e-2, budget=5)
    >>> type(answer.options)
    <class 'dict'>
    """
    options, _ = checked_options(options)
    refused = sorted(set(options) - {*INTERVAL, "compiled"})
    if refused:
        raise UsageError(f"trade chooses {', '.join(refused)} itself", "usage.trade")
    numbers = isinstance(target, Real) and isinstance(budget, Real) and isinstance(repeats, Integral)
    if not numbers or not 0.0 < target < 1.0 or not budget > 0.0 or repeats < 1:
        text = "the target is between 0 and 1, the budget positive, repeats a whole number from 1"
        raise UsageError(text, "usage.trade")
    asked = trade_of(source, mode, texts("variables", variables), repeats, options)
    number, deck = asked.mode, asked.deck
    found, _ = cheapest(asked, target, budget)
    best, simpler = found.best, simpler_deck(asked, found.best)
    given = {} if best is None or best.setup is None else run_options(asked, best.setup)
    command = command_line(number, given, deck.source) if given and simpler is None else ""
    return TradeAnswer(
        target, best, given, command, tuple(found.entries), found.reference, found.skipped,
        f"{deck.source}, mode {number}", asked.stationary, found.goal, simpler or deck,
    )  # fmt: skip


def trade_of(
    source: Source, mode: int | None, variables: Sequence[str], repeats: int, options: dict[str, Any]
) -> Trade:
    """Raises UsageError for a mode or a deck that has no trade."""
    mode = mode_of(source, options) if mode is None else mode
    analysis = find_mode(mode)
    if not _compared(analysis):
        able = ", ".join(str(m.number) for m in MODES.values() if _compared(m))
        raise UsageError(f"trade runs modes {able}, not {mode}", "usage.trade")
    deck = deck_of(source, analysis.number)
    if analysis.integrated and not has_interval(deck) and len([k for k in INTERVAL if k in options]) < 2:
        raise UsageError(f"{deck.source} has no TIMESTEP; give --time and --steps", "usage.timestep")
    if analysis.stationary and not flexible_beams(deck):
        raise UsageError("a stationary solution without flexible beams has no error to compare", "usage.trade")
    chosen = tuple(map(quantity, variables)) or default_variables(analysis.number, deck)
    return Trade(analysis.number, deck, chosen, repeats, options, named=bool(variables))


def mode_of(source: Source, options: Mapping[str, Any]) -> int:
    """The mode of a study for which none is given: 1 where there is a time interval, else 7."""
    plain = deck_of(source, 1 if isinstance(source, Deck) else 7)
    return 1 if has_interval(plain) or "duration" in options else 7


def _compared(mode: Mode) -> bool:
    """Motions and stationary solutions; not linearizations along a motion."""
    return mode.stationary or (mode.integrated and not mode.linearized)


def study_of(
    source: Source, mode: int | None, settings: tuple[Setting, ...], results: Iterable[str], options: dict[str, Any]
) -> Study:
    """Raises UsageError when two columns have the same name, a target does not exist, or the mode needs a result."""
    analysis = find_mode(mode_of(source, options) if mode is None else mode)
    number = analysis.number
    if analysis.takes_setpoints:
        text = f"a sweep does not run mode {number}, which linearizes along another result; run both modes"
        raise UsageError(f"{text} for every case (spacar.run, nominal=...)", "usage.sweep")
    study = Study(number, deck_of(source, number), settings, tuple(map(quantity, results)), options)
    doubled = [c for c in study.columns if study.columns.count(c) > 1]
    if doubled:
        text = f"two columns would be called {doubled[0]}; name the quantity 'NAME: EXPRESSION'"
        raise UsageError(text, "usage.sweep")
    for target in (t for s in study.settings for t in s.targets):
        target.places(study.deck)  # a wrong target ends the study now, not in every row
    return study


def batches_of(
    study: Study, cases: Sequence[Values], engine: Engine, jobs: int | None, wanted: bool | None, option: str
) -> tuple[Batch | None, str]:
    """What runs the cases in batches; None when they run one by one, and why if nobody has asked for that.

    `jobs` processes, None: threads on all cores. Raises UsageError for a batch that cannot be; `option` names what
    asked for it.
    """
    if wanted is False or not (wanted or is_motion(study)):
        return None, ""
    why, built = reason(study, cases[0])
    if why and wanted:
        raise UsageError(f"{option}: {why}", "usage.sweep")
    if why:
        return None, why
    return partial(in_batches, engine=engine, jobs=jobs, built=built), ""


def _numbers(target: str, given: Iterable[float] | str) -> Values:
    """Values of a target, from numbers or a text such as 1:100:7:log. Raises UsageError."""
    if isinstance(given, str):
        return listed_values(given)
    try:
        found = tuple(float(v) for v in given)
    except (TypeError, ValueError):
        text = f"the values of {target} are {given!r}; give a list of numbers, or a text such as '1:10:4'"
        raise UsageError(text, "study.set") from None
    if not found:
        raise UsageError(f"{target} has no values", "study.set")
    return found


def _typed(row: Row) -> Row:
    """A row of a csv file with numbers where there are numbers."""

    def value(text: Any) -> Any:
        for kind in (float, complex):
            try:
                return kind(text)
            except (TypeError, ValueError):
                continue
        return text

    return {k: v if k in ("case", "status", "reason") else value(v) for k, v in row.items()}
