"""Statements before anything is known of their arguments: those of plain lines together, others with their words.

Plain lines have ordinary numbers in the number that the keyword takes; most lines of a large model are of this kind.
They are read together without looking at each word. Lines for which a message may be needed give None, and `arguments`
reads them word by word.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from operator import attrgetter, le
from typing import Any

from spacar.deck.lexer import LARGEST_NUMBER, Word, lines_not_plain, numbers, with_e, words_of
from spacar.deck.outline import Outline
from spacar.deck.statement import StatementGroup
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import COORDINATES, Keyword, Parameter, Variant, coordinates_of


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


NUMBERED_PARTS = ("coordinate", "mode")
_INTEGER = float.__trunc__  # as `int`, which looks at the type of what it is given first


@dataclass(frozen=True, slots=True, eq=False)
class _Form:
    """What statements with a certain number of arguments are like.

    `integers`: the places (from 0) of those that are integers; `named`: how many from the first name an element and its
    nodes; `references`: the places of those that refer to something, whether it is an element, and how many parts it
    has by its type or role, only of those that the statement is for; a dictionary that is None: to the part of it.
    """

    integers: tuple[int, ...]
    named: int
    references: tuple[tuple[int, bool, Mapping[Any, int] | None], ...]


@cache
def _forms(keyword: Keyword, space: str, count: int) -> tuple[_Form, ...]:
    """The forms that so many ordinary numbers take in such a model, none with names; they differ in their subject."""
    subject = keyword.subject
    things: list[tuple[Any, str, str]] = [(role, role, "") for role in COORDINATES]
    if keyword.of_element:
        things = [(kind, "", name) for name, kind in ELEMENT_TYPES.items()]
    if subject is None or subject >= count or keyword.name in ELEMENT_TYPES:
        things = [(None, "", "")]
    about: dict[tuple[Parameter, ...], list[Any]] = {}
    for thing, role, kind in things:
        fitting = (v for v in keyword.variants if v.fits(space, role, kind) and count in v.counts)
        variant: Variant | None = next(fitting, None)
        if variant is not None and all(p.kind != "name" for p in variant.parameters[:count]):
            about.setdefault(variant.parameters[:count], []).append(thing)
    found = []
    for parameters, takers in about.items():
        integers = tuple([i for i, p in enumerate(parameters) if p.kind == "integer"])
        if keyword.name in ELEMENT_TYPES:
            found.append(_Form(integers, 1 + len(ELEMENT_TYPES[keyword.name].nodes), ()))
        else:
            references = _references(parameters, space, subject, takers)
            found.append(_Form(integers, 0, tuple(references)))
    return tuple(found)


def _references(
    parameters: Sequence[Parameter], space: str, subject: int | None, things: list[Any]
) -> Iterator[tuple[int, bool, Mapping[Any, int] | None]]:
    """Those of a form; `things`: the types or roles that its subject may have."""
    modes = {kind: len(kind.modes) for kind in ELEMENT_TYPES.values()}
    coordinates = {role: coordinates_of(role, space == "planar") for role in COORDINATES}
    for i, p in enumerate(parameters):
        if p.of in NUMBERED_PARTS:
            yield i, False, None
        elif p.of == "element" or p.of.endswith("node"):
            parts: Mapping[Any, int] = modes if p.of == "element" else coordinates
            wanted = p.of.removesuffix("node").strip() if p.of != "element" else ""
            fits = [t for t in parts if (i != subject or t in things) and wanted in ("", t)]
            yield i, p.of == "element", {t: parts[t] for t in fits}


def take_plain(lines: PlainLines, keyword: Keyword, outline: Outline) -> bool:
    """Whether nothing about plain lines needs a message; their values are of the kinds that the table says then."""
    count, given = lines.width, lines.values
    values: list[Any]  # of several statements; those of an argument are `values[i::count]`
    for form in _forms(keyword, outline.space, count):
        if len(form.integers) == count:
            values = list(map(_INTEGER, given))
        else:
            values = given.copy()
            for i in form.integers:
                values[i::count] = map(_INTEGER, given[i::count])
        if values == given and (_in_range(values, count, form) if form.named else _known(values, count, form, outline)):
            lines.values = values
            return True
    return False


def _in_range(values: Sequence[Any], count: int, form: _Form) -> bool:
    """Whether the numbers of elements and of their nodes are some that may be used."""
    numbers = values if form.named == count else [n for i in range(form.named) for n in values[i::count]]
    return min(numbers) >= 1 and max(numbers) <= LARGEST_NUMBER


def _known(values: Sequence[Any], count: int, form: _Form, outline: Outline) -> bool:
    """Whether all that the values of plain lines refer to exists and is right; `arguments` says what does not."""
    most: Sequence[Any] = ()  # number of parts of what the value before refers to
    for i, of_element, parts in form.references:
        numbers = values[i::count]
        if parts is not None:
            things: Any = outline.types if of_element else outline.roles
            most = list(map(parts.get, map(things.get, numbers)))
            if None in most:
                return False
        elif most and (min(numbers) < 1 or not all(map(le, numbers, most))):
            return False
    return True
