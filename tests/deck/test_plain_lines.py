"""Plain lines (a keyword with ordinary numbers), read and checked together, mean what their words mean when they are
taken one by one, and each statement is checked on its own."""

import gc
import random
import re
import sys
from contextlib import contextmanager, suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spacar.deck import checks_dynamics, checks_geometry, deck_reader, lexer, outline, parse_deck, splitter
from spacar.errors import InputError
from tests.examples import DATA

FILES = sorted(DATA.glob("*.dat"))
MISTAKES = [
    "PLBEAM 1 1 2 3 4\nX 3 1. 0. 0.\nFIX 1\nDYNE 1 7\nDYNE 2 1\nX 9 1. 0.\nX 3 1e80 1e-90\nEND HALT\n"
    "ESTIFF 1 1. 2. 0. 0.\nEND END",
    "PLBEAM 1 1 2 3 4\nPLBEAM 1 1 2 3. 4.5\nFIX 1 1 1\nTIMESTEP 1 10\nEND\nHALT\nX 3 1 0\nESTIFF 1.5 2\nEND\nHALT\nEND",
    # the last of several plain lines is none, and words that it may take follow
    "PLBEAM 1 1 2 3 4\nX 3 1 0\nFIX 1\nDYNE 1 2\nEND HALT\nXM 3 1.\nXM 1 END\nDYNX 3 2\nEND END",
    "PLBEAM 1 1 2 3 4\nX 3 1 0\nFIX 1\nFIX 2 ONE\nDYNE 1 2\nFIX 3 1D0\nFIX 4 1e99\nEND HALT\nXM 3 NaN\nEND END",
    "PLBEAM 0 1 2 3 4\nPLBEAM 99999999 1 2 3\nX 3 1 0\n2.5\nFIX\n1\nEND FIX 2\nHALT\nXM 3 -1.\nVISUALIZATION\nX 1",
]  # fmt: skip


def words_of(line, number):
    """The words of a line, found in another way than the lexer does."""
    found = [lexer.Word(m[0], number, m.start() + 1, False) for m in re.finditer(r"[^ \t\v\f%#;]+|[%#;].*", line)]
    return [w._replace(first=i == 0) for i, w in enumerate(found) if w.text[0] not in "%#;"]


def by_words(text):
    """A text without plain lines, for `lexer.scan`."""
    given = re.split("\r\n|\r|\n", text.removeprefix("\ufeff"))
    count = len(given)
    for number, line in enumerate(given, 1):
        words = words_of(line, number)
        if words and words[0].text.upper() == "VISUALIZATION":
            count = number - 1
            break
    rest = None if count == len(given) else given[count + 1 :]
    if rest and not rest[-1]:
        rest.pop()
    long = [number for number, line in enumerate(given[:count], 1) if len(line) > 160]
    return lexer.SourceText(given[:count], set(range(1, count + 1)), rest if rest is None else tuple(rest), long)


@contextmanager
def one_by_one():
    """Every statement is read by its words, and checked without a look at others like it."""
    add = outline.Outline.add

    def irregular(self, statements):
        add(self, statements)
        self.regular = False

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(deck_reader, "scan", by_words)
        patch.setattr(lexer, "words_of", words_of)
        patch.setattr(splitter, "words_of", words_of)
        patch.setattr(outline.Outline, "add", irregular)
        patch.setattr(checks_geometry, "_ordinary", lambda *_: False)
        patch.setattr(checks_geometry, "_all_new", lambda *_: False)
        patch.setattr(checks_dynamics, "_may_have_signs", lambda _: True)
        yield


def read(text, mode=None):
    try:
        deck = parse_deck(text, mode=mode)
    except InputError as error:
        return [str(m) for m in error.messages]
    rows = [
        (s.keyword, s.values, [type(v) for v in s.values], s.block, s.line, s.lines, s.columns) for s in deck.statements
    ]
    return rows, deck.spans, deck.visualization, [str(m) for m in deck.messages]


@pytest.mark.parametrize(
    "text", [p.read_text("utf-8", "replace") for p in FILES] + MISTAKES, ids=[p.stem for p in FILES] + list("abcde")
)
def test_plain_lines_are_their_words(text):
    plain = read(text)
    with one_by_one():
        assert read(text) == plain


WITHOUT_UNITS = [path for path in FILES if path.stem != "leafguide"]


