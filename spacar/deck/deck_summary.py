"""What a deck prints of itself in Python."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from spacar.deck.keyword_table import ELEMENT_TYPES
from spacar.deck.statement import Statement
from spacar.deck.table_types import Purpose
from spacar.errors import Message
from spacar.summary import LINES


def deck_summary(source: str, mode: Purpose, statements: Sequence[Statement], messages: Sequence[Message]) -> str:
    """Name, mode, elements, what each block holds, messages."""
    elements = Counter(s.keyword for s in statements if s.keyword in ELEMENT_TYPES)
    purpose = "all modes" if mode is None else f"mode {mode}"
    lines = [f"Deck {source}, checked for {purpose}", f"  elements    {_counted(elements)}"]
    for block, name in ((1, "kinematics"), (2, "dynamics"), (3, "third")):
        rest = Counter(s.keyword for s in statements if s.block == block and s.keyword not in ELEMENT_TYPES)
        if rest:
            lines.append(f"  {name:<11} {_counted(rest)}")
    lines += [f"  {message}" for message in messages[: LINES - len(lines)]]
    return "\n".join(lines)


def _counted(found: Counter[str]) -> str:
    words = [f"{n} {name}" if n > 1 else name for name, n in found.most_common()]
    return ", ".join(words[:12]) + (", ..." if len(words) > 12 else "") or "none"
