"""Text to lines and words: comments, columns, the visualization section, the number grammar.

Lexical rules: reference/input-language.md section 1. Most lines of a real file are plain: a keyword with numbers, which
`split` and `float` of Python read as this module does. The others are `odd`: they are taken word by word.
"""

import re
from dataclasses import dataclass
from functools import cached_property
from math import hypot
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
_DIGITS = r"[+-]?(?:[0-9]{1,15}(?:\.[0-9]{0,20})?|\.[0-9]{1,20})"
_ORDINARY = rf"{_DIGITS}(?:[eE][+-]?[0-7]?[0-9])?"
_WITH_D = re.compile(rf"{_DIGITS}[dD][+-]?[0-7]?[0-9]\Z")
_PLAIN = re.compile(rf"[ \t]*[A-Za-z]+(?:[ \t]+{_ORDINARY})*[ \t]*\Z")
# Without these signs (in capitals) and in lines shorter than SHORT what `float` reads is a number of the language,
# infinite or not, and at least 1e-99: separators in numbers and blanks of Python, exponents below zero, words.
_SUSPECT = ("_", "E-", "NAN", "INF", "\x1c", "\x1d", "\x1e", "\x1f")
_SHORT = 100
_VISUALIZATION = "VISUALIZATION"


class Word(NamedTuple):
    """One word with its place; `first` when it is the first of its line, `column` counts from 1."""

    text: str
    line: int
    column: int
    first: bool


@dataclass
class SourceText:
    """The analysis part of a text: its lines without comments, and the numbers of those that are `odd`, not to be read
    by `split` and `float`; the raw lines of the visualization section (None: there is none), and the numbers of lines
    that are too long."""

    lines: list[str]
    odd: set[int]
    visualization: tuple[str, ...] | None
    long_lines: list[int]

    @cached_property
    def words(self) -> list[Word]:
        """All words of the analysis part."""
        return [word for number, line in enumerate(self.lines, 1) for word in words_of(line, number)]


def split_lines(text: str) -> list[str]:
    """Lines of a text with LF, CRLF or CR line ends; other separators that Python knows are not line ends."""
    return _NEWLINE.split(text) if "\r" in text else text.split("\n")


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
    """Split the text into lines; a leading byte order mark is ignored."""
    text = text.removeprefix("\ufeff")
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    given = text.split("\n")
    bare = without_comments(text)
    lines = given if bare is text else bare.split("\n")
    capitals = bare.upper()
    visualization = None
    if _VISUALIZATION in capitals:
        for number, line in enumerate(lines, 1):
            if [word.text.upper() for word in words_of(line, number)[:1]] == [_VISUALIZATION]:
                visualization = tuple(_without_last_blank(given[number:]))
                lines, given = lines[: number - 1], given[: number - 1]
                break
    longest = max(map(len, given), default=0)
    long_lines = []
    if longest > LONGEST_LINE:
        long_lines = [n for n, line in enumerate(given, 1) if len(line) > LONGEST_LINE]
    return SourceText(lines, _odd_lines(lines, capitals, longest), visualization, long_lines)


def without_comments(text: str) -> str:
    """A text, or a line, without its comments; what stands before them keeps its place."""
    for sign in "%#;":
        if sign in text:
            text = re.sub(f"{sign}[^\n]*", "", text)
    return text


def _odd_lines(lines: list[str], capitals: str, longest: int) -> set[int]:
    """The numbers of lines that `split` and `float` of Python may read in another way than this module; `capitals` is
    what the lines, and perhaps others behind them, say in capitals, `longest` the longest line with its comment."""
    suspect: set[int] = set()
    for sign in _SUSPECT:
        if sign not in capitals:
            continue
        line, since, at = 1, 0, capitals.find(sign)
        while at >= 0:
            line += capitals.count("\n", since, at)
            suspect.add(line)
            since, at = at, capitals.find(sign, at + 1)
    if longest >= _SHORT or not capitals.isascii():
        suspect.update([n for n, line in enumerate(lines, 1) if len(line) >= _SHORT or not line.isascii()])
    return {n for n in suspect if n <= len(lines) and _PLAIN.match(lines[n - 1]) is None} if suspect else suspect


def lines_not_plain(words: list[str], lines: list[int]) -> set[int]:
    """Of `lines` with these words, as many in each, those whose words are not all numbers of ordinary size."""
    try:
        numbers(words)
    except ValueError:
        half = len(lines) // 2
        middle = half * len(words) // len(lines)
        if half == 0:
            return {*lines}
        return lines_not_plain(words[:middle], lines[:half]) | lines_not_plain(words[middle:], lines[half:])
    return set()


def numbers(words: list[str]) -> list[float]:
    """Words of lines that are not odd as numbers. Raises ValueError for a word that is none, and for numbers that are
    infinite or so large that not every integer is one."""
    values = list(map(float, words))
    # the length of the vector of all of them, which is soon found, is no smaller than any
    if not hypot(*values) <= LARGEST_INTEGER and not -LARGEST_INTEGER <= min(values) <= max(values) <= LARGEST_INTEGER:
        raise ValueError
    return values


def with_e(words: list[str]) -> list[str]:
    """The words, of which ordinary numbers with d before their exponent have e there, which `float` knows."""
    return [word.lower().replace("d", "e") if _WITH_D.match(word) else word for word in words]


def _without_last_blank(lines: list[str]) -> list[str]:
    """The lines without the empty piece that follows the last line end."""
    return lines[:-1] if lines and not lines[-1] else lines


def visualization_of(text: str) -> tuple[str, ...]:
    """The raw lines of a separate visualization file; a heading line VISUALIZATION is left out."""
    lines = _without_last_blank(split_lines(text.removeprefix("\ufeff")))
    headings = (i for i, line in enumerate(lines, 1) if line.strip().upper() == _VISUALIZATION)
    return tuple(lines[next(headings, 0) :])


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
