"""Targets and values of a study."""

from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.errors import InputError, UsageError
from spacar.studies import assignments
from spacar.studies.assignments import axis, change, combine, setting, values
from spacar.studies.runs.quantities import quantity
from tests.examples import DATA


def changed(deck, text):
    a = axis(text)
    return change(deck, [a.setting], [a.values[0]])


@pytest.mark.parametrize(
    ("text", "keyword", "row"),
    [
        ("ESTIFF.3[EI]=5", "ESTIFF", (3, 0.0, 5.0)),
        ("ESTIFF.3[3]=5", "ESTIFF", (3, 0.0, 5.0)),
        ("estiff 3 [ei] = 5", "ESTIFF", (3, 0.0, 5.0)),
        ("ESTIFF.3=5", "ESTIFF", (3, 5.0, 13.359623)),
        ("ESTIFF.3[shear]=0.1", "ESTIFF", (3, 0.0, 13.359623, 0.1)),
        ("XM.8=2", "XM", (8, 2.0)),
        ("INPUTX.2.1[start rate]=7", "INPUTX", (2, 1, 0.0, 7.0, 0.0)),
        ("INPUTX.2[4]=7", "INPUTX", (2, 1, 0.0, 7.0, 0.0)),
        ("TIMESTEP[2]=5", "TIMESTEP", (0.1, 5)),
        ("X.6[coordinate x1]=0.31", "X", (6, 0.31, 0.0)),
    ],
)
def test_a_target(deck, text, keyword, row):
    """One statement has the new value and nothing else changes."""
    old = deck("crankfl", 1)
    new = changed(old, text)
    assert row in [s.values for s in new.of(keyword)]
    different = [(a, b) for a, b in zip(old.statements, new.statements, strict=True) if a.values != b.values]
    assert len(different) == 1


def test_all_statements_and_joined_targets(deck):
    old = deck("crankfl", 1)
    assert [s.values[2] for s in changed(old, "ESTIFF.*[EI]=5").of("ESTIFF")] == [5.0, 5.0]
    assert [s.values[2] for s in changed(old, "ESTIFF.2[EI] & ESTIFF.3[EI]=6").of("ESTIFF")] == [6.0, 6.0]
    together = change(old, [setting("XM.8"), setting("EM.*"), setting("EM.2[J]")], [1.0, 2.0, 3.0])
    assert [s.values for s in together.of("XM", "EM")] == [(8, 1.0), (2, 2.0, 3.0), (3, 2.0)]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("ESTIFF.9[EI]=5", "no statement ESTIFF 9"),
        ("ESTIFF.3[GIt]=5", "no argument 'GIt'; its arguments are 1 element number, 2 EA, 3 EI"),
        ("ESTIFF.3[E]=5", "could be element number, EA, EI"),
        ("ESTIFF[2]=5", "2 statements ESTIFF; give more numbers"),
        ("FOO.1=5", "not a keyword"),
        ("ESTIFF.3[EI]", "no values"),
        ("=5", "cannot read ''"),
        ("ESTIFF.3.*[EI]=5", "stands alone"),
        ("TIMESTEP[2]=5.5", "takes whole numbers"),
        ("XM.8=a", "'a' in 'a' is not a number"),
        ("XM.8=nan", "not a number"),
        ("XM.8=1:2", "no range"),
        ("XM.8=1:2:2.5", "count"),
        ("XM.8=-1:2:3:log", "same sign"),
        ("XM.8=@nothing", "names no column"),
    ],
)
def test_wrong_assignments(deck, text, why):
    with pytest.raises(UsageError, match=why):
        changed(deck("crankfl", 1), text)


def test_the_same_place_twice(deck):
    with pytest.raises(UsageError, match="set twice"):
        change(deck("crankfl", 1), [setting("EM.2"), setting("EM.*")], [1.0, 2.0])
    with pytest.raises(UsageError, match=r"XM\.8 is set twice"):
        combine([axis("XM.8=1"), axis("XM.8=2")])


def test_a_changed_deck_is_checked(deck):
    with pytest.raises(InputError, match="crankfl"):
        changed(deck("crankfl", 1), "PLBEAM.3[p position]=7")


def test_values(tmp_path):
    assert values("1, 2,3e1") == (1.0, 2.0, 30.0)
    assert values("0:1:5") == (0.0, 0.25, 0.5, 0.75, 1.0)
    assert np.allclose(values("1:100:3:log"), (1, 10, 100), rtol=1e-15)
    (tmp_path / "c.csv").write_text("# comment\nei, m\n1,2\n3,4\n")
    assert values(f"@{tmp_path}/c.csv:m") == (2.0, 4.0)


def test_combinations():
    _, grid = combine([axis("XM.8=1,2"), axis("EM.2=5,6,7")])
    assert grid == [(1, 5), (1, 6), (1, 7), (2, 5), (2, 6), (2, 7)]
    _, pairs = combine([axis("XM.8=1,2"), axis("EM.2=5,6")], together=True)
    assert pairs == [(1, 5), (2, 6)]
    with pytest.raises(UsageError, match=r"XM\.8 has 2, EM\.2 has 3"):
        combine([axis("XM.8=1,2"), axis("EM.2=5,6,7")], together=True)


