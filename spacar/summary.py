"""What decks and results print of themselves in Python: ten lines, not all of their numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from spacar.errors import SpacarError
from spacar.modes import registered

if TYPE_CHECKING:  # decks are read without NumPy
    from spacar.arrays import Array

MOST = 6  # numbers in a line
LINES = 10


def with_picture(text: str, maker: str, thing: Any) -> str:
    """HTML of a text, and the picture that a function of the drawing package makes of a thing, if it can."""
    from html import escape

    page = f'<pre style="font-family: monospace">{escape(text)}</pre>'
    try:
        return page + str(registered(maker)(thing))
    except (ImportError, SpacarError):  # no matplotlib, or nothing that could be drawn
        return page


def counted(n: int, word: str) -> str:
    """As "1 quantity", "2 quantities"."""
    return f"{n} {word}" if n == 1 else f"{n} {word[:-1]}ies" if word.endswith("ty") else f"{n} {word}s"


def few(values: Array) -> str:
    """The first of them that are finite."""
    values = values[abs(values) < float("inf")]
    return ", ".join(f"{v:.6g}" for v in values[:MOST]) + (", ..." if len(values) > MOST else "") or "none"
