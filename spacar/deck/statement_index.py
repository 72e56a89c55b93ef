"""Statements by keyword and block, in file order: what the checks of a deck and everybody behind it look them up in."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain, groupby
from operator import attrgetter

from spacar.deck.statement import Statement

Group = list[Statement]
"""Statements with the same keyword, block and number of values in the order of the file; never empty."""


def in_file_order(statements: Iterable[Statement]) -> list[Statement]:
    """Statements that stand in a text; those on one line are in their order."""
    return sorted(statements, key=attrgetter("line"))


def grouped(statements: Iterable[Statement]) -> list[Group]:
    """All statements as groups of those that follow each other."""
    return [list(group) for _, group in groupby(statements, lambda s: (s.keyword, s.block, len(s.values)))]


class StatementIndex:
    """The statements of a deck as groups, and where those of each keyword are.

    The groups stand in the order of their first statements, those of one keyword and block one behind the other; where
    groups of other keywords are `interleaved` the order of the file is that of the lines.
    """

    def __init__(self, groups: Sequence[Group], interleaved: bool = False) -> None:
        self.groups, self.interleaved = groups, interleaved
        self._blocks: dict[int, dict[str, list[Statement]]] = {}
        self._found: dict[str, list[tuple[int, int, Group]]] = {}  # place of the group, block, group
        found = self._found
        for place, group in enumerate(groups):
            first = group[0]
            if first.keyword in found:
                found[first.keyword].append((place, first.block, group))
            else:
                found[first.keyword] = [(place, first.block, group)]

    def groups_of(self, *keywords: str, block: int | None = None) -> list[Group]:
        """All groups of one of the keywords (and in the block), in the order of their first statements."""
        found = self._found
        if found.keys().isdisjoint(keywords):
            return []
        if len(keywords) == 1:
            entries = found[keywords[0]]
        else:
            entries = sorted([entry for keyword in keywords if keyword in found for entry in found[keyword]])
        return [group for _, b, group in entries if block is None or b == block]

    def of(self, *keywords: str, block: int | None = None) -> list[Statement]:
        """All statements with one of the keywords (and in the block), in file order."""
        found = chain.from_iterable(self.groups_of(*keywords, block=block))
        return in_file_order(found) if self.interleaved and len(keywords) > 1 else list(found)

    def block(self, number: int) -> Mapping[str, Sequence[Statement]]:
        """Statements of a block by keyword, in file order; only keywords that have any."""
        if number not in self._blocks:
            found = self._blocks[number] = {}
            for group in self.groups:
                keyword = group[0].keyword
                if group[0].block != number:
                    continue
                if keyword in found:
                    found[keyword] += group
                else:
                    found[keyword] = group.copy()
        return self._blocks[number]
