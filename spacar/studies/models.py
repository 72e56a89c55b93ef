"""Other models of the same mechanism: rigid beams, beams without the non-linear strain terms.

Finer models are made by `spacar.deck.finer`.
"""

from __future__ import annotations

from collections.abc import Iterable

from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.divide import beam_modes
from spacar.deck.finer import flexible_beams
from spacar.deck.statement import Value
from spacar.errors import UsageError

Row = tuple[Value, ...]


def rigid(deck: Deck, beams: Iterable[int] = ()) -> Deck:
    """The mechanism with all dynamic deformations of its beams (of these, when some are named) fixed: DYNE of beams and
    what belongs to it left out.

    Raises UsageError when none of them has a dynamic deformation.
    """
    named = set(beams)
    modes = {n: {m for m, c in found.items() if c == "DYNE"} for n, found in beam_modes(deck.statements).items()}
    stiff = {n for n, fixed in modes.items() if fixed and (not named or n in named)}
    if not stiff:
        raise UsageError(f"{deck.source} has no beam with dynamic deformations (DYNE)", "study.rigid")
    free = {n for n, found in beam_modes(deck.statements).items() if set(found.values()) - {"DYNE"}}

    def keep(s: Statement) -> bool:
        if not s.values or s.values[0] not in stiff:
            return True
        if s.keyword in ("DYNE", "STARTDE"):
            return False
        return s.keyword not in ("ESTIFF", "EDAMP", "ESIG", "LDEFORM") or s.values[0] in free

    held = [("FIX", node) for node in _free_warping(deck, stiff - free)]
    return _with(deck, [s for s in deck.statements if keep(s)], held, "rigid")


def _free_warping(deck: Deck, rigid: set[int]) -> list[int]:
    """Warping nodes that only rigid beams use and no statement gives a class to: they must be fixed."""
    used: dict[int, bool] = {}
    for s in deck.of(*ELEMENT_TYPES, block=1):
        for place in ELEMENT_TYPES[s.keyword].warping:
            node = s.integer(1 + place)
            used[node] = used.get(node, True) and s.integer(0) in rigid
    given = {s.values[0] for s in deck.of("FIX", "INPUTX", "DYNX", "KINX", block=1)}
    return [node for node, only in used.items() if only and node not in given]


def linear_strain(deck: Deck) -> Deck:
    """The mechanism with LDEFORM for every flexible beam. Raises UsageError when there is none that has not got it."""
    have = {s.integer(0) for s in deck.of("LDEFORM", block=1)}
    rows = [("LDEFORM", n) for n in flexible_beams(deck) if n not in have]
    if not rows:
        raise UsageError(f"{deck.source} has no flexible beam with non-linear strain terms", "study.linear")
    return _with(deck, deck.statements, rows, "LDEFORM")


def _with(deck: Deck, statements: Iterable[Statement], more: Iterable[Row], what: str) -> Deck:
    blocks: list[list[Row]] = [[], [], []]
    for s in statements:
        blocks[s.block - 1].append((s.keyword, *s.values))
    blocks[0] += more
    return Deck.build(*blocks, mode=deck.mode, source=f"{deck.source} ({what})", path=deck.path)
