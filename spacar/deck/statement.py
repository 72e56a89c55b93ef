"""The statement: a keyword with its typed values and their places."""

from __future__ import annotations

from dataclasses import dataclass

Value = int | float | str


def number(value: Value) -> float:
    """A value as a real number; one with a direction (a complex step, `spacar.deck.directed`) keeps it."""
    return value if isinstance(value, complex) else float(value)


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement of an input file.

    `keyword` is in capitals with aliases resolved, `values` are typed by the keyword table, `block` is 1, 2
    or 3, `line` that of the keyword, `lines` and `columns` those of every value (from 1).
    """

    keyword: str
    values: tuple[Value, ...]
    block: int
    line: int
    lines: tuple[int, ...]
    columns: tuple[int, ...] = ()

    @property
    def subject(self) -> str:
        """The keyword with its first value, as messages name it."""
        return f"{self.keyword} {self.values[0]}" if self.values else self.keyword

    def integer(self, index: int) -> int:
        """The value at `index` (from 0), which the table declares an integer."""
        value = self.values[index]
        assert isinstance(value, int)
        return value

    def real(self, index: int, default: float = 0.0) -> float:
        """The value at `index` (from 0) as a number, `default` when it was left out."""
        return number(self.values[index]) if index < len(self.values) else default

    def integers(self, start: int = 0) -> tuple[int, ...]:
        """The values from `start`, which the table declares integers."""
        return tuple(self.integer(i) for i in range(start, len(self.values)))

    def reals(self, start: int, count: int, default: float = 0.0) -> tuple[float, ...]:
        """`count` values from `start`, missing ones replaced by `default`."""
        return tuple(self.real(i, default) for i in range(start, start + count))
