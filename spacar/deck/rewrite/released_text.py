"""RLSE in the place of DYNE, in the text of a file as a user would do it: comments and all other lines stay.

The statements are those that stand in the file: of a beam that BEAMSEC or a refinement divides its own, which hold for
all its parts; its RLSE makes the deformations of the last part follow (`divide`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

from spacar.deck.deck import Deck, parse
from spacar.deck.deck_reader import read_text
from spacar.deck.lexer import split_lines, word_end
from spacar.deck.statement import Statement
from spacar.deck.table_elements import ELEMENT_TYPES

Pair = tuple[int, int]  # element and mode


def written(deck: Deck) -> tuple[Statement, ...]:
    """The statements that stand in the file of the deck."""
    deck = deck.origin or deck
    return read_text(deck.text, deck.source, deck.mode).given.statements() if deck.shorthand else deck.statements


def released(deck: Deck, pairs: Sequence[Pair]) -> Deck:
    """The deck of the file with these dynamic (element, mode) released, read and checked again."""
    deck = deck.origin or deck
    changed, missing = edits(deck, pairs)
    assert not missing, missing
    mark = "\ufeff" if deck.text.startswith("\ufeff") else ""
    lines = split_lines(deck.text.removeprefix(mark))
    for edit in sorted(changed, key=lambda e: (e.statement.lines[0], e.statement.columns[0]), reverse=True):
        _change(lines, edit)  # beginning at the end, so that earlier places stay right
    text = mark + "\n".join(lines)
    return parse(text, deck.source, deck.mode, path=deck.path, visualization=deck.written_visualization or None)


@dataclass(frozen=True)
class Edit:
    """A DYNE statement that loses the modes `released` and keeps the modes `kept`."""

    statement: Statement
    kept: tuple[int, ...]
    released: tuple[int, ...]

    @property
    def lines(self) -> list[str]:
        given = self.statement.values
        if not self.kept:
            return [f"RLSE {' '.join(map(str, given))}"]
        both = (("DYNE", self.kept), ("RLSE", self.released))
        return [" ".join(map(str, (word, given[0], *modes))) for word, modes in both]


def edits(deck: Deck, pairs: Sequence[Pair]) -> tuple[list[Edit], list[Pair]]:
    """The DYNE statements that change when these (element, mode) are released, and the pairs that no DYNE names."""
    wanted, found = set(pairs), []
    statements = [s for s in written(deck) if s.block == 1]
    kinds = {s.integer(0): ELEMENT_TYPES[s.keyword] for s in statements if s.keyword in ELEMENT_TYPES}
    for s in statements:
        if s.keyword != "DYNE":
            continue
        element = s.integer(0)
        modes = tuple(dict.fromkeys(s.integers(1))) or kinds[element].classed
        released = tuple(m for m in modes if (element, m) in wanted)
        if released:
            found.append(Edit(s, tuple(m for m in modes if m not in released), released))
    done = {(e.statement.integer(0), m) for e in found for m in e.released}
    return found, [pair for pair in pairs if pair not in done]


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
