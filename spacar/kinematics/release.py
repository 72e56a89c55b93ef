"""Over-constraints solved by releases that keep the physics (reference/later-versions.md, constraint analysis).

The deformation with the largest component in the left null space is released, the null space is projected on the
rest, and so on (`diagnosis.pick`); only dynamic deformations are taken. The text of the file is changed: DYNE loses
the mode, RLSE gets it.
"""

from dataclasses import dataclass

from spacar.deck import Deck
from spacar.deck.rewrite.released_text import released
from spacar.kinematics.advice import KEEPS, OverconstraintPart
from spacar.kinematics.diagnosis import Diagnosis, diagnose
from spacar.mechanism import build

ROUNDS = 3
"""One round is enough in exact arithmetic; a second one is for a rank that was decided differently."""


@dataclass(frozen=True)
class Release:
    """deck  after the releases;  parts  what was released;  diagnosis  of that deck;  left  number of over-constraints
    that no flexible deformation can take away."""

    deck: Deck
    parts: tuple[OverconstraintPart, ...]
    diagnosis: Diagnosis

    @property
    def left(self) -> int:
        return self.diagnosis.over


def release(deck: Deck) -> Release:
    """Release flexible deformations until none of the over-constraints is left that they can take away.

    Raises InputError when the deck is wrong. A deck without over-constraints comes back as it is.
    """
    deck = deck.origin or deck
    parts: list[OverconstraintPart] = []
    found = diagnose(build(deck, 0))
    for _ in range(ROUNDS):
        chosen = [p for p in found.advice if p.effect in KEEPS]
        if not chosen:
            break
        parts += chosen
        deck = released(deck, [(p.element, p.mode) for p in chosen])
        found = diagnose(build(deck, 0))
    return Release(deck, tuple(parts), found)
