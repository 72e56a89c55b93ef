"""The echo of the input in the log: the lines of a block in capitals and without comments."""

from __future__ import annotations

from spacar.deck.deck import Deck
from spacar.deck.lexer import scan, split_lines, words_of


def echo(deck: Deck, block: int) -> list[str]:
    """Lines of block 1, 2 or 3 with its closing END HALT or END END; empty when there is no such block."""
    if block not in deck.spans:
        return []
    start, end = deck.spans[block]
    bare, lines = scan(deck.text).lines, split_lines(deck.text.removeprefix("\ufeff"))
    echoed = []
    for number in range(start[0], min(end[0], len(bare)) + 1):
        words = [w for w in words_of(bare[number - 1], number) if start <= (number, w.column) < end]
        if words:
            last = words[-1].column + len(words[-1].text)
            echoed.append(lines[number - 1][words[0].column - 1 : last - 1].upper())
    return echoed
