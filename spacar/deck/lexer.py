"""Text to words: lines, comments, columns, the visualization section, the number grammar.

Lexical rules: reference/input-language.md section 1.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

LONGEST_LINE = 160
SMALLEST_REAL, LARGEST_REAL = 1e-100, 1e100
"""Sizes of reals other than zero: squares, and products with such numbers, are still numbers."""
LARGEST_NUMBER = 1_000_000
"""Node and element numbers are row numbers of result arrays, so a slip of the keyboard must not cost gigabytes."""

_WORD = re.compile(r"[^\s%#;]+", re.ASCII)
_COMMENT = re.compile(r"[%#;]")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?\Z")
_NEWLINE = re.compile(r"\r\n|\r|\n")
# A keyword and numbers of ordinary form: their sizes are in range, `int` and `float` read them as `number_of` does.
_ORDINARY = r"[+-]?(?:[0-9]{1,15}(?:\.[0-9]{0,20})?|\.[0-9]{1,20})(?:[eE][+-]?[0-7]?[0-9])?"
_PLAIN = re.compile(rf"[ \t]*([A-Za-z]+)((?:[ \t]+{_ORDINARY})*)[ \t]*(?:[%#;].*)?\Z")
_VISUALIZATION = "VISUALIZATION"


class Word(NamedTuple):
    """One word with its place; `first` when it is the first of its line, `column` counts from 1."""

    text: str
    line: int
    column: int
    first: bool


class Plain(NamedTuple):
    """A line that is one keyword (in capitals) with numbers of ordinary form, which is what most lines are."""

    keyword: str
    numbers: list[str]
    line: int
    text: str

    @property
    def words(self) -> list[Word]:
        return words_of(self.text, self.line)


@dataclass
class SourceText:
    """The lines of the analysis part, a plain line as it is and any other as its words; the raw lines of the
    visualization section (None: there is none), the numbers of lines that are too long, and that of the last line
    of the analysis part."""

    rows: list[Plain | list[Word]]
    visualization: tuple[str, ...] | None
    long_lines: list[int]
    last_line: int

    @cached_property
    def words(self) -> list[Word]:
        """All words of the analysis part."""
        return [word for row in self.rows for word in (row.words if isinstance(row, Plain) else row)]


def split_lines(text: str) -> list[str]:
    """Lines of a text with LF, CRLF or CR line ends; other separators that Python knows are not line ends."""
    return _NEWLINE.split(text)


def words_of(line: str, number: int) -> list[Word]:
    """The words of one line without its comment."""
    comment = _COMMENT.search(line)
    found = _WORD.finditer(line, 0, comment.start() if comment else len(line))
    return [Word(m.group(), number, m.start() + 1, i == 0) for i, m in enumerate(found)]


def word_end(line: str, start: int) -> int:
    """Where the word that begins at `start` of a line ends, both counted from 0; `start` where no word begins."""
    word = _WORD.match(line, start)
    return word.end() if word else start


def columns_of(line: str) -> tuple[int, ...]:
    """Where the words of one line begin, from 1."""
    return tuple([word.column for word in words_of(line, 0)])


def scan(text: str) -> SourceText:
    """Split the text into lines and words; a leading byte order mark is ignored."""
    lines = split_lines(text.removeprefix("\ufeff"))
    rows: list[Plain | list[Word]] = []
    long_lines: list[int] = []
    for number, line in enumerate(lines, 1):
        plain = _PLAIN.match(line)
        if plain is not None:
            keyword, numbers = plain.groups()
            row: Plain | list[Word] = Plain(keyword.upper(), numbers.split(), number, line)
            first = keyword
        else:
            row = words_of(line, number)
            first = row[0].text if row else ""
        if len(first) == len(_VISUALIZATION) and first.upper() == _VISUALIZATION:
            return SourceText(rows, tuple(_without_last_blank(lines[number:])), long_lines, number - 1)
        if first:
            rows.append(row)
        if len(line) > LONGEST_LINE:
            long_lines.append(number)
    return SourceText(rows, None, long_lines, len(lines))


def _without_last_blank(lines: list[str]) -> list[str]:
    """The lines without the empty piece that follows the last line end."""
    return lines[:-1] if lines and not lines[-1] else lines


def visualization_of(text: str) -> tuple[str, ...]:
    """The raw lines of a separate visualization file; a heading line VISUALIZATION is left out."""
    lines = _without_last_blank(split_lines(text.removeprefix("\ufeff")))
    for i, line in enumerate(lines):
        if line.strip().upper() == _VISUALIZATION:
            return tuple(lines[i + 1 :])
    return tuple(lines)


def number_of(text: str) -> float | None:
    """Value of a real of the input language, None when the word is not one (nan, inf, comma, ...)."""
    if _NUMBER.match(text) is None:
        return None
    return float(text.replace("d", "e").replace("D", "e"))


def is_in_range(value: float, text: str) -> bool:
    """Whether a real has a size that can be computed with; `text` tells a zero from a number that is too small."""
    if value == 0.0:
        return not re.search(r"[1-9]", re.split(r"[eEdD]", text)[0])
    return SMALLEST_REAL <= abs(value) <= LARGEST_REAL


def integer_of(text: str) -> int | None:
    """Value of an integer; an integral real such as `3.` or `1e2` is accepted, other words give None."""
    value = number_of(text)
    if value is None or not value.is_integer() or abs(value) > 2.0**53:
        return None
    return int(value)
