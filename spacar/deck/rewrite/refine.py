"""Other models of the same mechanism: with n beams in the place of every flexible one, or as many as are wanted in the
place of each; with rigid beams; with beams without the non-linear strain terms. How a beam is divided, and what cannot
be, stands in `spacar.deck.rewrite.divide`.

Tubes are not divided: a curved one would have to be divided along its arc (TUBE, PLTUBE).
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from spacar.deck.deck import Deck, rebuilt
from spacar.deck.deck_writer import rows
from spacar.deck.rewrite.divide import BEAMS, beam_modes, divided, obstacles, stiffness_modes
from spacar.deck.rewrite.references import about
from spacar.deck.statement import Statement
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.errors import UsageError

TUBES = tuple(k for k, t in ELEMENT_TYPES.items() if t.shape == "beam" and not t.split)
UNDIVIDED = "a tube is not divided; write more of them"


def flexible_beams(deck: Deck) -> dict[int, dict[int, str]]:
    """Beams with dynamic or prescribed deformations, or released ones that carry stiffness; modes as `beam_modes`."""
    return _flexible(deck, BEAMS)


def _flexible(deck: Deck, keywords: Iterable[str]) -> dict[int, dict[int, str]]:
    stiff = {n: {m for m, k in of.items() if k} for n, of in stiffness_modes(deck.statements).items()}
    return {
        number: modes
        for number, modes in beam_modes(deck.statements, keywords).items()
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


def refine_divisible(deck: Deck, n: int) -> tuple[Deck, dict[int, str]]:
    """The mechanism with n elements in the place of every flexible beam that can be divided, and why others cannot be.

    Raises UsageError for n < 1, and when there is no beam to divide.
    """
    if n < 1:
        raise UsageError(f"a beam is split into 1 or more elements, not {n}", "study.refine")
    beams, kept = divisible_beams(deck)
    if n == 1:
        return deck, {}
    if not beams:
        why = "; ".join(f"beam {b}: {text}" for b, text in kept.items()) or "none is flexible"
        raise UsageError(f"{deck.source} has no beam that can be divided ({why})", "study.refine")
    return with_pieces(deck, dict.fromkeys(beams, n))[0], kept


def with_pieces(deck: Deck, pieces: Mapping[int, int]) -> tuple[Deck, dict[int, list[int]]]:
    """The mechanism with pieces[beam] equal elements in the place of these beams, which can be divided, and the
    elements that each of them became. Unit of length, sections, pictures and the digest of the file stay."""
    statements, parts = divided(deck.statements, pieces)
    counts = {n for n in pieces.values() if n > 1}
    what = f" x {counts.pop()}" if len(counts) == 1 else " refined" if counts else ""
    return with_parts(rebuilt(deck, *rows(statements), what=what), parts), parts


def with_parts(deck: Deck, parts: Mapping[int, Sequence[int]]) -> Deck:
    """The deck, whose beams have become these parts in its statements, with what it knows of its beams."""

    def finer(old: Sequence[int]) -> tuple[int, ...]:
        return tuple(part for beam in old for part in parts.get(beam, (beam,)))

    before = deck.divided
    new = {n: tuple(of) for n, of in parts.items() if not any(n in of for of in before.values())}
    whole = {n: finer(of) for n, of in before.items()} | new
    return replace(deck, sections=tuple(replace(s, parts=finer(s.parts)) for s in deck.sections), divided=whole)


def divisible_beams(deck: Deck) -> tuple[tuple[int, ...], dict[int, str]]:
    """The flexible beams that can be divided, and the reason for each that cannot, flexible tubes among them."""
    flexible = flexible_beams(deck)
    kept: dict[int, str] = {}
    for number, by, reason in obstacles(deck.statements, flexible, stiffness_modes(deck.statements)):
        where = f" ({deck.where(by)})" if by is not None else ""
        kept.setdefault(number, f"{reason}{where}")
    beams = tuple(n for n in flexible if n not in kept)
    return beams, kept | dict.fromkeys(_flexible(deck, TUBES), UNDIVIDED)


def rigid(deck: Deck, beams: Iterable[int] = ()) -> Deck:
    """The mechanism with all dynamic deformations of its beams (of these, when some are named) fixed: DYNE of beams and
    what belongs to it left out.

    Raises UsageError when none of them has a dynamic deformation.
    """
    named = set(beams)
    classes = {n: set(found.values()) for n, found in beam_modes(deck.statements).items()}
    stiff = {n for n, found in classes.items() if "DYNE" in found and (not named or n in named)}
    if not stiff:
        raise UsageError(f"{deck.source} has no beam with dynamic deformations (DYNE)", "study.rigid")
    free = {n for n, found in classes.items() if found - {"DYNE"}}

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
