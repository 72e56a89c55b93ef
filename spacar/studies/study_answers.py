"""What `spacar.sweep` and `spacar.trade` answer: rows and settings that print short, draw themselves, become tables."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from spacar.deck import Deck
from spacar.modes import registered
from spacar.studies.policies.trade import Entry, Reference
from spacar.studies.runs.rows import Row
from spacar.summary import counted

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
            answers = (f"{name} = {_number(row.get(name))}" for name in self.results)
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


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, int | float) else str(value)
