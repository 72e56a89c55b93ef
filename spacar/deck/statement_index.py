"""Statements by keyword and block, in file order: what the checks of a deck and everybody behind it look them up in."""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter

from spacar.deck.statement import Statement


class StatementIndex:
    """The statements of a deck, and where those of each keyword are."""

    def __init__(self, statements: Sequence[Statement]) -> None:
        self.statements = statements
        self._found: dict[tuple[str, int], list[tuple[int, Statement]]] = {}
        found = self._found
        for pair in enumerate(statements):
            s = pair[1]
            key = s.keyword, s.block
            if key in found:
                found[key].append(pair)
            else:
                found[key] = [pair]

    def of(self, *keywords: str, block: int | None = None) -> list[Statement]:
        """All statements with one of the keywords (and in the block), in file order."""
        blocks, found = (1, 2, 3) if block is None else (block,), self._found
        given = [pairs for keyword in keywords for b in blocks if (pairs := found.get((keyword, b)))]
        if not given:
            return []
        pairs = given[0] if len(given) == 1 else sorted((pair for one in given for pair in one), key=itemgetter(0))
        return [s for _, s in pairs]

    def keywords(self, block: int) -> list[str]:
        """Keywords of the statements of a block, in file order."""
        return [keyword for keyword, b in self._found if b == block]
