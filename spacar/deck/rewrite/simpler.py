"""Other models of the same mechanism: rigid beams, beams without the non-linear strain terms.

Finer models are made by `spacar.deck.rewrite.refine`.
"""

from __future__ import annotations

from collections.abc import Iterable

from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.deck import rebuilt
from spacar.deck.deck_writer import rows
from spacar.deck.rewrite.divide import beam_modes
from spacar.deck.rewrite.references import about
from spacar.deck.rewrite.refine import flexible_beams
from spacar.errors import UsageError


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
        beam = about(s)
        if beam not in stiff or s.keyword not in ("DYNE", "STARTDE", "ESTIFF", "EDAMP", "ESIG", "LDEFORM"):
            return True
        return s.keyword not in ("DYNE", "STARTDE") and beam in free

    held = [("FIX", node) for node in _free_warping(deck, stiff - free)]
    return rebuilt(deck, *rows(filter(keep, deck.statements), *held), what=" (rigid)")


def _free_warping(deck: Deck, rigid: set[int]) -> list[int]:
    """Warping nodes that only rigid beams use and no statement gives a class to: they must be fixed."""
    used: dict[int, bool] = {}
    for s in deck.of(*ELEMENT_TYPES, block=1):
        for place in ELEMENT_TYPES[s.keyword].warping:
            node = s.integer(1 + place)
            used[node] = used.get(node, True) and s.integer(0) in rigid
    given = {s.integer(0) for s in deck.of("FIX", "INPUTX", "DYNX", "KINX", block=1)}
    return [node for node, only in used.items() if only and node not in given]


def linear_strain(deck: Deck) -> Deck:
    """The mechanism with LDEFORM for every flexible beam. Raises UsageError when there is none that has not got it."""
    have = {s.integer(0) for s in deck.of("LDEFORM", block=1)}
    more = [("LDEFORM", n) for n in flexible_beams(deck) if n not in have]
    if not more:
        raise UsageError(f"{deck.source} has no flexible beam with non-linear strain terms", "study.linear")
    return rebuilt(deck, *rows(deck.statements, *more), what=" (LDEFORM)")
