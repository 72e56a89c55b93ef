"""Cases whose numbers are combinations of those of a few: they are those of decks of their own; an integer or a setting
of the run has decks of its own."""

import numpy as np
import pytest

import spacar
from spacar.compiled.library import why_off
from spacar.deck import parse_deck, read_deck
from spacar.studies.affine_cases import FEWEST, affine_cases
from spacar.studies.assignments import change, setting
from tests.ensembles import ensemble, followed
from tests.examples import DATA

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))

BEAMS = """BEAM 1 1 2 3 4 0. 1. 0.   BEAM 2 3 4 5 6 0. 1. 0.   X 3 1. 0. 0.   X 5 2. 0. 0.1
FIX 1   FIX 2   DYNE 1 2 3 4 5 6   DYNE 2 2 3 4 5 6   END HALT
EM 1 0.3 0.01 0.02 0.02   EM 2 0.3 0.01 0.02 0.02   XM 6 0.1 0. 0. 0.2 0. 0.3
ESTIFF 1 0. 4. 5. 6.{shear}   ESTIFF 2 0. 4. 5. 6.   EDAMP 1 0. 0.4 0.5 0.6   ESIG 2 0. 0.1
XF 5 0. 0. -1.   STARTDE 1 3 0. 0.1   GRAVITY 0. 1. -9.81   TIMESTEP 0.05 2   END END
"""
OPTIONS = {"rtol": 1e-8, "atol": 1e-8}


def table(columns: int) -> list[list[float]]:
    """More values than are needed, between 0.5 and 1.5, in no order; the first ones are the least."""
    rows = 0.5 + np.random.default_rng(columns).random((FEWEST + 3, columns))
    rows[0] = 0.5
    return rows.tolist()


@pytest.mark.parametrize(
    "targets",
    [
        ("XM.6[2]", "XM.6[5]"),
        ("EM.*[mass]",),
        ("EM.1[3]", "ESTIFF.2[3]", "EDAMP.1[3]"),
        ("ESIG.2[3]", "XF.5[4]", "STARTDE.1.3[4]"),
        ("X.5[coordinate x1]",),
        ("X.3[coordinate x2]", "X.5[coordinate x3]", "EM.*[mass]", "ESTIFF.1[3]"),
    ],
)
def test_combinations_are_the_cases(targets):
    deck = parse_deck(BEAMS.format(shear=""), mode=1)
    settings, values = tuple(map(setting, targets)), table(len(targets))
    cases = affine_cases(deck, settings, values, **OPTIONS)
    assert cases is not None
    decks = [change(deck, settings, row) for row in values]
    assert cases.deck(5).text == decks[5].text
    for one, other in zip(followed(cases, **OPTIONS), ensemble(decks, **OPTIONS), strict=True):
        for name in ("x", "xd", "sig", "fxtot"):
            size = max(1.0, np.abs(other[name]).max())
            np.testing.assert_allclose(one[name], other[name], atol=1e-9 * size, rtol=0, err_msg=name)


def test_prescribed_motions():
    deck = read_deck(DATA / "crankfl.dat", 1)
    settings, values = (setting("INPUTX.2.1[start rate]"),), [[100.0 + 3.0 * k] for k in range(FEWEST)]
    options = OPTIONS | {"duration": 0.001, "n_steps": 1}
    cases = affine_cases(deck, settings, values, **options)
    assert cases is not None
    decks = [change(deck, settings, row) for row in values]
    for one, other in zip(followed(cases, **options), ensemble(decks, **options), strict=True):
        np.testing.assert_allclose(one["xd"], other["xd"], atol=1e-9 * np.abs(other["xd"]).max())


@pytest.mark.parametrize(
    ("targets", "low", "why"),
    [
        (("X.5[coordinate x1]",), 2.0, ""),
        (("ESTIFF.1[3]",), 4.0, ""),
        (("GRAVITY[3]",), 9.0, "cases share gravity"),
        (("TIMESTEP[1]",), 0.05, "a setting of the run"),
        (("XM.6[2]",), 0.1, ""),
        (("XM.6[1]",), 0.1, "an integer"),
    ],
)
def test_what_has_decks_of_its_own(targets, low, why):
    deck = parse_deck(BEAMS.format(shear=" 0.3 0.2"), mode=1)
    values = [[low * (1.0 + 0.01 * k)] * len(targets) for k in range(FEWEST)]
    angle = {"beams": "angle"}
    assert (affine_cases(deck, tuple(map(setting, targets)), values, **OPTIONS, **angle) is None) == bool(why)


def test_a_sweep_takes_them_and_gives_the_rows_of_single_runs(monkeypatch):
    from spacar.studies import batched_cases

    taken = []
    monkeypatch.setattr(batched_cases, "affine_cases", lambda *a, **o: taken.append(affine_cases(*a, **o)) or taken[-1])
    deck = read_deck(DATA / "robotsim.dat", 1)
    masses = np.linspace(20.0, 40.0, FEWEST + 1)
    options = {"duration": 0.3, "n_steps": 3, "rtol": 1e-7, "atol": 1e-7}
    rows, alone = (
        spacar.sweep(deck, {"XM.8": masses}, "z: x[8,3]@end", batch=batch, jobs=1, **options) for batch in (None, False)
    )
    assert taken
    assert taken[0] is not None
    for one, other in zip(rows, alone, strict=True):
        assert (one["status"], one["XM.8"], one["case"]) == ("done", other["XM.8"], other["case"])
        assert one["z"] == pytest.approx(other["z"], abs=1e-6)


@pytest.mark.parametrize("first", [True, False])
def test_a_length_that_cannot_be_fails_alone_with_its_message(first, monkeypatch):
    """Also where it is the first of all cases, from which the others are counted."""
    from spacar.studies import batched_cases

    kept = []
    monkeypatch.setattr(batched_cases, "affine_cases", lambda *a, **o: kept.append(affine_cases(*a, **o)) or kept[-1])
    deck = parse_deck(BEAMS.format(shear=""), mode=1)
    lengths = [2.0 + 0.01 * k for k in range(FEWEST)]
    lengths[0 if first else 5] = 1.0  # the node at the other end, 0.1 m aside, as X 5 has it
    change_of = {"X.5[coordinate x1]": lengths, "X.5[coordinate x3]": [0.0] * FEWEST}
    options = {"rtol": 1e-6, "atol": 1e-6}
    rows, alone = (
        spacar.sweep(deck, change_of, "x: x[5,1]@end", together=True, batch=batch, jobs=1, **options)
        for batch in (True, False)
    )
    assert kept[0] is not None
    for one, other in zip(rows, alone, strict=True):
        assert (one["status"], one["reason"]) == (other["status"], other["reason"])
    assert [row["status"] for row in rows].count("failed") == 1
    assert "is zero" in rows[0 if first else 5]["reason"]
