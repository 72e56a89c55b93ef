"""Statements by keyword and block, in file order: what the checks of a deck and everybody behind it look them up in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from spacar.deck.statement import Statement


class StatementIndex:
    """The statements of a deck, and those of each keyword of a block."""

    def __init__(self, statements: Sequence[Statement]) -> None:
        self.statements = statements
        self._blocks: dict[int, dict[str, list[Statement]]] = {1: {}, 2: {}, 3: {}}
        for s in statements:
            found = self._blocks[s.block]
            if s.keyword in found:
                found[s.keyword].append(s)
            else:
                found[s.keyword] = [s]

    def block(self, number: int) -> Mapping[str, Sequence[Statement]]:
        """Statements of a block by keyword, in file order; only keywords that have any."""
        return self._blocks[number]

    def of(self, *keywords: str, block: int | None = None) -> list[Statement]:
        """All statements with one of the keywords (and in the block), in file order."""
        blocks = self._blocks.values() if block is None else (self._blocks[block],)
        given = [some[keyword] for some in blocks for keyword in keywords if keyword in some]
        if len(given) <= 1:
            return list(given[0]) if given else []
        return [s for s in self.statements if s.keyword in keywords and block in (None, s.block)]

    def keywords(self, block: int) -> list[str]:
        """Keywords of the statements of a block, in file order."""
        return list(self._blocks[block])
