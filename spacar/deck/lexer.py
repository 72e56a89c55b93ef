"""Text to words: lines, comments, columns, the visualization section, the number grammar.

Lexical rules: reference/input-language.md section 1.
"""

from __future__ import annotations

import re
from typing import NamedTuple

LONGEST_LINE = 160
SMALLEST_REAL, LARGEST_REAL = 1e-100, 1e100
"""Sizes of reals other than zero: squares, and products with such numbers, are still numbers."""
LARGEST_NUMBER = 1_000_000
"""Node and element numbers are row numbers of result arrays, so a slip of the keyboard must not cost
gigabytes."""

_WORD = re.compile(r"[^\s%#;]+", re.ASCII)
_COMMENT = re.compile(r"[%#;]")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?\Z")
_NEWLINE = re.compile(r"\r\n|\r|\n")
_VISUALIZATION = "VISUALIZATION"


class Word(NamedTuple):
    """One word with its place; `first` when it is the first of its line, `column` counts from 1."""

    text: str
    line: int
    column: int
    first: bool


class SourceText(NamedTuple):
    """The words of the analysis part, the raw lines of the visualization section (None: there is none), line
    numbers of lines that are too long, and the last line of the analysis part."""

    words: list[Word]
    visualization: tuple[str, ...] | None
    long_lines: list[int]
    last_line: int


def split_lines(text: str) -> list[str]:
    """Lines of a text with LF, CRLF or CR line ends; other separators that Python knows are not line ends."""
    return _NEWLINE.split(text)


def scan(text: str) -> SourceText:
    """Split the text into words; a leading byte order mark is ignored."""
    lines = split_lines(text.removeprefix("\ufeff"))
    words: list[Word] = []
    long_lines: list[int] = []
    for number, line in enumerate(lines, 1):
        comment = _COMMENT.search(line)
        end = comment.start() if comment else len(line)
        first = True
        for match in _WORD.finditer(line, 0, end):
            word = match.group()
            if first and len(word) == len(_VISUALIZATION) and word.upper() == _VISUALIZATION:
                return SourceText(words, tuple(_without_last_blank(lines[number:])), long_lines, number - 1)
            words.append(Word(word, number, match.start() + 1, first))
            first = False
        if len(line) > LONGEST_LINE:
            long_lines.append(number)
    return SourceText(words, None, long_lines, len(lines))


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
