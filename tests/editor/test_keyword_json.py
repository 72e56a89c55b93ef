"""The table for editors, and the grammar made of it: every keyword has its colour, in every example model."""

import json
import re

import pytest
from spacar_cli.commands.keywords import command
from spacar_cli.keyword_help import keywords_json, textmate_grammar

from spacar.deck import parse_deck
from spacar.deck.keyword_table import ALIASES, ELEMENT_TYPES, KEYWORDS
from tests.command_line import call
from tests.examples import DATA

PATTERNS = [(re.compile(p["match"]), p["name"]) for p in textmate_grammar()["patterns"]]


def scope_of(line: str, at: int) -> str:
    """The scope that an editor gives to the word at a place: that of the pattern that matches first."""
    place = 0
    while place <= at:
        found = [(m.start(), k, m) for k, (p, _) in enumerate(PATTERNS) if (m := p.search(line, place))]
        if not found:
            return ""
        start, k, match = min(found, key=lambda f: f[:2])
        if start <= at < match.end():
            return str(PATTERNS[k][1])
        place = max(match.end(), place + 1)
    return ""


def test_every_keyword_is_in_the_table_and_has_a_colour():
    table = keywords_json()
    assert set(table["keywords"]) == {name for name, _ in KEYWORDS}
    for name in (*table["keywords"], *ALIASES):
        wanted = "entity.name.type" if name in ELEMENT_TYPES else "keyword.other"
        for line in (f"{name} 1 2", f"  {name.lower()} 1", name, f"{name}% so"):
            assert scope_of(line, line.upper().index(name)) == f"{wanted}.spacar", line
        assert scope_of(f"{name}Q 1", 0) == ""
    assert scope_of("END", 0) == "keyword.control.spacar"
    assert scope_of("X 1 -1.5d-3 % 2", 4) == "constant.numeric.spacar"
    assert scope_of("X 1 2 % FIX 3", 9) == "comment.line.spacar"


@pytest.mark.parametrize("name", ["crank", "leafguide", "robotinvlin"])
def test_statements_of_a_model_are_what_the_reader_reads(name):
    """The same words are keywords, read by the program and coloured by the grammar."""
    text = (DATA / f"{name}.dat").read_text("utf-8")
    deck = parse_deck(text)
    lines = text.splitlines()
    for s in (*deck.statements, *deck.shorthand):
        if s.columns:  # it stands in the file
            line = lines[s.line - 1].upper()
            assert scope_of(lines[s.line - 1], line.index(s.keyword)).startswith(("entity", "keyword.other"))


def test_the_command_prints_both():
    assert command.name == "keywords"
    for kind, made in (("json", keywords_json()), ("textmate", textmate_grammar())):
        out = call.done("keywords", "--to", kind).out
        assert json.loads(out) == json.loads(json.dumps(made))
    assert call("keywords", "FIX", "--to", "json")[0] == 2