@pytest.mark.parametrize("path", WITHOUT_UNITS, ids=lambda p: p.stem)
def test_real_files_are_read_together(path, monkeypatch):
    """Only lines with names and several statements on a line are taken word by word."""
    read = []
    exact = deck_reader.read_statement
    monkeypatch.setattr(deck_reader, "read_statement", lambda raw, *rest: read.append(raw) or exact(raw, *rest))
    lines = path.read_text("utf-8").splitlines()
    with suppress(InputError):
        parse_deck("\n".join(lines))
    for raw in read:
        words = re.split("[%#;]", lines[raw.line - 1])[0].split()[1:]
        spread = len(words) != len(raw.words)
        assert spread or any(lexer.number_of(w) is None or re.search("[dD]", w) for w in words)


WORDS = ["1", "+1.", ".5", "-1.5e-79", "1E+79", "999999999999999.00000000000000000001e79", "0.e5"]


@pytest.mark.parametrize("word", WORDS)
def test_ordinary_numbers_are_in_range(word):
    """What the pattern of plain lines takes `float` reads, and it is not too small to be computed with."""
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

    def statements_too():
        told = {}
        exact = deck_reader._read

        def recorded(part, keyword, outline, findings, groups, lost):
            told[id(groups)] = groups
            exact(part, keyword, outline, findings, groups, lost)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(deck_reader, "_read", recorded)
            found = read(text)
        statements = sorted([s for groups in told.values() for group in groups for s in group], key=lambda s: s.line)
        return found, [(*s[:4], s.lines, s.columns, [type(v) for v in s.values]) for s in statements]

    together = statements_too()
    with one_by_one():
        assert statements_too() == together


TEXTS = [p.read_text("utf-8", "surrogateescape") for p in FILES]
ODD = [*ORDINARY, *REALS, "1_0", "1e-5", "1e16", "0." + "0" * 120 + "1", "1" * 120, "f", "X", "END", "HALT", "\r", "%",
       "é", "\x1c", "\xa0", "VISUALIZATION"]  # fmt: skip


def damaged(seed, text):
    """A text with some of its lines dropped, repeated, joined, divided or with other words; the seed says which."""
    rng = random.Random(seed)
    lines = text.split("\n")
    for _ in range(rng.randrange(5)):
        k, what = rng.randrange(len(lines) - 1), rng.randrange(8)
        words = lines[k].split() or [""]
        w = rng.randrange(len(words))
        if what == 0:
            del lines[k]
        elif what == 1:
            lines.insert(rng.randrange(len(lines)), lines[k])
        elif what == 2:
            lines[k : k + 2] = [f"{lines[k]} {lines[k + 1]}"]
        elif what == 3:
            lines[k : k + 1] = [" ".join(words[:w]), " ".join(words[w:])]
        elif what == 4:
            lines[k] = rng.choice([lines[k].lower(), f"\t {lines[k]}", lines[k] + " % é"])
        elif what == 5:
            lines[k] = " ".join(words[:w] + words[w + 1 :])
        else:
            words[w : w + 7 - what] = [rng.choice(ODD)]
            lines[k] = " ".join(words)
    return "\n".join(lines)


MODES = st.sampled_from([None, 0, 1, 2, 3, 7, 8, 9, "simulation"])


def damaged_files_say_the_same(text, mode):
    together = read(text, mode)
    with one_by_one():
        assert read(text, mode) == together


def cantilever(n, sort):
    """A file of n planar beams in a row, with five statements for each, by their keywords or by the element."""
    beams = [f"PLBEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}" for k in range(1, n + 1)]
    rows = [f"{beam}\nX {2 * k + 1} {k / n} 0." for k, beam in enumerate(beams, 1)]
    rows += ["FIX 1", "FIX 2", *(f"DYNE {k} 2 3" for k in range(1, n + 1))]
    loads = [f"EM {k} 1.5\nESTIFF {k} 0. {k}.25" for k in range(1, n + 1)]
    blocks = ["\n".join(block).split("\n") for block in (rows, loads)]
    return "\nEND HALT\n".join("\n".join(sorted(b) if sort else b) for b in blocks) + "\nEND END\n"


