"""The statement: a keyword with its typed values and their places."""

from __future__ import annotations

from typing import NamedTuple

from spacar.deck.lexer import columns_of

Value = int | float | str


def number(value: Value) -> float:
    """A value as a real number; one with a direction (a complex step, `spacar.deck.directed`) keeps it."""
    return value if isinstance(value, complex) else float(value)


class Statement(NamedTuple):
    """One statement of an input file.

    `keyword` is in capitals with aliases resolved, `values` are typed by the keyword table, `block` is 1, 2
    or 3, `line` that of the keyword (from 1). `place`: line and column of every value, or the text of the line without
    comment, when it holds this statement and nothing else, or nothing for a statement that follows from another one.
    """

    keyword: str
    values: tuple[Value, ...]
    block: int
    line: int
    place: tuple[tuple[int, int], ...] | str = ()

    @property
    def lines(self) -> tuple[int, ...]:
        """Those of every value (from 1)."""
        if isinstance(self.place, str) or not self.place:
            return (self.line,) * len(self.values)
        return tuple([line for line, _ in self.place])

    @property
    def columns(self) -> tuple[int, ...]:
        """Those of every value (from 1); none for a statement that follows from another one."""
        if isinstance(self.place, str):
            return columns_of(self.place)[1:]
        return tuple([column for _, column in self.place])

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
        return self.values[start:]  # type: ignore[return-value]

    def reals(self, start: int, count: int, default: float = 0.0) -> tuple[float, ...]:
        """`count` values from `start`, missing ones replaced by `default`."""
        given = tuple(map(number, self.values[start : start + count]))
        return given + (default,) * (count - len(given))
