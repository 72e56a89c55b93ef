"""The input language: text to `Deck`. One table of keywords drives reading, checking, echo and documentation."""

from spacar.deck.deck import Deck, echo, parse_deck, read_deck
from spacar.deck.keyword_table import ELEMENT_TYPES, KEYWORDS, BlockKind, ElementType, coordinates_of
from spacar.deck.statement import Statement

__all__ = [
    "ELEMENT_TYPES", "KEYWORDS", "BlockKind", "Deck", "ElementType", "Statement", "coordinates_of", "echo",
    "parse_deck", "read_deck",
]  # fmt: skip
