"""Statements of one keyword as columns; a statement is made when somebody asks for it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, groupby, repeat
from typing import Any

from spacar.deck.statement import Statement


class StatementGroup(Sequence[Statement]):
    """Statements with the same keyword, block and number of values in the order of the file; never empty.

    `values`: those of all, `width` of each statement; `lines` and `places`: `line` and `place` of each.
    """

    __slots__ = ("_made", "block", "keyword", "lines", "places", "values", "width")

    def __init__(self, keyword: str, block: int, width: int) -> None:
        self.keyword, self.block, self.width = keyword, block, width
        self.values: list[Any] = []
        self.lines: list[int] = []
        self.places: list[tuple[tuple[int, int], ...] | str] = []
        self._made: list[Statement] | None = None

    @classmethod
    def of(cls, *statements: Statement) -> StatementGroup:
        """That of some statements."""
        first = statements[0]
        group = cls(first.keyword, first.block, len(first.values))
        group.values = [*chain.from_iterable([s.values for s in statements])]
        group.lines, group.places = [s.line for s in statements], [s.place for s in statements]
        group._made = [*statements]
        return group

    def columns(self, start: int, end: int) -> list[list[Any]]:
        """Those of the values from `start` to before `end`."""
        return [self.values[i :: self.width] for i in range(start, end)]

    def rows(self) -> Iterator[tuple[Any, ...]]:
        """The values of each statement."""
        return zip(*[iter(self.values)] * self.width) if self.width else repeat((), len(self.lines))  # noqa: B905

    def distinct(self, count: int) -> bool:
        """Whether no two have the same first `count` values."""
        if len(self.lines) == 1:
            return True
        first = self.columns(0, min(count, self.width))
        return len({*first[0]} if len(first) == 1 else {*zip(*first)}) == len(self.lines)  # noqa: B905

    def __len__(self) -> int:
        return len(self.lines)

    def __iter__(self) -> Iterator[Statement]:
        if self._made is None:
            name, block, found = self.keyword, self.block, zip(self.rows(), self.lines, self.places, strict=True)
            self._made = [Statement(name, row, block, line, place) for row, line, place in found]
        return iter(self._made)

    def __getitem__(self, index: Any) -> Any:
        return (self._made or [*self])[index]


def grouped(statements: Iterable[Statement]) -> list[StatementGroup]:
    """All statements as groups of those that follow each other."""
    alike = groupby(statements, lambda s: (s.keyword, s.block, len(s.values)))
    return [StatementGroup.of(*group) for _, group in alike]
