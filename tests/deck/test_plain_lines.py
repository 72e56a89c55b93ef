"""A plain line (a keyword with ordinary numbers) means what its words mean when they are taken one by one."""

import re
from pathlib import Path

import pytest

from spacar.deck import lexer, parse_deck
from spacar.errors import InputError

DATA = Path(__file__).parents[2] / "data"
FILES = sorted(DATA.glob("*.dat"))
MISTAKES = [
    "PLBEAM 1 1 2 3 4\nX 3 1. 0. 0.\nFIX 1\nDYNE 1 7\nDYNE 2 1\nX 9 1. 0.\nX 3 1e80 1e-90\nEND HALT\n"
    "ESTIFF 1 1. 2. 0. 0.\nEND END",
    "PLBEAM 1 1 2 3 4\nPLBEAM 1 1 2 3. 4.5\nFIX 1 1 1\nTIMESTEP 1 10\nEND\nHALT\nX 3 1 0\nESTIFF 1.5 2\nEND\nHALT\nEND",
    "PLBEAM 0 1 2 3 4\nPLBEAM 99999999 1 2 3\nX 3 1 0\n2.5\nFIX\n1\nEND FIX 2\nHALT\nXM 3 -1.\nVISUALIZATION\nX 1",
]  # fmt: skip


def read(text):
    try:
        deck = parse_deck(text)
    except InputError as error:
        return [str(m) for m in error.messages]
    rows = [
        (s.keyword, s.values, [type(v) for v in s.values], s.block, s.line, s.lines, s.columns) for s in deck.statements
    ]
    return rows, deck.spans, deck.visualization, [str(m) for m in deck.messages]


@pytest.mark.parametrize(
    "text", [p.read_text("utf-8", "replace") for p in FILES] + MISTAKES, ids=[p.stem for p in FILES] + ["a", "b", "c"]
)
def test_plain_lines_are_their_words(text, monkeypatch):
    plain = read(text)
    monkeypatch.setattr(lexer, "_PLAIN", re.compile(r"(?!)"))
    assert read(text) == plain


WORDS = ["1", "+1.", ".5", "-1.5e-79", "1E+79", "999999999999999.00000000000000000001e79", "0.e5"]


@pytest.mark.parametrize("word", WORDS)
def test_ordinary_numbers_are_in_range(word):
    """What the pattern of plain lines takes `float` reads, and has a size that can be computed with."""
    assert lexer._PLAIN.match(f"X {word}")
    assert float(word) == lexer.number_of(word)
    assert lexer.is_in_range(float(word), word)
