"""A deck of rewritten statements, read and checked as a text: the common end of all programs that rewrite a deck."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from spacar.deck.deck import Deck, parse
from spacar.deck.deck_writer import write_rows
from spacar.deck.statement import Statement, Value

Row = tuple[Value, ...]
KEPT = ("data", "visualization", "drawn", "shorthand", "sections", "divided")


def rebuilt(deck: Deck, *blocks: Iterable[Row], what: str = "") -> Deck:
    """The deck with other statements, rows (keyword, values ...) of each block; `what` follows its name.

    Unit of length, sections, pictures and the digest of the file stay. Raises InputError.
    """
    made = parse(write_rows(blocks), f"{deck.source}{what}", deck.mode, path=deck.path)
    same: dict[str, Any] = {k: getattr(deck, k) for k in KEPT}
    return replace(made, origin=deck.origin or deck, **same)


def rows(statements: Iterable[Statement], *more: Row) -> list[list[Row]]:
    """Those of each block, with some `more` in the first one."""
    blocks: list[list[Row]] = [[], [], []]
    for s in statements:
        blocks[s.block - 1].append((s.keyword, *s.values))
    blocks[0] += more
    return blocks
