"""Every situation of reference/input-language.md section 10 is reported, with its line, and nothing else goes
wrong."""

import pytest

from spacar.deck import parse_deck
from spacar.errors import InputError, Message

from . import rows


def messages_of(text: str, mode: int | None) -> list[Message]:
    try:
        return list(parse_deck(text, "<deck>", mode).messages)
    except InputError as error:
        return error.messages


@pytest.mark.parametrize("row", rows.ROWS, ids=lambda r: r.name)
def test_row(row) -> None:
    messages = messages_of(row.text, row.mode)
    lines = [str(m) for m in messages if m.severity == row.severity]
    assert any(all(f in line for f in row.fragments) for line in lines), "\n".join(map(str, messages))
    if row.severity != "error":
        assert not [m for m in messages if m.severity == "error"]


def test_one_mistake_gives_one_error() -> None:
    """A wrong word must not be reported several times; only one row holds two mistakes."""
    double = {"wheel in mode 2"}  # has no trajectory either
    for row in rows.ROWS:
        errors = [m for m in messages_of(row.text, row.mode) if m.severity == "error"]
        if row.severity == "error" and row.name not in double:
            assert len(errors) == 1, (row.name, *map(str, errors))


def test_base_decks_are_right() -> None:
    for text in (rows.planar(), rows.spatial(), rows.arm(), rows.bar(), rows.TROLLEY + rows.END):
        assert [str(m) for m in messages_of(text, None)] == []


@pytest.mark.parametrize(
    "text",
    [
        rows.bar("INPUTX 2 q", "INPUTX 2 1 0. 1."),
        rows.bar("INPUTX 2 q", "", rows.TRAVEL),
        rows.bar("INPUTX 2", "", "TRAJECT 1|TRANS 2 4.|TRTIME 1. 10"),
        rows.bar("INPUTX 2", "", "TRAJECT 1|TRANS 2 4. 4.|TRTIME 1."),
        rows.bar("INPUTX 2", "", "TRAJECT q|TRANS 2 4. 4.|TRTIME 1. 10"),
        rows.bar("RLSE 1", "", "OUTX 1 2 1|OUTX 2 2 q|OUTX 3 2 2"),
        rows.bar("PLTRUSS 2 1 3 9|X 3 1.|FIX 3|DYNE 2 1", "EM 2 1."),
        rows.bar("PLTRUSS 2 1 3|X 3 1. ,"),
    ],
)
def test_a_broken_statement_has_no_consequences(text: str) -> None:
    """What is missing only because its statement could not be read is not reported again."""
    errors = [str(m) for m in messages_of(text, None) if m.severity == "error"]
    assert len(errors) == 1, errors


def test_forms_of_the_reference() -> None:
    """The three lines that section 10 shows as the form of a message."""
    three = "PLBEAM 1 1 2 3 4\nPLBEAM 2 3 4 5 6\nPLBEAM 3 5 6 7 8\nX 3 1.\nX 5 2.\nX 7 3.\n"
    text = three + "FIX 2\nFIX 1\nFIX 1 1\n\n\nDYNE 7\nEND HALT\nESTIFF 2 0. O.5\nEND END\n"
    with pytest.raises(InputError) as error:
        parse_deck(text, "crank.dat")
    assert [str(m) for m in error.value.messages] == [
        "warning: crank.dat:9: FIX 1: coordinate 1 was already fixed at line 8",
        "error: crank.dat:12: DYNE: element 7 is not defined; elements 1-3 exist",
        "error: crank.dat:14: ESTIFF 2: third argument 'O.5' is not a number; expected EI (N m^2) of a planar beam",
    ]
