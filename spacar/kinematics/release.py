"""Over-constraints solved by releases that keep the physics (reference/later-versions.md, constraint analysis).

The deformation with the largest component in the left null space is released, the null space is projected on the
rest, and so on (`diagnosis.pick`); only dynamic deformations are taken. The input text is changed as a user would do
it: DYNE loses the mode, RLSE gets it; comments and all other lines stay.
"""

from __future__ import annotations

from dataclasses import dataclass

from spacar.deck import Deck
from spacar.deck.deck import parse
from spacar.deck.lexer import split_lines, word_end
from spacar.kinematics.advice import KEEPS, Edit, OverconstraintPart, edits
from spacar.kinematics.diagnosis import Diagnosis, diagnose
from spacar.kinematics.element_sweep import ElementSweep
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
    parts: list[OverconstraintPart] = []
    found = _diagnose(deck)
    for _ in range(ROUNDS):
        chosen = [p for p in found.advice if p.effect in KEEPS]
        if not chosen:
            break
        parts += chosen
        deck = released(deck, [(p.element, p.mode) for p in chosen])
        found = _diagnose(deck)
    return Release(deck, tuple(parts), found)


def released(deck: Deck, pairs: list[tuple[int, int]]) -> Deck:
    """The deck with these dynamic (element, mode) released, read and checked again."""
    changed, missing = edits(deck, pairs)
    assert not missing, missing
    text = _edited(deck.text, changed)
    return parse(text, deck.source, deck.mode, path=deck.path, visualization=deck.visualization or None)


def _diagnose(deck: Deck) -> Diagnosis:
    mechanism = build(deck, 0)
    sweep = ElementSweep(mechanism)
    sweep.strain(mechanism.x0)
    return diagnose(mechanism, sweep)


def _edited(text: str, changed: list[Edit]) -> str:
    """The text with every DYNE of the edits changed, beginning at the end so that earlier places stay right."""
    mark = "\ufeff" if text.startswith("\ufeff") else ""
    lines = split_lines(text.removeprefix(mark))
    for edit in sorted(changed, key=lambda e: (e.statement.lines[0], e.statement.columns[0]), reverse=True):
        _change(lines, edit)
    return mark + "\n".join(lines)


def _change(lines: list[str], edit: Edit) -> None:
    s = edit.statement
    if not edit.kept:  # the whole statement becomes RLSE; its modes stay
        line = lines[s.line - 1]
        before = s.columns[0] - 1 if s.lines[0] == s.line else len(line)
        at = line.upper().rfind("DYNE", 0, before)
        lines[s.line - 1] = f"{line[:at]}RLSE{line[at + 4 :]}"
        return
    last, start = s.lines[-1] - 1, s.columns[-1] - 1
    old = lines[last]
    end = word_end(old, start)
    follows = old[end:]
    for mark in "%#;":
        follows = follows.partition(mark)[0]
    added = f"RLSE {s.integer(0)} {' '.join(map(str, edit.released))}"
    kept = " " + " ".join(map(str, edit.kept)) if len(s.values) == 1 else ""
    if follows.strip():  # another statement begins on this line
        lines[last] = f"{old[:end]}{kept} {added}{old[end:]}"
    else:
        lines[last] = f"{old[:end]}{kept}{old[end:]}"
        lines.insert(last + 1, added)
    for place in range(1, len(s.values)):
        if s.integer(place) in edit.released:
            row, column = s.lines[place] - 1, s.columns[place] - 1
            text = lines[row]
            stop = word_end(text, column)
            lines[row] = f"{text[:column]}{' ' * (stop - column)}{text[stop:]}"
