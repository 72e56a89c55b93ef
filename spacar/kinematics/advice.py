"""What a release (RLSE) of a deformation does to the model, and where the input file has to change for it.

A released deformation carries the stress of its spring and damper (theory-system.md 1.1, class c). So the release of a
dynamic deformation changes nothing in the physics: its stress law stays, only the choice of the degrees of freedom
differs. A fixed deformation has no such law; releasing it puts a hinge (or a slider) into the model, unless the other
fixed deformations hold it as well (`self_stress`): then the release frees nothing.
"""

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.keyword_table import keyword_of
from spacar.deck.rewrite.references import ELEMENT, places
from spacar.deck.rewrite.released_text import edits
from spacar.kinematics.self_stress import redundancies
from spacar.mechanism.mechanism import Mechanism

# Effects of a release, best first.
FLEXIBLE, FREE, NAMED, PART, REDUNDANT, ELASTIC, HINGE, PRESCRIBED, NONE = range(9)
KEEPS = (FLEXIBLE, FREE)  # what may be released without being asked
WORD, TEXT = zip(
    ("flexible", "flexible, a release keeps the physics"),
    ("free", "free without stiffness, a release keeps the physics"),
    ("named", "flexible, but another statement needs it as DYNE"),
    ("part", "flexible; of a divided beam the last part is released"),
    ("redundant", "rigid, but the rest holds it too: a release frees nothing"),
    ("elastic", "changes the model: rigid becomes flexible (ESTIFF)"),
    ("hinge", "changes the model: a hinge"),
    ("prescribed", "changes the model: it is no longer prescribed"),
    ("none", ""),
    strict=True,
)  # of each of them
SLIDER = "changes the model: a hinge or slider"
SMALL = 1e-6
"""Components of null vectors below this are rounding: their error is at most eps divided by the relative gap
sqrt(eps) between the singular values that count as zero and the others (1.5e-8), times the root of some thousands of
rows."""


@dataclass(frozen=True)
class OverconstraintPart:
    """A deformation in an over-constraint: share (of 1 over all), and the effect of its release. Of a divided beam the
    last part stands for the beam: `element` is what the file calls it."""

    element: int
    mode: int
    share: float
    effect: int
    name: str

    @property
    def text(self) -> str:
        if self.effect == HINGE and any(w in self.name for w in ("elongation", "displacement")):
            return SLIDER
        return TEXT[self.effect]


def full_deck(deck: Deck) -> Deck:
    """The deck with its dynamics block, which mode 0 leaves aside."""
    if 2 in deck.spans and not any(s.block == 2 for s in deck.statements):
        return deck.for_mode(deck.mode)
    return deck


def coefficient(statement: Statement | None, keyword: str, mode: int) -> float:
    """The value that ESTIFF or EDAMP gives to a mode of an element type."""
    places = ELEMENT_TYPES[keyword].stiffness
    return statement.real(places[mode - 1] - 1) if statement is not None and mode <= len(places) else 0.0


def effects(mechanism: Mechanism, rows: Index, x: Array | None) -> tuple[Array, Array]:
    """Effect of the release of each of the rows, and the redundancies among the fixed rows alone.

    rows (n,) are the fixed, input and dynamic deformations, in this order from 0 on; x (nx,) is the configuration,
    None for that of reference. Returns (n,) and (n, k).
    """
    numbering = mechanism.numbering
    deck = full_deck(mechanism.deck)
    stiff = {s.integer(0): s for s in deck.of("ESTIFF", block=2)}
    named = _named(deck)
    fixed = numbering.e_class["fixed"]
    found_rigid = redundancies(mechanism, rows[: fixed.stop], x)
    held = np.zeros((len(rows), found_rigid.shape[1]))
    held[: fixed.stop] = found_rigid
    redundant = np.linalg.norm(held, axis=1) > SMALL
    inner = {part for parts in mechanism.deck.divided.values() for part in parts[:-1]}
    found = np.full(len(rows), NONE)
    for k, i in enumerate(rows.tolist()):
        element, mode = numbering.e_owner(i)
        if element <= 0:
            continue
        c = coefficient(stiff.get(element), numbering.keyword[element], mode)
        if i >= numbering.e_class["dynamic"].start:
            found[k] = PART if element in inner else NAMED if (element, mode) in named else FLEXIBLE if c else FREE
        elif i >= fixed.stop:
            found[k] = PRESCRIBED
        else:
            found[k] = REDUNDANT if redundant[k] else ELASTIC if c != 0.0 else HINGE
    return found, held


def _named(deck: Deck) -> set[tuple[int, int]]:
    """(element, mode) that statements of the later blocks name as dynamic: start values, inputs, references."""
    found: set[tuple[int, int]] = set()
    for s in deck.statements:
        if s.block == 1:
            continue
        keyword = keyword_of(s.keyword, s.block, deck.third)
        if not keyword.classes or "calculable" in keyword.classes:
            continue
        if s.keyword == "STARTDE" and not any(s.reals(2, 2)):
            continue  # zero: the reference configuration, also when released
        found.update((s.integer(i), s.integer(i + 1)) for i, of in places(s) if of == ELEMENT)
    return found


def paste_lines(deck: Deck, parts: list[OverconstraintPart]) -> list[str]:
    """Lines for the input file that release these deformations, those that do not keep the physics with a comment."""
    changed, rest = edits(deck, [(p.element, p.mode) for p in parts])
    of = {(p.element, p.mode): p for p in parts}
    lines = []
    for edit in changed:
        s = edit.statement
        old = " ".join(str(v) for v in s.values)
        lines += [f"% in place of DYNE {old} (line {s.line}):", *edit.lines]
    for pair in rest:
        part = of[pair]
        if part.effect == PRESCRIBED:
            lines.append(f"% in place of INPUTE {part.element} {part.mode}:")
        lines.append(f"RLSE {part.element} {part.mode}   % {part.text}")
    return lines
