"""Statements by keyword and block, in file order: what the checks of a deck and everybody behind it look them up in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, KeysView, Mapping, Sequence
from itertools import chain
from operator import attrgetter
from typing import Any

from spacar.deck.statement import Statement
from spacar.deck.statement_group import StatementGroup


def in_file_order(statements: Iterable[Statement]) -> list[Statement]:
    """Statements that stand in a text; those on one line are in their order."""
    return sorted(statements, key=attrgetter("line"))


class StatementIndex:
    """The statements of a deck as groups, and where those of each keyword are.

    The groups stand in the order of their first statements, those of one keyword and block one behind the other; where
    groups of other keywords are `interleaved` the order of the file is that of the lines.
    """

    def __init__(self, groups: Sequence[StatementGroup], interleaved: bool = False) -> None:
        self.groups, self.interleaved = groups, interleaved
        # groups with their places
        self._found: dict[int, dict[str, list[tuple[int, StatementGroup]]]] = {1: {}, 2: {}, 3: {}}
        self._blocks: dict[int, dict[str, Sequence[Statement]]] = {}
        for place, group in enumerate(groups):
            found = self._found[group.block]
            if group.keyword in found:
                found[group.keyword].append((place, group))
            else:
                found[group.keyword] = [(place, group)]

    def keywords(self, block: int) -> KeysView[str]:
        """Those that a block has statements of."""
        return self._found[block].keys()

    def groups_of(self, *keywords: str, block: int | None = None) -> list[StatementGroup]:
        """All groups of one of the keywords (and in the block), in the order of their first statements."""
        if block is not None and len(keywords) == 1:
            return [group for _, group in self._found[block].get(keywords[0], ())]
        entries: list[tuple[int, StatementGroup]] = []
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
            return [*groups[0]] if groups else []
        found = chain.from_iterable(groups)
        return in_file_order(found) if self.interleaved and len(keywords) > 1 else list(found)

    def rows(self, keyword: str, block: int) -> Iterable[tuple[Any, ...]]:
        """The values of each statement with a keyword in a block, in file order."""
        entries = self._found[block].get(keyword)
        if entries is None:
            return ()
        return entries[0][1].rows() if len(entries) == 1 else chain.from_iterable([g.rows() for _, g in entries])

    def each(self, *keywords: str, block: int) -> Iterator[tuple[StatementGroup, int, tuple[Any, ...]]]:
        """The statements with one of the keywords in a block: a group, the place in it, the values."""
        for group in self.groups_of(*keywords, block=block):
            for place, row in enumerate(group.rows()):
                yield group, place, row

    def statements(self) -> tuple[Statement, ...]:
        """All of them, in file order."""
        found = chain.from_iterable(self.groups)
        return tuple(in_file_order(found) if self.interleaved else found)

    def block(self, number: int) -> Mapping[str, Sequence[Statement]]:
        """Statements of a block by keyword, in file order; only keywords that have any."""
        if number not in self._blocks:
            self._blocks[number] = {
                keyword: entries[0][1] if len(entries) == 1 else [s for _, group in entries for s in group]
                for keyword, entries in self._found[number].items()
            }
        return self._blocks[number]