# Targets with a name (SECTION, MATERIAL) and natural frequencies in the languages of studies.
GUIDE = DATA / "leafguide.dat"


@pytest.mark.parametrize("target", ["SECTION.leaf[t]", "section.LEAF[t along]", "SECTION.leaf[4]"])
def test_a_dimension_of_a_section_and_a_number_of_a_material(target: str) -> None:
    deck = change(spacar.read_deck(GUIDE, 10), [setting(target), setting("MATERIAL.spring[Young]")], [0.6, 1e5])
    [use] = [s for s in deck.sections if s.element == 1]
    assert use.dims == (0.05, 0.0006)
    assert pytest.approx(1e11) == use.material.E


def test_a_name_that_there_is_not() -> None:
    with pytest.raises(UsageError, match="there is no statement SECTION blade to change"):
        setting("SECTION.blade[t]").targets[0].places(spacar.read_deck(GUIDE, 10))
    with pytest.raises(UsageError, match="its arguments are 1 name, 2 shape, 3 w along y', 4 t along z'"):
        setting("SECTION.leaf[d]").targets[0].places(spacar.read_deck(GUIDE, 10))


def test_frequencies_as_quantities() -> None:
    """frequency[i] is |eigval|/2 pi, from low to high."""
    result = spacar.run(7, Path(GUIDE).with_name("plbeam5free.dat"))
    values = np.sort(np.unique(np.abs(result["eigval"][-1] @ [1, 1j]).round(9))) / (2 * np.pi)
    assert quantity("frequency[1]@end").number(result) == pytest.approx(values[0], rel=1e-6)
    assert quantity("frequency[2]@end").number(result) == pytest.approx(result.frequencies[-1, 1], rel=1e-14)
    with pytest.raises(UsageError, match="frequency has"):
        quantity("frequency[99]@end").number(result)


# A variant whose numbers are put into the statements of the deck is the deck that its text reads to.
CASES = [
    ("robotsim.dat", "XM.8", 27.5), ("robotsim.dat", "BEAM.4[4]", 0.0), ("crankfl.dat", "ESTIFF.*[EI]", 12.25),
    ("crankfl.dat", "X.*[1]", 1e-3), ("crank.dat", "TIMESTEP[1]", 0.125), ("trike2.dat", "XM.*", 1e-7),
    ("robotsim.dat", "ERROR[1]", 1e-7), ("plbeam5.dat", "XF.*[2]", -3.0), ("fourbar.dat", "STARTDX.*[3]", 0.5),
    ("crankfl.dat", "EM.*", 1e200), ("crankfl.dat", "EM.*", -1.0), ("crankfl.dat", "TIMESTEP[1]", -1.0),
]  # fmt: skip


@pytest.mark.parametrize(("name", "target", "value"), CASES)
@pytest.mark.parametrize("mode", [None, 1, 7])
def test_same_as_reading(name, target, value, mode, monkeypatch):
    deck = spacar.read_deck(DATA / name, mode)
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
    deck = spacar.parse_deck(text + "END\nEND\n", mode=7)
    changed = change(deck, [setting("X.3[2]"), setting("X.3[3]"), setting("EM.1")], [1.25, 0.125, 1e-5])
    assert changed.first("X").values == (3, 1.25, 0.125)
    assert changed.text == spacar.parse_deck(changed.text, mode=7).text
    assert "EM 1 1e-05   % mass" in changed.text
    assert spacar.parse_deck(changed.text, mode=7).statements == changed.statements


def test_nothing_is_read(monkeypatch):
    deck = spacar.read_deck(DATA / "robotsim.dat", 1)
    change(deck, [setting("XM.8")], [20.0])
    monkeypatch.setattr(assignments, "parse", None)
    assert change(deck, [setting("XM.8")], [21.0]).first("XM").keyword == "XM"


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize(("before", "value"), [("1.", 0.12345678901234567), ("0.12345678901234567", 1.0)])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_lines_that_get_too_long_or_fit_again(end, before, value, mark, monkeypatch):
    comment = "% " + (157 - len("X 3 1. 0.% ")) * "-"
    rows = ["PLBEAM 1 1 2 3 4", f"X 3 {before} 0.{comment}", "FIX 1", "FIX 2", "DYNE 1 2", "END HALT", "END END", ""]
    deck = spacar.parse_deck(mark + end.join(rows), mode=7)
    ours = change(deck, [setting("X.3[2]")], [value])
    monkeypatch.setattr(assignments, "with_numbers", lambda deck, edits: None)
    read = change(deck, [setting("X.3[2]")], [value])
    for part in ("text", "data", "statements", "messages"):
        assert getattr(ours, part) == getattr(read, part)
    assert any("longer than 160" in m.text for m in ours.messages) == (value != 1.0)