def calls(text):
    """Calls of functions in Python; not those of a garbage collection, for which hypothesis has a hook."""
    count = 0

    def counted(_, event, __):
        nonlocal count
        count += event == "call"

    gc.disable()
    sys.setprofile(counted)
    try:
        parse_deck(text)
    finally:
        sys.setprofile(None)
        gc.enable()
    return count


@pytest.mark.parametrize(("sort", "most"), [(True, 1.6), (False, 2.6)], ids=["by keyword", "by element"])
def test_large_files_take_few_calls(sort, most):
    """Calls of functions in Python do not grow faster than the file, and plain statements need few of their own."""

    calls(cantilever(10, sort))  # what is found once for each keyword
    few, some, many = (calls(cantilever(n, sort)) for n in (100, 200, 400))
    assert many - some <= 2.01 * (some - few)
    assert many - some <= most * 200 * 5


def test_small_files_take_few_calls():
    """What a file does not have is not looked for: 16 statements of six kinds."""
    text = cantilever(3, True)
    calls(text)
    assert calls(text) <= 255


def every_ordinary_number_is_read_alike(word):
    """`float` reads a word of the pattern as the number grammar does."""
    assert lexer.is_in_range(float(word), word)
    assert float(word) == lexer.number_of(word)


# many examples in the slow tests, the first of them in the fast ones
TRIED = settings(deadline=None, database=None, derandomize=True)
few_odd, odd = (settings(TRIED, max_examples=n)(given(TEXT)(odd_lines_are_their_words)) for n in (50, 1500))
FILE = st.builds(damaged, st.integers(0, 2**63), st.sampled_from(TEXTS))
some, all_files = (settings(TRIED, max_examples=n)(given(FILE, MODES)(damaged_files_say_the_same)) for n in (100, 3000))
test_damaged_files_say_the_same, test_many_damaged_files_say_the_same = some, pytest.mark.slow(all_files)
NUMBERS = st.from_regex(lexer._ORDINARY, fullmatch=True)
few, many = (settings(TRIED, max_examples=n)(given(NUMBERS)(every_ordinary_number_is_read_alike)) for n in (30, 1000))
test_odd_lines_are_their_words, test_many_odd_lines_are_their_words = few_odd, pytest.mark.slow(odd)
test_every_ordinary_number_is_read_alike, test_many_ordinary_numbers = few, pytest.mark.slow(many)


def test_statements_are_made_when_asked_for():
    """In the order of the file, also where lines of two keywords alternate, and each of them once."""
    text = "PLBEAM 1 1 2 3 4\nFIX 1\nX 1 0. 0.\nFIX 2\nX 3 1. 0.\nEND HALT\nEM 1 1.\nGRAVITY 0. -9.81\nEND END"
    deck = parse_deck(text)
    assert "statements" not in vars(deck)
    assert [s.line for s in deck.statements] == [1, 2, 3, 4, 5, 7, 8]
    assert deck.statements is deck.statements
    assert deck.of("X")[1] is deck.statements[4]
    assert deck.statements[4] == ("X", (3, 1.0, 0.0), 1, 5, "X 3 1. 0.")


def test_columns_of_statements_without_numbers():
    """ADEFORM without numbers is for all elements; twice it is said that it is repeated."""
    text = "PLBEAM 1 1 2 3 4\nX 3 1. 0.\nADEFORM\nADEFORM\nFIX 1\nFIX 2\nEND HALT\nEM 1 1.\nEND END"
    assert read(text) == ["error: <deck>:4: ADEFORM: already given at line 3; give it once"]
    assert list(parse_deck(text.replace("ADEFORM\n", "", 1)).index.rows("ADEFORM", 1)) == [()]


def test_exponents_of_fortran_are_plain(monkeypatch):
    """A number with d before its exponent does not make the whole text be divided once more."""
    text = "PLBEAM 1 1 2 3 4\nX 3 1.25d0 -2D-1\nFIX 1\nFIX 2d0\nEND HALT\nEM 1 {}\nEND END"
    with one_by_one():
        wanted, small = read(text.format("1.d+02")), read(text.format("1.d-200"))
    runs = []
    run = splitter._Splitter.run
    monkeypatch.setattr(splitter._Splitter, "run", lambda self: runs.append(1) or run(self))
    assert read(text.format("1.d+02")) == wanted
    assert len(runs) == 1
    assert wanted[0][1][1] == (3, 1.25, -0.2)
    assert read(text.format("1.d-200")) == small
