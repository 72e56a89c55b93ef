"""The echo of the input in the log: the lines of a block in capitals and without comments."""

from __future__ import annotations

from spacar.deck.deck import Deck
from spacar.deck.lexer import scan

_BLANKS = " \t\r\f\v"


def echo(deck: Deck, block: int) -> list[str]:
    """Lines of block 1, 2 or 3 with its closing END HALT or END END; empty when there is no such block."""
    if block not in deck.spans:
        return []
    start, end = deck.spans[block]
    lines = scan(deck.text).lines[: end[0]]
    if len(lines) == end[0]:
        lines[-1] = lines[-1][: end[1] - 1]
    lines = lines[start[0] - 1 :]
    if lines:
        lines[0] = lines[0][start[1] - 1 :]
    return [bare.upper() for line in lines if (bare := line.strip(_BLANKS))]
