"""Other models of the same mechanism: finer beams, rigid beams, beams without the non-linear strain terms.

`refine` puts n equal beams in the place of every flexible one, `with_pieces` as many as are wanted in the place of
each; how a beam is divided, and what cannot be, stands in `spacar.deck.divide`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.divide import BEAMS, beam_modes, divided, obstacles, stiffness_modes
from spacar.deck.statement import Value
from spacar.errors import UsageError

Row = tuple[Value, ...]


def flexible_beams(deck: Deck) -> dict[int, dict[int, str]]:
    """Beams with dynamic or prescribed deformations, or released ones that carry stiffness; modes as `beam_modes`."""
    stiff = {n: {m for m, k in of.items() if k} for n, of in stiffness_modes(deck.statements).items()}
    return {
        number: modes
        for number, modes in beam_modes(deck.statements).items()
        if any(c != "RLSE" or m in stiff.get(number, ()) for m, c in modes.items())
    }


def refine(deck: Deck, n: int) -> Deck:
    """The same mechanism with n elements in the place of every flexible beam (1: the deck itself).

    Raises UsageError for n < 1, a model without flexible beams, and one that cannot be split.
    """
    if n < 1:
        raise UsageError(f"a beam is split into 1 or more elements, not {n}", "study.refine")
    split = flexible_beams(deck)
    if not split:
        raise UsageError(f"{deck.source} has no flexible {' or '.join(BEAMS)} to refine", "study.refine")
    if n == 1:
        return deck
    for number, by, reason in obstacles(deck.statements, split, stiffness_modes(deck.statements)):
        if by is not None:
            text = f"{deck.where(by)}: it is about beam {number}, which would be split; {reason}"
            raise UsageError(text, "study.refine")
        raise UsageError(f"beam {number} cannot be split: {reason}", "study.refine")
    return with_pieces(deck, dict.fromkeys(split, n))[0]


def with_pieces(deck: Deck, pieces: Mapping[int, int]) -> tuple[Deck, dict[int, list[int]]]:
    """The mechanism with pieces[beam] equal elements in the place of these beams, which can be divided, and the
    elements that each of them became."""
    blocks: list[list[Row]] = [[], [], []]
    statements, parts = divided(deck.statements, pieces)
    for s in statements:
        blocks[s.block - 1].append((s.keyword, *s.values))
    counts = {n for n in pieces.values() if n > 1}
    what = f" x {counts.pop()}" if len(counts) == 1 else " refined" if counts else ""
    return Deck.build(*blocks, mode=deck.mode, source=f"{deck.source}{what}", path=deck.path), parts


def divisible_beams(deck: Deck) -> tuple[tuple[int, ...], dict[int, str]]:
    """The flexible beams that can be divided, and the reason for each that cannot."""
    flexible = flexible_beams(deck)
    kept: dict[int, str] = {}
    for number, by, reason in obstacles(deck.statements, flexible, stiffness_modes(deck.statements)):
        where = f" ({deck.where(by)})" if by is not None else ""
        kept.setdefault(number, f"{reason}{where}")
    return tuple(n for n in flexible if n not in kept), kept


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
