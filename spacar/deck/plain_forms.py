"""Statements of plain lines: ordinary numbers in the number that the keyword takes, read without looking at each word.

Most lines of a large model are of this kind. A line for which a message may be needed gives None, and `arguments` reads
it word by word.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from spacar.deck.lexer import LARGEST_NUMBER, Plain
from spacar.deck.outline import Outline
from spacar.deck.splitter import Raw
from spacar.deck.statement import Statement, Value
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import Keyword

NUMBERED_PARTS = ("coordinate", "mode")

_CONVERT: dict[str, Callable[[str], Value]] = {"integer": int, "real": float}


@dataclass(frozen=True, slots=True)
class _Form:
    """A form of a statement with a certain number of arguments: what converts each of them, and the places (from 0) of
    those that refer to something, with what that is (`Parameter.of`)."""

    convert: tuple[Callable[[str], Value], ...]
    references: tuple[tuple[int, str], ...]


@cache
def _form(keyword: Keyword, space: str, role: str, kind: str, count: int) -> _Form | None:
    """The form that so many ordinary numbers take, None when there is none or when it has names."""
    for variant in keyword.variants:
        if variant.fits(space, role, kind) and count in variant.counts:
            parameters = variant.parameters[:count]
            if any(p.kind not in _CONVERT for p in parameters):
                return None
            references = [(i, p.of) for i, p in enumerate(parameters) if p.of]
            return _Form(tuple([_CONVERT[p.kind] for p in parameters]), tuple(references))
    return None


def plain_statement(raw: Raw, keyword: Keyword, whose: tuple[str, str, str], outline: Outline) -> Statement | None:
    """The statement of a plain line when nothing about it needs a message, else None."""
    texts, line = raw.texts, raw.line
    form = _form(keyword, *whose, len(texts))
    if form is None:
        return None
    try:
        values = tuple([convert(text) for convert, text in zip(form.convert, texts, strict=True)])
    except ValueError:  # an integer with a point
        return None
    assert isinstance(raw.given, Plain)
    statement = Statement(raw.keyword, values, raw.block, line, (line,) * len(values), raw.given.text)
    if raw.keyword in ELEMENT_TYPES:
        numbers = statement.integers()[: 1 + len(ELEMENT_TYPES[raw.keyword].nodes)]
        return statement if min(numbers) >= 1 and max(numbers) <= LARGEST_NUMBER else None
    return statement if _known(statement.integers(), form, outline) else None


def _known(values: tuple[int, ...], form: _Form, outline: Outline) -> bool:
    """Whether everything that the values of a plain line refer to exists; `arguments` says what does not."""
    most = 0
    for i, of in form.references:
        number = values[i]
        if of == "element":
            if number not in outline.types:
                return False
            most = outline.modes(number)
        elif of.endswith("node"):
            role = outline.roles.get(number)
            if role is None or (of != "node" and of != f"{role} node"):
                return False
            most = outline.coordinates(number)
        elif of in NUMBERED_PARTS and most and not 1 <= number <= most:
            return False
    return True
