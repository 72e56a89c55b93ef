"""The echo of the input in the log: the lines of a block in capitals and without comments."""

from __future__ import annotations

from spacar.deck.deck import Deck
from spacar.deck.lexer import scan, split_lines


def echo(deck: Deck, block: int) -> list[str]:
    """Lines of block 1, 2 or 3 with its closing END HALT or END END; empty when there is no such block."""
    if block not in deck.spans:
        return []
    start, end = deck.spans[block]
    extent: dict[int, tuple[int, int]] = {}
    for word in scan(deck.text).words:
        if start <= (word.line, word.column) < end:
            first = extent.get(word.line, (word.column, 0))[0]
            extent[word.line] = (first, word.column + len(word.text))
    lines = split_lines(deck.text.removeprefix("\ufeff"))
    return [lines[line - 1][first - 1 : last - 1].upper() for line, (first, last) in extent.items()]
