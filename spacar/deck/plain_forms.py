"""Statements of plain lines: ordinary numbers in the number that the keyword takes, read without looking at each word.

Most lines of a large model are of this kind. A line for which a message may be needed gives None, and `arguments` reads
it word by word.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from spacar.deck.lexer import LARGEST_NUMBER, Plain
from spacar.deck.outline import Outline
from spacar.deck.splitter import Raw
from spacar.deck.statement import Statement, Value
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import Keyword, Parameter, subject_of

NUMBERED_PARTS = ("coordinate", "mode")
ELEMENT, NODE, PART = range(3)  # what a value refers to

_CONVERT: dict[str, Callable[[str], Value]] = {"integer": int, "real": float}


@dataclass(frozen=True, slots=True)
class _Form:
    """A form of a statement with a certain number of arguments: what converts each of them, and the places (from 0) of
    those that refer to something, with what that is (ELEMENT, NODE or PART) and, of nodes, the role that is asked for.
    """

    convert: tuple[Callable[[str], Value], ...]
    references: tuple[tuple[int, int, str], ...]


@cache
def _form(keyword: Keyword, space: str, role: str, kind: str, count: int) -> _Form | None:
    """The form that so many ordinary numbers take, None when there is none or when it has names."""
    for variant in keyword.variants:
        if variant.fits(space, role, kind) and count in variant.counts:
            parameters = variant.parameters[:count]
            if any(p.kind not in _CONVERT for p in parameters):
                return None
            return _Form(tuple([_CONVERT[p.kind] for p in parameters]), tuple(_references(parameters)))
    return None


def _references(parameters: Sequence[Parameter]) -> Iterator[tuple[int, int, str]]:
    for i, p in enumerate(parameters):
        if p.of == "element":
            yield i, ELEMENT, ""
        elif p.of.endswith("node"):
            yield i, NODE, p.of.removesuffix("node").strip()
        elif p.of in NUMBERED_PARTS:
            yield i, PART, ""


def plain_statement(raw: Raw, row: Plain, keyword: Keyword, outline: Outline) -> Statement | None:
    """The statement of a plain line when nothing about it needs a message, else None."""
    texts, name, line = raw.texts, raw.keyword, raw.line
    element = ELEMENT_TYPES.get(name)
    role = kind = ""
    try:
        if element is None:
            subject, of_element = subject_of(keyword)
            if subject is not None and subject < len(texts):
                number = int(texts[subject])
                if of_element:
                    kind = outline.types[number].keyword
                else:
                    role = outline.roles[number]
        form = _form(keyword, outline.space if element is None else "", role, kind, len(texts))
        if form is None:
            return None
        values: tuple[Any, ...] = tuple([convert(text) for convert, text in zip(form.convert, texts, strict=True)])
    except (ValueError, KeyError):  # an integer with a point; what does not exist
        return None
    if element is not None:
        numbers = values[: 1 + len(element.nodes)]
        if min(numbers) < 1 or max(numbers) > LARGEST_NUMBER:
            return None
    elif not _known(values, form, outline):
        return None
    return Statement(name, values, raw.block, line, (line,) * len(values), row.text)


def _known(values: Sequence[int], form: _Form, outline: Outline) -> bool:
    """Whether everything that the values of a plain line refer to exists; `arguments` says what does not."""
    most = 0
    for i, what, wanted in form.references:
        number = values[i]
        if what == PART:
            if most and not 1 <= number <= most:
                return False
        elif what == ELEMENT:
            if number not in outline.types:
                return False
            most = outline.modes(number)
        else:
            role = outline.roles.get(number)
            if role is None or (wanted and wanted != role):
                return False
            most = outline.coordinates(number)
    return True
