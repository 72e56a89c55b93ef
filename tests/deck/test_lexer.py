"""Lexical rules of reference/input-language.md section 1."""

import pytest

from spacar.deck import parse_deck, read_deck
from spacar.deck.lexer import integer_of, number_of, scan
from spacar.errors import InputError, UsageError

TEXT = "PLBEAM 1 1 2 3 4\nX 3 1. 0.5\nFIX 1 % wall\nFIX 2\nEND HALT\nXM 3 2.\nEND END\n"


def rows(text: str) -> list[tuple]:
    return [(s.keyword, s.values, s.block, s.line) for s in parse_deck(text).statements]


@pytest.mark.parametrize(
    ("text", "value"),
    [("1", 1.0), ("+1.", 1.0), ("-.5", -0.5), ("1.5d3", 1500.0), ("1D-2", 0.01), ("2e+3", 2000.0), ("3E0", 3.0)],
)
def test_numbers(text: str, value: float) -> None:
    assert number_of(text) == value


@pytest.mark.parametrize(
    "text",
    [
        "",
        ".",
        "+",
        "-.",
        "1e",
        "1e+",
        "e5",
        "nan",
        "inf",
        "-inf",
        "1,5",
        "1_000",
        "0x1F",
        "1.2.3",
        "1 ",
        "١",
        "--1",
        "1f",
    ],
)
def test_not_numbers(text: str) -> None:
    assert number_of(text) is None


def test_integers() -> None:
    assert [integer_of(t) for t in ("3", "3.", "3.0e0", "1e2", "3.5", "x", "1e999")] == [3, 3, 3, 100, None, None, None]


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_line_ends_and_byte_order_mark(newline: str) -> None:
    """Form feed is a blank, U+2028 in a comment ends nothing."""
    assert rows("\ufeff" + TEXT.replace("\n", newline)) == rows(TEXT)
    assert rows(TEXT.replace("% wall", "% wall\u2028 XM 3 5. \x0b\x1c FIX")) == rows(TEXT)


def test_free_format() -> None:
    joined = "plbeam 1\n1 2\n\t3 4 X 3 1.\n0.5 fix 1 ; wall\nFix 2 # no\nend\nhalt\nxm 3 2. END\nEND more 1"
    assert [r[:3] for r in rows(joined)] == [r[:3] for r in rows(TEXT)]


def test_places_of_words() -> None:
    words = [(w.text, w.line, w.column, w.first) for w in scan("A\tb  1.5 % c\n ; \n  D").words]
    assert words == [("A", 1, 1, True), ("b", 1, 3, False), ("1.5", 1, 6, False), ("D", 3, 3, True)]


def test_names() -> None:
    """An alias, another case, and a name that is a keyword."""
    deck = parse_deck(TEXT.replace("FIX 2\n", "FIX 2\nlevellog 1 1\n").replace("XM 3 2.", "usersig myForce xm 3 2."))
    assert deck.first("OUTLEVEL") is not None
    assert deck.of("USERSIG")[0].values == ("myForce",)
    deck = parse_deck(TEXT.replace("XM 3 2.", "USERINP xm XM 3 2."))
    assert [s.values for s in deck.statements if s.block == 2] == [("xm",), (3, 2.0)]


def test_bytes_that_are_not_utf8(tmp_path) -> None:
    file = tmp_path / "a.dat"
    file.write_bytes(TEXT.replace("wall", "\u00e9").encode("latin-1"))
    assert read_deck(file).text.count("\ufffd") == 1
    file.write_bytes(TEXT.replace("XM", "XM\u00e9").encode("latin-1"))
    with pytest.raises(InputError, match=r"a.dat:6: byte 0xE9 .* is not UTF-8"):
        read_deck(file)


def test_files_that_are_no_text_get_one_sentence(tmp_path) -> None:
    """UTF-16, as PowerShell writes it, and a result; zeros behind the end, as old disks leave them, do no harm."""
    file = tmp_path / "a.dat"
    for data in (TEXT.encode("utf-16"), b"\x89SBF\r\n\x1a\n\x01\0\0\0" * 50):
        file.write_bytes(data)
        with pytest.raises(InputError, match="UTF-16") as error:
            read_deck(file)
        assert len(error.value.messages) == 1
    file.write_bytes(f"{TEXT}\0\0\0".encode())
    assert not read_deck(file).messages


def test_long_line_is_reported_once() -> None:
    deck = parse_deck(TEXT.replace("% wall", "%" + "w" * 160).replace("FIX 2", "FIX 2 %" + "w" * 160))
    assert [(m.severity, m.line) for m in deck.messages] == [("warning", 3)]


def test_control_characters_are_escaped_in_messages() -> None:
    with pytest.raises(InputError) as error:
        parse_deck(TEXT.replace("XM 3", "XM \x1b[31m"))
    assert str(error.value).isprintable()


def test_files(tmp_path) -> None:
    """What is missing is said; the extension is appended."""
    (tmp_path / "folder.dat").mkdir()
    for name, said in (("nothing", r"nothing.dat: No such file"), ("folder.dat", "Is a directory")):
        with pytest.raises(UsageError, match=said):
            read_deck(tmp_path / name)
    for name, asked in (("a.b.dat", "a.b"), ("plain", "plain")):
        (tmp_path / name).write_text(TEXT)
        assert read_deck(str(tmp_path / asked)).source == name


def test_visualization(tmp_path) -> None:
    section = "VISUALIZATION\nBEAMVIS 0.01 0.1\n  TRAJECT 1 % raw\n"
    deck = parse_deck(TEXT + "\n" + section)
    assert deck.visualization == ("BEAMVIS 0.01 0.1", "  TRAJECT 1 % raw")
    assert parse_deck(deck.to_text()).visualization == deck.visualization
    (tmp_path / "a.dat").write_text(TEXT)
    (tmp_path / "a.spv").write_text("visualization\nLIGHT 1\n")
    assert read_deck(tmp_path / "a").visualization == ("LIGHT 1",)
    (tmp_path / "a.dat").write_text(TEXT + section)
    assert len(read_deck(tmp_path / "a").visualization) == 2
