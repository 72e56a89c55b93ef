"""A variant whose numbers are put into the statements of the deck is the deck that its text reads to."""

import pytest

from spacar.deck import parse_deck, read_deck
from spacar.studies import assignments
from spacar.studies.assignments import change, setting
from tests.examples import DATA

CASES = [
    ("robotsim.dat", "XM.8", 27.5), ("robotsim.dat", "BEAM.4[4]", 0.0), ("crankfl.dat", "ESTIFF.*[EI]", 12.25),
    ("crankfl.dat", "X.*[1]", 1e-3), ("crank.dat", "TIMESTEP[1]", 0.125), ("trike2.dat", "XM.*", 1e-7),
    ("robotsim.dat", "ERROR[1]", 1e-7), ("plbeam5.dat", "XF.*[2]", -3.0), ("fourbar.dat", "STARTDX.*[3]", 0.5),
    ("crankfl.dat", "EM.*", 1e200), ("crankfl.dat", "EM.*", -1.0), ("crankfl.dat", "TIMESTEP[1]", -1.0),
]  # fmt: skip


@pytest.mark.parametrize(("name", "target", "value"), CASES)
@pytest.mark.parametrize("mode", [None, 1, 7])
def test_same_as_reading(name, target, value, mode, monkeypatch):
    deck = read_deck(DATA / name, mode)
    which = [setting(target)]
    found = []
    for substitutes in (True, False):
        if not substitutes:
            monkeypatch.setattr(assignments, "with_numbers", lambda deck, edits: None)
        try:
            found.append(change(deck, which, [value]))
        except Exception as error:
            found.append((type(error), str(error)))
    ours, read = found
    if isinstance(read, tuple):
        assert ours == read
        return
    assert ours.text == read.text
    assert ours.statements == read.statements
    assert set(ours.messages) == set(read.messages)
    for part in ("data", "sha256", "visualization", "mode", "third", "sections"):
        assert getattr(ours, part) == getattr(read, part)
    assert ours.to_text() == read.to_text()


def test_two_numbers_of_a_line_and_a_comment():
    text = "PLBEAM 1 1 2 3 4\nX 3 1. 0.\nFIX 1\nFIX 2\nDYNE 1 2 3\nEND\nHALT\nEM 1 2.5   % mass\nESTIFF 1 0. 3.;rest\n"
    deck = parse_deck(text + "END\nEND\n", mode=7)
    changed = change(deck, [setting("X.3[2]"), setting("X.3[3]"), setting("EM.1")], [1.25, 0.125, 1e-5])
    assert changed.first("X").values == (3, 1.25, 0.125)
    assert changed.text == parse_deck(changed.text, mode=7).text
    assert "EM 1 1e-05   % mass" in changed.text
    assert parse_deck(changed.text, mode=7).statements == changed.statements


def test_nothing_is_read(monkeypatch):
    deck = read_deck(DATA / "robotsim.dat", 1)
    change(deck, [setting("XM.8")], [20.0])
    monkeypatch.setattr(assignments, "parse", None)
    assert change(deck, [setting("XM.8")], [21.0]).first("XM").keyword == "XM"


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize(("before", "value"), [("1.", 0.12345678901234567), ("0.12345678901234567", 1.0)])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_lines_that_get_too_long_or_fit_again(end, before, value, mark, monkeypatch):
    comment = "% " + (157 - len("X 3 1. 0.% ")) * "-"
    rows = ["PLBEAM 1 1 2 3 4", f"X 3 {before} 0.{comment}", "FIX 1", "FIX 2", "DYNE 1 2", "END HALT", "END END", ""]
    deck = parse_deck(mark + end.join(rows), mode=7)
    ours = change(deck, [setting("X.3[2]")], [value])
    monkeypatch.setattr(assignments, "with_numbers", lambda deck, edits: None)
    read = change(deck, [setting("X.3[2]")], [value])
    for part in ("text", "data", "statements", "messages"):
        assert getattr(ours, part) == getattr(read, part)
    assert any("longer than 160" in m.text for m in ours.messages) == (value != 1.0)
