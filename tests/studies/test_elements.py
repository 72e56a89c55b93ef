"""`--elements N`: the run of the divided model, in which nodes and elements of the file keep their numbers."""

import json
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.deck.rewrite.refine import divisible_beams, refine
from spacar.errors import UsageError


def test_the_same_as_the_divided_model(deck):
    """plbeam5 with two beams for each, by the option and by hand; the tip is nearer to 3.8109 of the elastica."""
    given = deck("plbeam5", 7)
    by_option, by_hand = spacar.run(7, given, elements=2), spacar.run(7, refine(given, 2))
    np.testing.assert_array_equal(by_option["x"], by_hand["x"])
    exact = 3.810897752359167
    assert abs(by_option.node(11, 1)[-1] - exact) < 0.3 * abs(spacar.run(7, given).node(11, 1)[-1] - exact)


def test_the_command(call):
    """The log repeats the option, the json counts the divided model's freedoms, the results have its nodes."""
    done = call.done("7", "plbeam5", "--elements", "3", "--json")
    report = json.loads(done.out)
    assert report["nddof"] == 3 * 10
    text = Path("plbeam5.log").read_text(encoding="utf-8")
    assert "--elements" in text
    assert spacar.read_deck("plbeam5.dat").sha256 in text


def test_units_and_sections_stay(deck):
    given = deck("leafguide", 7)
    finer = refine(given, 2)
    assert finer.metre == given.metre == 1e-3
    assert finer.visualization == given.visualization
    assert [len(s.parts) for s in finer.sections] == [8, 1, 1, 8]


def test_beams_that_cannot_be_divided_are_said(deck):
    """A flexible tube stays; without any beam to divide it is refused."""
    rows = "PLBEAM 1 1 2 3 4\nPLTUBE 2 3 4 5 6\nX 3 1. 0.\nX 5 2. 0.\nFIX 1\nFIX 2\nDYNE 1 2 3\nDYNE 2 2 3\nEND HALT\n"
    rows += "EM 1 1.\nEM 2 1.\nESTIFF 1 0. 1.\nESTIFF 2 0. 1.\nEND END\n"
    model = parse_deck(rows, mode=7)
    assert divisible_beams(model) == ((1,), {2: "a tube is not divided; write more of them"})
    run = spacar.frames(7, model, elements=2)
    assert run.mechanism.numbering.nddof == 3 * 2
    assert any("beam 2 is not divided into 2: a tube" in line for line in run.report.lines)
    with pytest.raises(UsageError, match=r"no beam that can be divided \(none is flexible\)"):
        spacar.frames(1, deck("crank", 1), elements=2)
    for wrong in (0, 1.5, "2", False):
        with pytest.raises(UsageError, match=r"elements = .* must be a whole number from 1"):
            spacar.frames(7, model, elements=wrong)
