"""Statements by keyword and block, in file order: what the checks of a deck and everybody behind it look them up in."""

from __future__ import annotations

from collections.abc import Iterable, KeysView, Mapping, Sequence
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
        self._found: dict[int, dict[str, list[tuple[int, Group]]]] = {1: {}, 2: {}, 3: {}}  # groups with their places
        self._blocks: dict[int, dict[str, list[Statement]]] = {}
        for place, group in enumerate(groups):
            first, found = group[0], self._found[group[0].block]
            if first.keyword in found:
                found[first.keyword].append((place, group))
            else:
                found[first.keyword] = [(place, group)]

    def keywords(self, block: int) -> KeysView[str]:
        """Those that a block has statements of."""
        return self._found[block].keys()

    def groups_of(self, *keywords: str, block: int | None = None) -> list[Group]:
        """All groups of one of the keywords (and in the block), in the order of their first statements."""
        if block is not None and len(keywords) == 1:
            return [group for _, group in self._found[block].get(keywords[0], ())]
        entries: list[tuple[int, Group]] = []
        for found in self._found.values() if block is None else (self._found[block],):
            for keyword in keywords:
                if keyword in found:
                    entries += found[keyword]
        if len(entries) > 1:
            entries.sort()
        return [group for _, group in entries] if entries else []

    def of(self, *keywords: str, block: int | None = None) -> list[Statement]:
        """All statements with one of the keywords (and in the block), in file order."""
        groups = self.groups_of(*keywords, block=block)
        if len(groups) < 2:
            return groups[0].copy() if groups else []
        found = chain.from_iterable(groups)
        return in_file_order(found) if self.interleaved and len(keywords) > 1 else list(found)

    def block(self, number: int) -> Mapping[str, Sequence[Statement]]:
        """Statements of a block by keyword, in file order; only keywords that have any."""
        if number not in self._blocks:
            self._blocks[number] = {
                keyword: entries[0][1] if len(entries) == 1 else [s for _, group in entries for s in group]
                for keyword, entries in self._found[number].items()
            }
        return self._blocks[number]
