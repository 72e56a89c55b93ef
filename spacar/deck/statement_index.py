"""Statements by keyword and block, in file order: what the checks of a deck and everybody behind it look them up in."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain, groupby

from spacar.deck.statement import Statement

Group = list[Statement]
"""Statements that follow each other, with the same keyword, block and number of values; never empty."""


def grouped(statements: Iterable[Statement]) -> list[Group]:
    """All statements as groups."""
    return [list(group) for _, group in groupby(statements, lambda s: (s.keyword, s.block, len(s.values)))]


class StatementIndex:
    """The statements of a deck as groups in file order, and where those of each keyword are."""

    def __init__(self, groups: Sequence[Group]) -> None:
        self.groups = groups
        self._found: dict[str, list[tuple[int, int, Group]]] = {}  # place of the group, block, group
        found = self._found
        for place, group in enumerate(groups):
            first = group[0]
            if first.keyword in found:
                found[first.keyword].append((place, first.block, group))
            else:
                found[first.keyword] = [(place, first.block, group)]

    def groups_of(self, *keywords: str, block: int | None = None) -> list[Group]:
        """All groups of one of the keywords (and in the block), in file order."""
        found = self._found
        entries = [entry for keyword in keywords if keyword in found for entry in found[keyword]]
        if len(entries) > 1 and len(keywords) > 1:
            entries.sort()
        return [group for _, b, group in entries if block is None or b == block]

    def of(self, *keywords: str, block: int | None = None) -> list[Statement]:
        """All statements with one of the keywords (and in the block), in file order."""
        groups = self.groups_of(*keywords, block=block)
        return groups[0].copy() if len(groups) == 1 else list(chain.from_iterable(groups))

    def keywords(self, block: int) -> list[str]:
        """Keywords of the statements of a block, in file order."""
        return list(dict.fromkeys([group[0].keyword for group in self.groups if group[0].block == block]))
