"""Statements of plain lines: ordinary numbers in the number that the keyword takes, read together without looking at
each word.

Most lines of a large model are of this kind. Lines for which a message may be needed give None, and `arguments` reads
them word by word.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from operator import le
from typing import Any

from spacar.deck.lexer import LARGEST_NUMBER
from spacar.deck.outline import Outline
from spacar.deck.raw_statements import PlainLines
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import COORDINATES, Keyword, Parameter, Variant, coordinates_of, subject_of

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
    """The forms that so many ordinary numbers take in such a model; none with names. Several differ in what they are
    about."""
    subject, of_element = subject_of(keyword)
    things: list[tuple[Any, str, str]] = [(role, role, "") for role in COORDINATES]
    if of_element:
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
    """Whether everything that the values of plain lines refer to exists and is of the right kind; `arguments` says what
    does not."""
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
