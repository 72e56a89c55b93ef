"""What a model could do without, with its price; pairs of alike beams as one."""

import json
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.deck.rewrite.coarser import merged
from spacar.deck.rewrite.refine import refine, rigid
from spacar.errors import UsageError
from spacar.studies.policies.budget import TradeSearch
from spacar.studies.policies.simplification import simplify, variations
from spacar.studies.policies.trade import Reference
from spacar.studies.runs.quantities import quantity
from spacar.studies.runs.setting import Setup, Trade

# A stiff rod (1e6 times) carries a soft one; the soft one vibrates.
ARM = """
PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   X 3 0.5 0.   X 5 1.0 0.
FIX 1   FIX 2   DYNE 1 2 3   DYNE 2 2 3   END HALT
EM 1 1.   EM 2 1.   ESTIFF 1 0. 1e5   ESTIFF 2 0. 1.   XF 5 0. 0.5   ITERSTEP 10 4 1e-9   END END
"""


def asked(text, variable, mode=7):
    deck = parse_deck(text, mode=mode)
    trade = Trade(mode, deck, (quantity(variable),), repeats=1)
    values = np.array([quantity(variable).series(spacar.run(mode, refine(deck, 8), beams="angle"))])
    ref = Reference(values, np.abs(values).max(axis=1), 0.0, "")
    found = TradeSearch(trade, 0.1, reference=ref, goal=0.1, tried=[Setup()])
    found.run(Setup(), 60.0, 1)
    return found


def test_the_stiff_beam_is_named_and_the_soft_one_is_needed():
    """Deflection of the tip: without beam 1 it falls by some 1e-5 of itself, without beam 2 by all."""
    study = asked(ARM, "x[5,2]")
    found, ref = {p.what: p for p in simplify(study)}, study.reference
    one = spacar.run(7, rigid(study.trade.deck, (1,))).node(5, 2)
    error = np.abs(one - ref.values[0]).max() / ref.amplitude[0]
    assert found["the flexibility of beam 1"].error == pytest.approx(error)
    assert found["the flexibility of beam 1"].line(0.1).startswith("not needed for 0.1: the flexibility of beam 1")
    assert found["the flexibility of beam 2"].line(0.1).startswith("needed: the flexibility of beam 2")


def test_rigid_beams_have_no_flexibility_to_leave_out():
    study = asked(ARM, "x[5,2]")
    assert list(variations(study.trade, Setup(beams="rigid"))) == []


def test_nothing_is_looked_at_when_the_time_is_used():
    study = asked(ARM, "x[5,2]")
    study.budget = 0.0
    assert simplify(study) == []


def test_merging_undoes_refinement(deck):
    """crankfl with two beams in the place of each, merged: the model of the file, to the last digit of its motion."""
    given = deck("crankfl", 1)
    back, nodes = merged(refine(given, 2))
    assert len(nodes) == 2
    a, b = (spacar.run(1, d, duration=0.005, n_steps=5) for d in (given, back))
    np.testing.assert_array_equal(a.node(8, 1), b.node(8, 1))


def test_what_is_different_is_not_merged():
    """Other stiffness, a mass at the node, an angle between the axes."""
    alike = ARM.replace("1e5", "1.")
    assert merged(parse_deck(alike, mode=7))[1] == [3]
    for text in (
        ARM,
        alike.replace("XF 5", "XM 3 1.\nXF 5"),
        alike.replace("X 3 0.5 0.", "X 3 0.5 0.01"),
        alike.replace("DYNE 2 2 3", "DYNE 2 2 3\nLDEFORM 2"),
        alike.replace("EM 1", "STARTDE 1 2 0.1\nEM 1"),
    ):
        with pytest.raises(UsageError, match="no two beams in one line"):
            merged(parse_deck(text, mode=7))


def test_trade_tells_the_prices(call):
    Path("arm.dat").write_text(ARM)
    done = call.done("trade", "arm", "--mode", "7", "--target", "1e-2", "--budget", "30", "--variable", "x[5,2]")
    assert "not needed for 0.01: the flexibility of beam 1" in done.out
    assert "needed: the flexibility of beam 2" in done.out
    report = json.loads(call("trade", "arm", "-m", "7", "--target", "1e-2", "--variable", "x[5,2]", "--json").out)
    assert {"what", "how", "error", "seconds"} <= set(report["prices"][0])
