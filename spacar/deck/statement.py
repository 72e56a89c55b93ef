"""The statement, a keyword with its typed values and their places; statements by keyword and block, in file order.

Those of one keyword are columns; a statement is made when somebody asks for it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, KeysView, Mapping, Sequence
from itertools import chain, groupby, repeat
from operator import attrgetter
from typing import Any, NamedTuple

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

    def line_of(self, index: int | None) -> int:
        """That of the value at `index` (from 0); None, or a value that was left out: of the keyword."""
        return self.line if index is None or index >= len(self.lines) else self.lines[index]

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

    def reals(self, start: int, count: int) -> tuple[float, ...]:
        """`count` values from `start`, zero for those that were left out."""
        given = tuple(map(number, self.values[start : start + count]))
        return given + (0.0,) * (count - len(given))


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


def in_file_order(statements: Iterable[Statement]) -> list[Statement]:
    """Statements that stand in a text; those on one line are in their order."""
    return sorted(statements, key=attrgetter("line"))


def again(keyed: Iterable[tuple[object, Statement]]) -> Iterator[tuple[Statement, Statement]]:
    """Of statements with keys those whose key an earlier one has, each with the first that has it."""
    given: dict[object, Statement] = {}
    for key, s in keyed:
        first = given.setdefault(key, s)
        if first is not s:
            yield s, first


class StatementIndex:
    """The statements of a deck as groups, and where those of each keyword are.

    The groups stand in the order of their first statements, those of one keyword and block one behind the other; where
    groups of other keywords are `interleaved` the order of the file is that of the lines.
    """

    def __init__(self, groups: Sequence[StatementGroup], interleaved: bool = False) -> None:
        self.groups, self.interleaved = groups, interleaved
        # groups with their places
        self._found: dict[int, dict[str, list[tuple[int, StatementGroup]]]] = {1: {}, 2: {}, 3: {}}
        self._blocks: dict[int, dict[str, Sequence[Statement]]] = {}
        for place, group in enumerate(groups):
            self._found[group.block].setdefault(group.keyword, []).append((place, group))

    def keywords(self, block: int) -> KeysView[str]:
        """Those that a block has statements of."""
        return self._found[block].keys()

    def groups_of(self, *keywords: str, block: int | None = None) -> list[StatementGroup]:
        """All groups of one of the keywords (and in the block), in the order of their first statements."""
        blocks = self._found.values() if block is None else (self._found[block],)
        entries = [entry for found in blocks for keyword in keywords if keyword in found for entry in found[keyword]]
        return [group for _, group in sorted(entries)]

    def of(self, *keywords: str, block: int | None = None) -> list[Statement]:
        """All statements with one of the keywords (and in the block), in file order."""
        found = chain.from_iterable(self.groups_of(*keywords, block=block))
        return in_file_order(found) if self.interleaved and len(keywords) > 1 else list(found)

    def rows(self, keyword: str, block: int) -> Iterable[tuple[Any, ...]]:
        """The values of each statement with a keyword in a block, in file order."""
        return chain.from_iterable([group.rows() for _, group in self._found[block].get(keyword, ())])

    def each(self, *keywords: str, block: int) -> Iterator[tuple[StatementGroup, int, tuple[Any, ...]]]:
        """The statements with one of the keywords in a block: a group, the place in it, the values."""
        for group in self.groups_of(*keywords, block=block):
            for place, row in enumerate(group.rows()):
                yield group, place, row

    def statements(self) -> tuple[Statement, ...]:
        """All of them, in file order."""
        found = chain.from_iterable(self.groups)
        return tuple(in_file_order(found) if self.interleaved else found)

    def block(self, number: int) -> Mapping[str, Sequence[Statement]]:
        """Statements of a block by keyword, in file order; only keywords that have any."""
        if number not in self._blocks:
            self._blocks[number] = {
                keyword: entries[0][1] if len(entries) == 1 else [s for _, group in entries for s in group]
                for keyword, entries in self._found[number].items()
            }
        return self._blocks[number]
