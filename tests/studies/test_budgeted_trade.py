"""`spacar trade` without lists of settings: within a budget, stopped where dominated, with a command to run."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from models import STIFF_AND_SOFT_ARM

import spacar
from spacar.deck import parse_deck
from spacar.deck.rewrite.coarser import merged
from spacar.deck.rewrite.refine import refine, rigid
from spacar.errors import AnalysisError, UsageError
from spacar.studies.policies import budget as budgeted
from spacar.studies.policies.budget import TradeSearch
from spacar.studies.policies.mesh import MeshSearch
from spacar.studies.policies.simplification import simplify, variations
from spacar.studies.policies.trade import Reference
from spacar.studies.runs.compared import row_values
from spacar.studies.runs.quantities import quantity
from spacar.studies.runs.setting import Job, Setup, Trade, run_setup

from .oscillator import OSCILLATOR


@pytest.fixture
def trade():
    return Trade(1, parse_deck(OSCILLATOR, mode=1), (quantity("x[2,1]"),), repeats=1)


def test_the_recommended_command_keeps_the_target(call):
    """Against x = 1 + 0.01 cos 20 t, run as it was recommended."""
    Path("osc.dat").write_text(OSCILLATOR)
    done = call.done("trade", "osc", "--target", "1e-4", "--budget", "20", "--variable", "x[2,1]", "--json")
    found = json.loads(done.out)
    words = shlex.split(found["command"])
    assert words[:3] == ["spacar", "1", "osc.dat"]
    assert call(*words[1:], "-q").status == 0
    words = [w for w in words[3:] if w not in ("--general", "--compiled")]
    options = dict(zip(words[::2], words[1::2], strict=True))
    numbers = {"integrator": int(options["--integrator"]), "rtol": float(options["--rtol"])}
    result = spacar.run(1, "osc.dat", atol=float(options["--atol"]), **numbers)
    error = np.abs(result.node(2, 1) - 1.0 - 0.01 * np.cos(20.0 * result.t)).max() / 0.02
    assert error <= 1.1e-4


def test_a_method_stops_when_it_is_accurate_enough(trade):
    """No setting is tried whose looser one of the same method is within the target."""
    found = budgeted.search(trade, 1e-4, 20.0)
    assert found.reference is not None
    assert found.reference.error < 1e-5  # a tenth of the target
    tightest = {}
    for setup in found.tried:
        tightest[setup.integrator] = setup.tolerance
    assert set(tightest) == set(budgeted.METHODS)
    assert min(tightest.values()) > 1e-7


def test_the_budget_ends_the_search():
    """Nothing is left of a budget that the reference uses: no setting, and it is said how many were not tried. The
    motion is short, as the reference has a tenth of a second at least, also without the compiled engine."""
    short = parse_deck(OSCILLATOR.replace("TIMESTEP 0.4 8", "TIMESTEP 0.05 2"), mode=1)
    found = budgeted.search(Trade(1, short, (quantity("x[2,1]"),), repeats=1), 1e-4, 1e-3)
    assert not found.tried
    assert found.skipped > 3


STIFF = STIFF_AND_SOFT_ARM.replace("ESTIFF 1 0. 1e4", "ESTIFF 1 0. 1e9").replace("TIMESTEP 0.5 5", "TIMESTEP 0.5 1")


ARM = Trade(1, parse_deck(STIFF_AND_SOFT_ARM, mode=1), (quantity("x[5,2]"),), repeats=1)


def test_a_run_is_stopped_between_outputs():
    """853 follows a vibration of 1e5 rad/s for seconds; between two outputs too the time is asked for."""
    trade = Trade(1, parse_deck(STIFF, mode=1), (quantity("x[5,2]"),), repeats=1)
    row = run_setup(Job(trade, Setup(integrator=853, tolerance=1e-8), limit=0.2))
    assert row["stopped"]
    assert "at t = 0.5:" not in row["reason"]


def test_without_time_for_a_second_mesh(monkeypatch):
    """The mesh of the user is compared, and that the error of the mesh is not known is said."""

    def stopped(*_):
        raise AnalysisError("stopped", "study.stopped")

    monkeypatch.setattr(MeshSearch, "_divided", stopped)
    found = budgeted.search(ARM, 1e-3, 10.0)
    assert found.reference is not None
    assert "error of the mesh is not known" in found.reference.text
    assert found.best.setup.measure == "angle"


def test_nothing_follows_from_a_reference_that_is_far_off(monkeypatch):
    known = budgeted.reference
    monkeypatch.setattr(budgeted, "reference", lambda *a: (known(*a)[0]._replace(error=0.2), []))
    with pytest.raises(AnalysisError, match=r"an error of 0.2 .* more --budget"):
        budgeted.search(ARM, 1e-2, 10.0)


def test_a_run_is_stopped_at_its_limit(trade):
    row = run_setup(Job(trade, Setup(integrator=155, tolerance=1e-8), limit=1e-9))
    assert row["status"] == "failed"
    assert row["stopped"]
    assert row["reason"].startswith("stopped at t = 0")


def test_progress_says_what_runs_and_the_time_to_go(trade):
    told = []
    budgeted.search(trade, 1e-3, 20.0, lambda what, left: told.append((what, left)))
    assert [what for what, _ in told[:2]] == ["the reference", "as given -1 tol 0.01"]
    assert all(0.0 < left <= 20.0 for _, left in told)


# A flexible rod of one beam that swings out of the horizontal: its mesh matters at 1e-3.
ROD = """
PLBEAM 1 1 2 3 4   X 3 1. 0.   FIX 1   FIX 2   DYNE 1 2 3   END HALT
EM 1 1.   ESTIFF 1 0. 2.   GRAVITY 0. -1.   TIMESTEP 2. 10   END END
"""


@pytest.mark.slow
def test_a_motion_is_compared_with_finer_meshes(call):
    """The recommended setting, run as it stands, is as accurate as asked against 8 beams with another method; the one
    beam of the file is not. Command and options say the same."""
    Path("rod.dat").write_text(ROD)
    variables = ["x[3,1]", "x[3,2]", "x[4,1]"]
    answer = spacar.trade("rod.dat", target=1e-2, repeats=1, variables=variables)
    assert answer.options["elements"] > 1
    words = shlex.split(answer.command)
    assert words[:5] == ["spacar", "1", "rod.dat", "--elements", str(answer.options["elements"])]
    assert call(*words[1:], "-q").status == 0
    fine = spacar.run(1, refine(parse_deck(ROD, mode=1), 8), beams="angle", integrator=595, rtol=1e-4, atol=1e-5)
    found, given = spacar.run(1, "rod.dat", **answer.options), spacar.run(1, "rod.dat")
    errors = []
    for node, coordinate in ((3, 1), (3, 2), (4, 1)):
        truth = fine.node(node, coordinate)
        assert np.abs(found.node(node, coordinate) - truth).max() <= 1e-2 * np.ptp(truth)
        errors.append(np.abs(given.node(node, coordinate) - truth).max() / np.ptp(truth))
    assert max(errors) > 1e-2


def test_what_cannot_be_divided_is_named(call):
    """A flexible tube: its mesh is not compared, and that is said."""
    Path("tube.dat").write_text(ROD.replace("PLBEAM", "PLTUBE").replace("TIMESTEP 2. 10", "TIMESTEP 0.2 2"))
    done = call.done("trade", "tube", "--target", "1e-3", "--repeats", "1", "--budget", "20")
    assert "the error of the mesh of beam 1 is not known: it cannot be divided: a tube is not divided" in done.out


def test_a_lost_frequency_is_no_saving():
    """A flexible arm in mode 7, by default: without the flexibility of the arm its frequencies are not there."""
    answer = spacar.trade(parse_deck(ROD.replace("TIMESTEP 2. 10", "ITERSTEP 10 2 1e-9"), mode=7), 1e-3, repeats=1)
    assert answer.best is not None
    assert any("eigenvalue" in name for name in answer.reference.names)
    assert any(name.startswith("reaction at") for name in answer.reference.names)


# A pendulum whose rod is stiff: hardly bent.
STIFF_PENDULUM = """
PLBEAM 1 1 2 3 4   X 3 1. 0.   FIX 1   DYNX 2 1   DYNE 1 2 3   END HALT
EM 1 1.   ESTIFF 1 0. 2000.   GRAVITY 0. -9.81   TIMESTEP 0.3 3   END END
"""


def test_rigid_beams_are_recommended_where_they_are_enough(call):
    """The line runs as it stands; a rigid rod turns by phi'' = -1.5 g cos(phi), and the target is kept against it."""
    from scipy.integrate import solve_ivp

    Path("rod.dat").write_text(STIFF_PENDULUM)
    answer = spacar.trade("rod.dat", target=1e-3, budget=15.0, repeats=1, variables=["x[3,1]", "x[3,2]"])
    assert answer.options["rigid_beams"]
    words = shlex.split(answer.command)
    assert "--rigid" in words
    assert call(*words[1:], "-q").status == 0
    result = spacar.run(1, "rod.dat", **answer.options)
    exact = solve_ivp(lambda _, y: (y[1], -1.5 * 9.81 * np.cos(y[0])), (0.0, 0.3), (0.0, 0.0), rtol=1e-10, atol=1e-12)
    assert result.node(3, 2)[-1] == pytest.approx(np.sin(exact.y[0, -1]), abs=1e-3)


def test_a_stiff_beam_is_left_out(call):
    """The recommended model has a rigid first arm, and its file runs as the last line says; the target is kept against
    four beams in the place of each."""
    Path("arm.dat").write_text(STIFF_AND_SOFT_ARM)
    Path("arm.trade.dat").write_text("of somebody else")
    words = ("--target", "5e-2", "--budget", "20", "--repeats", "1", "--variable", "x[5,2]", "--json")
    found = json.loads(call("trade", "arm", *words).out)
    words = shlex.split(found["command"])
    assert found["recommended"]["beams"] == "rigid 1"
    assert words[2] == "arm.trade.dat"
    assert "DYNE 1" not in Path("arm.trade.dat").read_text()
    assert Path("arm.trade.dat.bak").read_text() == "of somebody else"
    assert call(*words[1:], "-q").status == 0
    options = dict(zip(words[3::2], words[4::2], strict=False))
    numbers = {"integrator": int(options["--integrator"]), "rtol": float(options["--rtol"])}
    numbers |= {"atol": float(options["--atol"]), "elements": int(options.get("--elements", "1"))}
    result = spacar.run(1, "arm.trade.dat", beams=options.get("--beams"), **numbers)
    finer = refine(parse_deck(STIFF_AND_SOFT_ARM, mode=1), 4)
    fine = spacar.run(1, finer, beams="angle", integrator=595, rtol=1e-5, atol=1e-6)
    truth = fine.node(5, 2)
    assert np.abs(result.node(5, 2) - truth).max() <= 5e-2 * np.ptp(truth)


def test_the_best_that_is_reached():
    """An error that no run reaches: the answer says what can be had, and recommends for that."""
    short = parse_deck(OSCILLATOR, mode=1)
    answer = spacar.trade(short, target=1e-16, budget=10.0, repeats=1, variables=["x[2,1]"])
    assert 1e-16 < answer.reached < 1e-9
    assert answer.best is not None
    assert f"--integrator {answer.options['integrator']}" in answer.command
    assert 3 <= len(repr(answer).splitlines()) <= 10
    result = spacar.run(1, short, **answer.options)
    error = np.abs(result.node(2, 1) - 1.0 - 0.01 * np.cos(20.0 * result.t)).max() / 0.02
    assert error <= answer.reached
    assert "none of the settings is known to be accurate enough" in repr(answer)


def test_a_beam_without_inertia_against_torsion(deck):
    """The end of its beam carries what turns in screw; a part in between would have no inertia. That is said, and the
    integration alone is compared."""
    short = {"duration": 0.1, "n_steps": 2}
    found = budgeted.search(Trade(1, deck("screw", 1), (quantity("x[3,1]"),), 1, short), 1e-3, 10.0)
    assert "no inertia on the motion of element 3 (BEAM) e2 torsion" in found.undivided[3]
    assert found.best is not None
    assert found.best.error + found.reference.error <= 1e-3


# What a model could do without, with its price; pairs of alike beams as one.
# A stiff rod (1e6 times) carries a soft one; the soft one vibrates.
PRICED_ARM = """
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
    study = asked(PRICED_ARM, "x[5,2]")
    found, ref = {p.what: p for p in simplify(study)}, study.reference
    one = spacar.run(7, rigid(study.trade.deck, (1,))).node(5, 2)
    error = np.abs(one - ref.values[0]).max() / ref.amplitude[0]
    assert found["the flexibility of beam 1"].error == pytest.approx(error)
    assert found["the flexibility of beam 1"].line(0.1).startswith("not needed for 0.1: the flexibility of beam 1")
    assert found["the flexibility of beam 2"].line(0.1).startswith("needed: the flexibility of beam 2")


