"""Text to words: lines, comments, columns, the visualization section, the number grammar.

Lexical rules: reference/input-language.md section 1. Most lines of a real file are plain: a keyword with numbers of
ordinary size. Those with the same keyword and as many numbers that follow each other become one `PlainLines`, whose
numbers are read together; every other line is taken word by word.
"""

from __future__ import annotations

import re
from collections.abc import Container
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import NamedTuple

LONGEST_LINE = 160
SMALLEST_REAL, LARGEST_REAL = 1e-100, 1e100
"""Sizes of reals other than zero: squares, and products with such numbers, are still numbers."""
LARGEST_NUMBER = 1_000_000
"""Node and element numbers are row numbers of result arrays, so a slip of the keyboard must not cost gigabytes."""
LARGEST_INTEGER = 2.0**53
"""Beyond it not every integer is a number of double precision."""

_WORD = re.compile(r"[^\s%#;]+", re.ASCII)
_COMMENT = re.compile(r"[%#;]")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?\Z")
_NEWLINE = re.compile(r"\r\n|\r|\n")
# A keyword and numbers that `float` reads as `number_of` does and that are not too small, whatever their exponents.
_ORDINARY = r"[+-]?(?:[0-9]{1,15}(?:\.[0-9]{0,20})?|\.[0-9]{1,20})(?:[eE][+-]?[0-7]?[0-9])?"
_PLAIN = re.compile(rf"[ \t]*[A-Za-z]+(?:[ \t]+{_ORDINARY})*[ \t]*\Z")
# Without these signs and in lines shorter than SHORT what `float` reads is a number of the input language, infinite, no
# number, or at least 1e-99: separators in numbers and blanks of Python, exponents below zero.
_SUSPECT = ("_", "e-", "E-", "\x1c", "\x1d", "\x1e", "\x1f")
_SHORT = 100
_VISUALIZATION = "VISUALIZATION"


class Word(NamedTuple):
    """One word with its place; `first` when it is the first of its line, `column` counts from 1."""

    text: str
    line: int
    column: int
    first: bool


class PlainLines:
    """Plain lines with one keyword (in capitals) and as many numbers in each, in the order of the file.

    `columns`: the numbers, one list for every argument; `lines`: where the lines stand; `texts`: what they say, without
    comments; `block`: set by who divides the file into blocks.
    """

    __slots__ = ("block", "columns", "keyword", "lines", "texts")

    def __init__(self, keyword: str, columns: list[list[float]], lines: list[int], texts: list[str]) -> None:
        self.keyword = keyword
        self.columns = columns
        self.lines = lines
        self.texts = texts
        self.block = 0

    @property
    def line(self) -> int:
        """That of the first."""
        return self.lines[0]

    def append(self, more: PlainLines) -> None:
        """Further lines with the same keyword and as many numbers."""
        for column, its in zip(self.columns, more.columns, strict=True):
            column += its
        self.lines += more.lines
        self.texts += more.texts

    def part(self, start: int, end: int) -> PlainLines:
        """Some of the lines."""
        columns = [column[start:end] for column in self.columns]
        found = PlainLines(self.keyword, columns, self.lines[start:end], self.texts[start:end])
        found.block = self.block
        return found

    def words(self) -> list[list[Word]]:
        """The words of every line."""
        return list(map(words_of, self.texts, self.lines))


@dataclass
class SourceText:
    """The lines of the analysis part, plain ones together and any other as its words; the raw lines of the
    visualization section (None: there is none), the numbers of lines that are too long, and that of the last line
    of the analysis part."""

    rows: list[PlainLines | list[Word]]
    visualization: tuple[str, ...] | None
    long_lines: list[int]
    last_line: int

    @cached_property
    def words(self) -> list[Word]:
        """All words of the analysis part."""
        found: list[Word] = []
        for row in self.rows:
            for words in row.words() if isinstance(row, PlainLines) else (row,):
                found += words
        return found


def split_lines(text: str) -> list[str]:
    """Lines of a text with LF, CRLF or CR line ends; other separators that Python knows are not line ends."""
    return _NEWLINE.split(text) if "\r" in text else text.split("\n")


