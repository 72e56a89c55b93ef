"""The elements of a deck by type, as arrays: what numbering and element families are made of."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, groupby
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.table_types import ElementType

ELEMENT_NUMBER = attrgetter("values")  # its first value, which no other element statement has


class ElementRows(NamedTuple):
    """All elements of one type, sorted by their numbers: statements, numbers (n,), nodes (n, nodes of the type)."""

    kind: ElementType
    statements: list[Statement]
    numbers: Index
    nodes: Index


def element_rows(deck: Deck) -> list[ElementRows]:
    """The elements of every type that a deck has, in the order of the element types."""
    block = deck.block(1)
    found = []
    for keyword in sorted(ELEMENT_TYPES.keys() & block.keys(), key=_place):
        kind = ELEMENT_TYPES[keyword]
        statements = sorted(block[keyword], key=ELEMENT_NUMBER)
        first = 1 + len(kind.nodes)
        table = _table([s.values[:first] for s in statements], np.int64)
        found.append(ElementRows(kind, statements, table[:, 0], table[:, 1:]))
    return found


_place = {keyword: k for k, keyword in enumerate(ELEMENT_TYPES)}.__getitem__


def element_list(deck: Deck) -> list[tuple[int, str, tuple[int, ...]]]:
    """(number, keyword, nodes) of every element statement, in file order."""
    return [
        (s.integer(0), s.keyword, s.integers(1)[: len(ELEMENT_TYPES[s.keyword].nodes)])
        for s in deck.of(*ELEMENT_TYPES, block=1)
    ]


def _table(rows: Sequence[Sequence[Any]], kind: Any) -> Array:
    """Rows with equally many numbers as an array."""
    return np.fromiter(chain.from_iterable(rows), kind, len(rows) * len(rows[0])).reshape(len(rows), -1)


def value_rows(statements: Iterable[Statement], kind: Any = float) -> Iterator[tuple[Index, Array]]:
    """First values of statements (n,) and the values behind them (n, count), in file order: a pair of arrays for all
    that follow each other with equally many values."""
    for _, run in groupby([s.values for s in statements], len):
        table = _table([*run], kind)
        yield table[:, 0].real.astype(np.int64), table[:, 1:]
