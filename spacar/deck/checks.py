"""All checks of a deck that need more than one statement, block by block."""

from __future__ import annotations

from spacar.deck.findings import Findings
from spacar.deck.modes import Mode
from spacar.deck.outline import Outline
from spacar.deck.statement import Statement
from spacar.deck.table_types import Block


def check_block(
    block: int,
    statements: tuple[Statement, ...],
    outline: Outline,
    mode: Mode,
    third: Block | None,
    findings: Findings,
    main: Findings,
) -> None:
    """stub during the first minutes"""
