"""The keyword table of the input language, assembled: look up a keyword by block, by name, by place in the file."""

from spacar.deck import table_dynamics, table_elements, table_io, table_kinematics, table_solvers
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import BlockKind, ElementType, Keyword, coordinates_of

_TABLES = (table_elements, table_kinematics, table_dynamics, table_solvers, table_io)
_ROWS = tuple(row for table in _TABLES for row in table.KEYWORDS)

KEYWORDS: dict[tuple[str, BlockKind], Keyword] = {(k.name, k.block): k for k in _ROWS}
"""Every keyword of every kind of block."""

ALIASES: dict[str, str] = {alias: k.name for k in _ROWS for alias in k.aliases}
"""Older names of keywords."""

NAME_PLACES = {
    k.name: places
    for k in _ROWS
    if (places := frozenset(i for i, p in enumerate(k.variants[0].parameters) if p.kind == "name"))
}
"""Keyword -> its arguments (from 0) that are one word, whatever it looks like."""

NAMES = {number: {k.name: k.most for k in _ROWS if k.block.number == number} for number in (1, 2, 3)}
"""For each block number the keywords that may stand there, with the largest number of arguments of any form."""


def blocks_of(name: str) -> tuple[BlockKind, ...]:
    """The kinds of block in which a keyword may stand, in the order of the file."""
    return tuple(block for block in BlockKind if (name, block) in KEYWORDS)


def kind_of(block: int, third: BlockKind | None) -> BlockKind:
    """The kind of block 1, 2 or 3 of a deck whose third block is of the given kind."""
    kind = BlockKind.KINEMATICS if block == 1 else BlockKind.DYNAMICS if block == 2 else third
    assert kind is not None
    return kind


def keyword_of(name: str, block: int, third: BlockKind | None) -> Keyword:
    """The row for a statement in block 1, 2 or 3 of a deck whose third block is of the given kind."""
    return KEYWORDS[name, kind_of(block, third)]


__all__ = [
    "ALIASES", "ELEMENT_TYPES", "KEYWORDS", "NAMES", "NAME_PLACES", "BlockKind", "ElementType", "Keyword", "blocks_of",
    "coordinates_of", "keyword_of", "kind_of",
]  # fmt: skip
