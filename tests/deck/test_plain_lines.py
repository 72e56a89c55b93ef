"""A plain line (a keyword with ordinary numbers) means what its words mean when they are taken one by one."""

import re
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spacar.deck import deck_reader, lexer, parse_deck
from spacar.deck.arguments import read_statement
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


REALS = ["1.e5", "+.5", "1d3", "1D-2", "00012", "1e400", "-1e-400", "0.e5", "1e80", "1e-90", ".", "1..2", "-", "nan"]
ORDINARY = ["0", "1", "2", "3", "4", "5", "6", "+1", "-1", "0.", "1.", "-2.5", "3.", "1e0"]
NUMBER = st.sampled_from(ORDINARY * 3 + REALS)
GAP = st.sampled_from([" "] * 5 + ["\t", " \t ", "\v", "\f", "\x1c", "\u00a0"])
BEHIND = st.sampled_from([""] * 5 + [" ", "\t", "%", "% note", "#1 2", " ; X 1 2", ";", "\x1c", "\u00a0"])
KEYWORD = st.sampled_from([
    "PLBEAM", "PLTRUSS", "HINGE", "PLTUBE", "X", "FIX", "INPUTX", "DYNX", "DYNE", "KINX", "RLSE", "LDEFORM", "XM", "EM",
    "ESTIFF", "XF", "GRAVITY", "TIMESTEP", "ERROR", "STARTDE", "INPUTE", "OUTLEVEL", "END", "HALT", "END HALT", "x",
    "END END", "end", "plbeam", "USERSIG", "SECTION", "NONE", "VISUALIZATION",
])  # fmt: skip


@st.composite
def odd_line(draw):
    words = [draw(KEYWORD), *draw(st.lists(NUMBER, max_size=7))]
    gaps = [draw(GAP) for _ in words[1:]]
    line = draw(st.sampled_from(["", "", " ", "\t", "\x1c"])) + words[0]
    return line + "".join(gap + word for gap, word in zip(gaps, words[1:], strict=True)) + draw(BEHIND)


START = ["PLBEAM 1 1 2 3 4", "PLBEAM 2 3 4 5 6", "X 3 1. 0.", "X 5 2. 0."]
TEXT = st.builds(
    lambda before, one, two, three, newline: newline.join(
        [*before, *one, "END HALT", *two, *(["END HALT", *three] if three else []), "END END", ""]
    ),
    st.sampled_from([START, [], ["HINGE 7 8 9", *START]]),
    *[st.lists(odd_line(), max_size=n) for n in (6, 5, 2)],
    st.sampled_from(["\n", "\n", "\r\n", "\r"]),
)


def odd_lines_are_their_words(text):
    """Every single statement, also of a file that is refused."""

    def both():
        statements = []

        def recorded(*arguments):
            s = read_statement(*arguments)
            statements.append(s and (*s[:5], [type(v) for v in s.values], s.columns))
            return s

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(deck_reader, "read_statement", recorded)
            return read(text), statements

    plain = both()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lexer, "_PLAIN", re.compile(r"(?!)"))
        assert both() == plain


def every_ordinary_number_is_read_alike(word):
    """`float` and `int` read a word of the pattern as the number grammar does, or `int` refuses it."""
    assert lexer.is_in_range(float(word), word)
    assert float(word) == lexer.number_of(word)
    with suppress(ValueError):
        assert int(word) == lexer.integer_of(word)


# many examples in the slow tests, the first of them in the fast ones
TRIED = settings(deadline=None, database=None, derandomize=True)
few_odd, odd = (settings(TRIED, max_examples=n)(given(TEXT)(odd_lines_are_their_words)) for n in (50, 1500))
NUMBERS = st.from_regex(lexer._ORDINARY, fullmatch=True)
few, many = (settings(TRIED, max_examples=n)(given(NUMBERS)(every_ordinary_number_is_read_alike)) for n in (30, 1000))
test_odd_lines_are_their_words, test_many_odd_lines_are_their_words = few_odd, pytest.mark.slow(odd)
test_every_ordinary_number_is_read_alike, test_many_ordinary_numbers = few, pytest.mark.slow(many)