def words_of(line: str, number: int) -> list[Word]:
    """The words of one line without its comment."""
    if line.isascii() and line.isalpha():
        return [Word(line, number, 1, True)]
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


_Alike = tuple[list[str], int, list[int], list[str]]  # all words, how many a line has, numbers of the lines, texts


def scan(text: str) -> SourceText:
    """Split the text into lines and words; a leading byte order mark is ignored."""
    text = text.removeprefix("\ufeff")
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    given = text.split("\n")
    bare = without_comments(text)
    lines = given if bare is text else bare.split("\n")
    longest = max(map(len, given))
    suspect = _suspects(bare, lines, longest)
    found: list[_Alike | list[Word]] = []
    visualization, last_line = None, len(given)
    first, count = "", 0
    words: list[str] = []
    numbers: list[int] = []
    alike: list[str] = []
    for number, line in enumerate(lines, 1):
        if number in suspect and _PLAIN.match(line) is None:
            odd = words_of(line, number)
            if odd and _is_visualization(odd[0].text):
                first = _VISUALIZATION
            elif odd:
                found.append(odd)
                first = ""
                continue
            else:
                continue
        else:
            texts = line.split()
            if not texts:
                continue
            if texts[0] == first and len(texts) == count:
                words += texts
                numbers.append(number)
                alike.append(line)
                continue
            first, count, words, numbers, alike = texts[0], len(texts), texts, [number], [line]
        if len(first) == len(_VISUALIZATION) and _is_visualization(first):
            visualization, last_line = tuple(_without_last_blank(given[number:])), number - 1
            break
        found.append((words, count, numbers, alike))
    rows: list[PlainLines | list[Word]] = []
    for row in found:
        if isinstance(row, tuple):
            _add_rows(*row, rows)
        else:
            rows.append(row)
    long_lines = []
    if longest > LONGEST_LINE:
        long_lines = [n for n, line in enumerate(given[:last_line], 1) if len(line) > LONGEST_LINE]
    return SourceText(rows, visualization, long_lines, last_line)


def _is_visualization(word: str) -> bool:
    return len(word) == len(_VISUALIZATION) and word.upper() == _VISUALIZATION


def without_comments(text: str) -> str:
    """A text, or a line, without its comments; what stands before them keeps its place."""
    for sign in "%#;":
        if sign in text:
            text = re.sub(f"{sign}[^\n]*", "", text)
    return text


def _suspects(text: str, lines: list[str], longest: int) -> Container[int]:
    """The numbers of lines that `split` and `float` of Python may read in another way than this module."""
    found: set[int] = set()
    for sign in _SUSPECT:
        line, since, at = 1, 0, text.find(sign)
        while at >= 0:
            line += text.count("\n", since, at)
            found.add(line)
            since, at = at, text.find(sign, at + 1)
    if longest >= _SHORT or not text.isascii():
        found.update([n for n, line in enumerate(lines, 1) if len(line) >= _SHORT or not line.isascii()])
    return found


def _add_rows(
    words: list[str], count: int, numbers: list[int], texts: list[str], rows: list[PlainLines | list[Word]]
) -> None:
    """Add lines of `count` words each, the first of them the same in all: as plain lines, or else as their words."""
    keyword = words[0]
    del words[::count]
    if not words and keyword.isalpha():
        rows.append(PlainLines(keyword.upper(), [], numbers, texts))
        return
    try:
        values = list(map(float, words))
        good = max(values) <= LARGEST_INTEGER and min(values) >= -LARGEST_INTEGER and -inf < sum(values) < inf
    except ValueError:
        good = False
    if good and keyword.isalpha():
        count -= 1
        columns = [values[i::count] for i in range(count)]
        rows.append(PlainLines(keyword.upper(), columns, numbers, texts))
    elif len(numbers) > 1 and keyword.isalpha():  # the lines around those that are not plain are
        half = len(numbers) // 2
        for part in (slice(half), slice(half, None)):
            again = [word for text in texts[part] for word in text.split()]
            _add_rows(again, count, numbers[part], texts[part], rows)
    else:
        rows += map(words_of, texts, numbers)


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
    if value is None or not value.is_integer() or abs(value) > LARGEST_INTEGER:
        return None
    return int(value)
