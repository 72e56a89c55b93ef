"""Which blocks a mode uses, and of which kind its third block is (reference/input-language.md section 2)."""

from __future__ import annotations

from spacar import modes
from spacar.deck.table_types import BlockKind

Purpose = int | str | None
"""A mode number, "simulation" for the controlled simulation, or None for checking a file without a mode."""


def facts(mode: Purpose) -> modes.Mode | None:
    """The row of the table of modes; None for no mode and for the controlled simulation, which has no row."""
    return modes.MODES.get(mode) if isinstance(mode, int) else None


def third_block(mode: Purpose) -> BlockKind | None:
    """Kind of the third block in this mode, None when the mode does not use it or is not known."""
    if mode == "simulation":
        return BlockKind.SIMULATION
    row = facts(mode)
    return None if row is None or row.third is None else BlockKind[row.third.upper()]


def uses(mode: Purpose, block: int) -> bool:
    """Whether a mode uses block 1, 2 or 3."""
    if mode is None or block == 1:
        return True
    if block == 2:
        row = facts(mode)
        return row is None or row.forces
    return third_block(mode) is not None
