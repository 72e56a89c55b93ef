"""Statements of plain lines: ordinary numbers in the number that the keyword takes, read together without looking at
each word.

Most lines of a large model are of this kind. Lines for which a message may be needed give None, and `arguments` reads
them word by word.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import repeat
from operator import le
from typing import Any

from spacar.deck.lexer import LARGEST_NUMBER
from spacar.deck.outline import Outline
from spacar.deck.raw_statements import PlainLines
from spacar.deck.statement import Statement
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import COORDINATES, Keyword, Parameter, coordinates_of, subject_of

NUMBERED_PARTS = ("coordinate", "mode")
ELEMENT, NODE, PART = range(3)  # what a value refers to
_STATEMENT = partial(tuple.__new__, Statement)  # of its five fields, without a call of Python for each


@dataclass(frozen=True, slots=True)
class _Form:
    """A form of a statement with a certain number of arguments: the places (from 0) of those that are integers, and of
    those that refer to something, with what that is (ELEMENT, NODE or PART), of nodes the role that is asked for, and
    whether a part of it follows.
    """

    integers: tuple[int, ...]
    references: tuple[tuple[int, int, str, bool], ...]


@cache
def _form(keyword: Keyword, space: str, role: str, kind: str, count: int) -> _Form | None:
    """The form that so many ordinary numbers take, None when there is none or when it has names."""
    for variant in keyword.variants:
        if variant.fits(space, role, kind) and count in variant.counts:
            parameters = variant.parameters[:count]
            if any(p.kind == "name" for p in parameters):
                return None
            integers = tuple([i for i, p in enumerate(parameters) if p.kind == "integer"])
            return _Form(integers, tuple(_references(parameters)))
    return None


@cache
def _same_form(keyword: Keyword, space: str, count: int) -> _Form | None:
    """The form that so many numbers take whatever node or element they are about, None when it depends on that."""
    _, of_element = subject_of(keyword)
    if of_element:
        forms = {_form(keyword, space, "", kind, count) for kind in ELEMENT_TYPES}
    else:
        forms = {_form(keyword, space, role, "", count) for role in COORDINATES}
    return forms.pop() if len(forms) == 1 else None


def _references(parameters: Sequence[Parameter]) -> Iterator[tuple[int, int, str, bool]]:
    with_part = False
    found = []
    for i, p in reversed(list(enumerate(parameters))):
        if p.of in NUMBERED_PARTS:
            with_part = True
            found.append((i, PART, "", False))
        elif p.of == "element" or p.of.endswith("node"):
            what = ELEMENT if p.of == "element" else NODE
            found.append((i, what, p.of.removesuffix("node").strip() if what == NODE else "", with_part))
            with_part = False
    return reversed(found)


def plain_statements(lines: PlainLines, keyword: Keyword, outline: Outline) -> list[Statement] | None:
    """The statements of plain lines when nothing about any of them needs a message, else None."""
    element, count, values = ELEMENT_TYPES.get(lines.keyword), lines.count - 1, lines.values
    form = _same_form(keyword, "" if element else outline.space, count) or _form_of(lines, keyword, outline)
    if form is None:
        return None
    columns: list[Any] = [values[i::count] for i in range(count)]  # of several statements, by argument
    for i in form.integers:
        given = columns[i]
        columns[i] = numbers = list(map(int, given))
        if numbers != given:
            return None
    if element is not None:
        for numbers in columns[: 1 + len(element.nodes)]:
            if min(numbers) < 1 or max(numbers) > LARGEST_NUMBER:
                return None
    elif form.references and not _known(columns, form, outline):
        return None
    rows = zip(*columns, strict=True) if count else repeat(())
    parts = zip(repeat(lines.keyword), rows, repeat(lines.block), lines.lines, lines.texts)
    return list(map(_STATEMENT, parts))


def _form_of(lines: PlainLines, keyword: Keyword, outline: Outline) -> _Form | None:
    """The form of statements about nodes and elements that exist; None when it is not the same for all."""
    subject, of_element = subject_of(keyword)
    count = lines.count - 1
    if subject is None or subject >= count:
        return _form(keyword, outline.space, "", "", count)
    about: list[Any] = lines.values[subject::count]  # 3. finds what is known as 3
    if of_element:
        kinds = set(map(outline.types.get, about))
        forms = [_form(keyword, outline.space, "", kind.keyword, count) if kind else None for kind in kinds]
    else:
        roles = set(map(outline.roles.get, about))
        forms = [_form(keyword, outline.space, role, "", count) if role else None for role in roles]
    return forms[0] if len(forms) == 1 or all(form == forms[0] for form in forms) else None


def _known(columns: Sequence[Sequence[int]], form: _Form, outline: Outline) -> bool:
    """Whether everything that the values of plain lines refer to exists; `arguments` says what does not."""
    most: Sequence[int] = ()  # number of parts of what the value before refers to
    for i, what, wanted, with_part in form.references:
        numbers = columns[i]
        if what == PART:
            if most and (min(numbers) < 1 or not all(map(le, numbers, most))):
                return False
        elif what == ELEMENT:
            kinds = list(map(outline.types.get, numbers))
            if None in kinds:
                return False
            most = [len(kind.modes) for kind in kinds if kind] if with_part else ()
        else:
            roles = list(map(outline.roles.get, numbers))
            if None in roles or (wanted and roles.count(wanted) < len(roles)):
                return False
            if with_part:
                planar = outline.space == "planar"
                most = [coordinates_of(role, planar) for role in roles if role]
            else:
                most = ()
    return True
