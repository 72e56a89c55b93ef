"""Statements before anything is known of their arguments: those of plain lines together, others with their words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from operator import attrgetter

from spacar.deck.lexer import Word, lines_not_plain, numbers, with_e, words_of
from spacar.deck.statement_group import StatementGroup


@dataclass(slots=True, eq=False)
class Raw:
    """A statement whose arguments are still words."""

    keyword: str
    block: int
    line: int
    words: list[Word] = field(default_factory=list)


class PlainLines(StatementGroup):
    """Plain lines with one keyword (its name) and as many words in each, in the order of the file.

    `values` are all the words, until `Split.convert` makes numbers of those behind the keywords; `places`: what the
    lines say, without comments.
    """

    __slots__ = ()
    places: list[str]  # type: ignore[assignment]

    @property
    def line(self) -> int:
        """That of the first."""
        return self.lines[0]

    def part(self, start: int, end: int) -> PlainLines:
        """Some of the lines, of which the words are numbers already."""
        found, width = PlainLines(self.keyword, self.block, self.width), self.width
        found.values = self.values[start * width : end * width]
        found.lines, found.places = self.lines[start:end], self.places[start:end]
        return found

    def pop(self) -> tuple[Raw, set[int]]:
        """Take the last line off: as a statement of its own, and its number if it is not plain."""
        first, line = len(self.values) - self.width, self.lines.pop()
        odd = lines_not_plain(self.values[first:], [line])
        del self.values[first - 1 :]
        return Raw(self.keyword, self.block, line, words_of(self.places.pop(), line)[1:]), odd


def raws_of(lines: PlainLines) -> Iterator[Raw]:
    """The statements of plain lines, one by one."""
    for line, text in zip(lines.lines, lines.places, strict=True):
        yield Raw(lines.keyword, lines.block, line, words_of(text, line)[1:])


@dataclass(slots=True, eq=False)
class Split:
    """All statements, as plain lines or with their words, and, for each block that was opened, where its text begins
    and ends (line, column); `strangers` are refused words with what follows them. Where plain lines are `interleaved`
    the order of the file is that of the lines of the statements, and of those on one line the order here. `odd`: lines
    that were taken as plain and are not."""

    statements: list[PlainLines | Raw] = field(default_factory=list)
    interleaved: bool = False
    odd: set[int] = field(default_factory=set)
    strangers: list[Raw] = field(default_factory=list)
    spans: dict[int, tuple[tuple[int, int], tuple[int, int]]] = field(default_factory=dict)

    def convert(self) -> None:
        """Make the words of all plain lines numbers; lines of which they are none are `odd` then."""
        words: list[str] = []
        plain = [part for part in self.statements if isinstance(part, PlainLines)]
        for part in plain:
            del part.values[:: part.width + 1]
            words += part.values
        try:
            values = numbers(words)
        except ValueError:
            try:
                values = numbers(with_e(words))
            except ValueError:
                for part in plain:
                    self.odd |= lines_not_plain(part.values, part.lines)
                return
        end = 0
        for part in plain:
            start, end = end, end + len(part.values)
            part.values = values[start:end]

    @property
    def raws(self) -> list[Raw]:
        """The statements with their words, in the order of the file."""
        found = [raw for s in self.statements for raw in (raws_of(s) if isinstance(s, PlainLines) else (s,))]
        return sorted(found, key=attrgetter("line"))
