"""Targets and values of a study."""

import numpy as np
import pytest

from spacar.errors import InputError, UsageError
from spacar.studies.assignments import axis, change, combine, setting, values


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
