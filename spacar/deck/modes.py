"""Which blocks a mode uses, and of which kind its third block is (reference/input-language.md section 2)."""

from __future__ import annotations

from spacar.deck.table_types import Block

Mode = int | str | None
"""A mode number, "simulation" for the controlled simulation, or None for checking a file without a mode."""

_THIRD: dict[int | str, Block] = {
    2: Block.TRAJECTORY,
    3: Block.TRAJECTORY,
    4: Block.LINEARIZATION,
    9: Block.LINEARIZATION,
    "simulation": Block.SIMULATION,
}
HOLONOMIC_ONLY = (2, 3, 8, 10)
"""Modes that do not support wheels."""


def third_block(mode: Mode) -> Block | None:
    """Kind of the third block in this mode, None when the mode does not use it or is not known."""
    return None if mode is None else _THIRD.get(mode)


def uses(mode: Mode, block: int) -> bool:
    """Whether a mode uses block 1, 2 or 3."""
    if mode is None or block == 1:
        return True
    if block == 2:
        return mode != 0
    return mode in _THIRD
