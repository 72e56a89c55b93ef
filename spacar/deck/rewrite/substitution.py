"""A deck with other numbers: the statements of a deck that has been read, with some of their real arguments replaced.

Nothing is read again: a number does not change what the words mean. What a number may be is checked as ever: its size
here, everything else by the checks of a deck (`spacar.deck.deck_checks`). Whatever is unusual (sections, several
statements on a line, a number that is refused, a line that gets too long or fits again) gives None: the text is read,
which says what is wrong.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

from spacar.deck.deck import Deck
from spacar.deck.deck_checks import check
from spacar.deck.deck_writer import value_text
from spacar.deck.findings import Findings
from spacar.deck.lexer import LONGEST_LINE, is_in_range, split_lines, without_comments, word_end
from spacar.deck.outline import Outline
from spacar.deck.statement import Statement, StatementGroup, StatementIndex, Value
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import uses
from spacar.errors import Message

Edit = tuple[Statement, int, float]  # statement of the deck, argument from 1, new value


class _Template:
    def __init__(self, deck: Deck) -> None:
        self.usable = not deck.shorthand and deck.text.isascii()
        self.deck = deck
        self.used = {block for block in (1, 2, 3) if uses(deck.mode, block)}
        self.skipped: list[Message] | None = None
        if not self.usable:
            return
        self.lines = split_lines(deck.text)
        self.place = {id(s): k for k, s in enumerate(deck.statements)}
        self.members = [[self.place[id(s)] for s in group] for group in deck.index.groups]
        self.group = {k: g for g, members in enumerate(self.members) for k in members}
        own = set(self.checked(self.index({})) or ())
        self.read = tuple([m for m in deck.messages if m not in own])  # not those of the checks

    def index(self, changed: Mapping[int, Statement]) -> StatementIndex:
        """The index with other statements at some places; groups without them are those of the deck."""
        given, groups = self.deck.statements, [*self.deck.index.groups]
        for g in {self.group[k] for k in changed}:
            groups[g] = StatementGroup.of(*[changed.get(k, given[k]) for k in self.members[g]])
        return StatementIndex(groups, self.deck.index.interleaved)

    def checked(self, index: StatementIndex) -> list[Message] | None:
        """Messages of the checks, None when there is an error, or another one in a block that the mode skips."""
        outline = Outline(metre=1.0)
        for group in index.groups:
            if group.keyword in ELEMENT_TYPES:
                outline.add(group)
        findings, others = Findings(self.deck.source), Findings(self.deck.source)
        by_block = {block: findings if block in self.used else others for block in (1, 2, 3)}
        check(index, outline, self.deck.mode, self.deck.third, by_block)
        if self.skipped is None:
            self.skipped = others.messages
        return None if findings.errors or others.messages != self.skipped else findings.messages


_template = lru_cache(maxsize=4)(_Template)


def with_numbers(deck: Deck, edits: Sequence[Edit]) -> Deck | None:
    """The deck with these real arguments changed; None where the text has to be read."""
    template = _template(deck)
    if not template.usable:
        return None
    changed, lines = dict[int, Statement](), list(template.lines)
    for s, position, value in edits:
        k = template.place.get(id(s))
        if k is None or s.block not in template.used or not isinstance(s.place, str) or not is_in_range(value, "0"):
            return None
        now = changed.get(k, s)  # another of its arguments may have been changed before
        start = now.columns[position - 1] - 1
        line = lines[s.line - 1]
        line = lines[s.line - 1] = line[:start] + value_text(value) + line[word_end(line, start) :]
        values: tuple[Value, ...] = (*now.values[: position - 1], float(value), *now.values[position:])
        changed[k] = now._replace(values=values, place=without_comments(line))
    for s, _, _ in edits:
        is_long, was_long = (len(of[s.line - 1]) > LONGEST_LINE for of in (lines, template.lines))
        if is_long != was_long:
            return None
    index = template.index(changed)
    messages = template.checked(index)
    if messages is None:
        return None
    text = "\n".join(lines)
    found = sorted((*template.read, *messages), key=lambda m: m.line or 0)
    statements = tuple([changed.get(k, s) for k, s in enumerate(deck.statements)])
    made = replace(deck, statements=statements, text=text, data=text.encode(), messages=tuple(found))
    vars(made)["index"] = index  # the checks have made it
    return made
