"""The elements of a deck by type, as arrays: what numbering and element families are made of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES, Deck
from spacar.deck.table_types import ElementType


class ElementRows(NamedTuple):
    """All elements of one type, sorted by their numbers: the values of the statements, numbers (n,), nodes (n, nodes of
    the type)."""

    kind: ElementType
    values: list[tuple[Any, ...]]
    numbers: Index
    nodes: Index


def element_rows(deck: Deck) -> list[ElementRows]:
    """The elements of every type that a deck has, in the order of the element types."""
    index = deck.index
    found = []
    for keyword in sorted(ELEMENT_TYPES.keys() & index.keywords(1), key=_place):
        kind = ELEMENT_TYPES[keyword]
        values = sorted(index.rows(keyword, 1))  # by their first ones, which no other element has
        first = 1 + len(kind.nodes)
        table = _table([row[:first] for row in values], np.int64)
        found.append(ElementRows(kind, values, table[:, 0], table[:, 1:]))
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


def value_rows(deck: Deck, keyword: str, block: int, kind: Any = float) -> Iterator[tuple[Index, Array]]:
    """First values of statements (n,) and the values behind them (n, count), in file order: a pair of arrays for all
    that follow each other with equally many values."""
    for group in deck.index.groups_of(keyword, block=block):
        table = np.fromiter(group.values, kind, len(group.values)).reshape(-1, group.width)
        yield table[:, 0].real.astype(np.int64), table[:, 1:]