def test_where_there_is_nothing_to_price():
    """Rigid beams have no flexibility to leave out; nothing is looked at when the time is used."""
    study = asked(PRICED_ARM, "x[5,2]")
    assert list(variations(study.trade, Setup(beams="rigid"))) == []
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
    alike = PRICED_ARM.replace("1e5", "1.")
    assert merged(parse_deck(alike, mode=7))[1] == [3]
    for text in (
        PRICED_ARM,
        alike.replace("XF 5", "XM 3 1.\nXF 5"),
        alike.replace("X 3 0.5 0.", "X 3 0.5 0.01"),
        alike.replace("DYNE 2 2 3", "DYNE 2 2 3\nLDEFORM 2"),
        alike.replace("EM 1", "STARTDE 1 2 0.1\nEM 1"),
    ):
        with pytest.raises(UsageError, match="no two beams in one line"):
            merged(parse_deck(text, mode=7))


def test_trade_tells_the_prices(call):
    Path("arm.dat").write_text(PRICED_ARM)
    done = call.done("trade", "arm", "--mode", "7", "--target", "1e-2", "--budget", "30", "--variable", "x[5,2]")
    assert "not needed for 0.01: the flexibility of beam 1" in done.out
    assert "needed: the flexibility of beam 2" in done.out
    report = json.loads(call("trade", "arm", "-m", "7", "--target", "1e-2", "--variable", "x[5,2]", "--json").out)
    assert {"what", "how", "error", "seconds"} <= set(report["prices"][0])


def test_two_variables_of_one_name_keep_their_values() -> None:
    row = {"names": ["a", "a"], "values": [[1.0, 2.0], [3.0, 4.0]]}
    np.testing.assert_array_equal(row_values(row, ("a", "a")), row["values"])
