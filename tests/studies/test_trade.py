"""`spacar trade`: errors, reference and recommendation against closed forms; restart; what is refused."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest

from spacar.compiled.library import why_off
from spacar.deck import Deck, parse_deck
from spacar.errors import UsageError
from spacar.studies.policies.trade import assess, recommend, reference, reference_setups
from spacar.studies.runs.mesh_ladder import extrapolate
from spacar.studies.runs.quantities import quantity
from spacar.studies.runs.setting import Job, Trade, run_setup, setups

from .oscillator import OSCILLATOR


def oscillator_error(result_row):
    """Error of x = 1 + 0.01 cos 20 t, omega = sqrt(200 / (1 * 0.5)), relative to the span of the exact values."""
    t = np.linspace(0.0, 0.4, 9)
    exact = 1.0 + 0.01 * np.cos(20.0 * t)
    return np.abs(np.array(result_row["values"][0]) - exact).max() / np.ptp(exact)


@pytest.fixture(scope="module")
def oscillator():
    trade = Trade(1, parse_deck(OSCILLATOR, mode=1), (quantity("x[2,1]"),), repeats=1)
    cases = setups(trade, (0, 155, 140), (1e-4, 1e-6), (4, 16))
    wanted = reference_setups(trade, (1,), 1e-7)
    rows = [run_setup(Job(trade, s)) for s in dict.fromkeys([*wanted, *cases])]
    return trade, cases, rows, reference(trade, rows, wanted)


def test_errors_are_true_errors(oscillator):
    """Against cos: the error that the study states is the true one to within that of its reference."""
    trade, cases, rows, ref = oscillator
    assert ref.error < 1e-8  # tolerance 1e-9 of the position 1, over the span 0.02
    by_key = {r["case"]: r for r in rows}
    entries = assess(trade, rows, cases, ref)
    assert len(entries) == 2 + 2 + 2
    for entry in entries:
        truth = oscillator_error(by_key[trade.key(entry.setup)])
        assert entry.error == pytest.approx(truth, abs=2 * ref.error + 1e-9)  # 1e-9: rounding of both references
        assert entry.rhs > 20


def test_the_recommendation_is_the_cheapest_that_is_good_enough(oscillator):
    trade, cases, rows, ref = oscillator
    entries = assess(trade, rows, cases, ref)
    best = recommend(entries, 1e-5, ref)
    assert best.error + ref.error <= 1e-5
    assert all(e.seconds >= best.seconds for e in entries if e.error + ref.error <= 1e-5)
    assert recommend(entries, 1e-16, ref) is None


def test_fixed_steps_have_their_order(oscillator):
    """Kutta's method of order 4: four times as many steps, 256 times less error (within 30 %, higher terms)."""
    trade, cases, rows, ref = oscillator
    error = [e.error for e in assess(trade, rows, cases, ref) if e.setup.integrator == 140]
    assert error[0] / error[1] == pytest.approx(256, rel=0.3)


def test_extrapolation_of_an_exact_expansion():
    """u + c h^2 + d h^4 is extrapolated to u, with rounding only."""
    u, c, d = np.random.default_rng(0).normal(size=(3, 2, 5))
    levels = [u + c * h**2 + d * h**4 for h in (0.1, 0.05, 0.025)]
    result = extrapolate(levels, np.ones(2))
    assert np.allclose(result.values, u, rtol=0, atol=1e-14)
    assert (result.order == 2).all()
    assert np.abs(result.values - u).max() <= result.error


def test_no_extrapolation_without_an_order():
    a, b, c = np.array([[0.0]]), np.array([[1.0]]), np.array([[1.9]])
    result = extrapolate([a, b, c], np.ones(1))
    np.testing.assert_array_equal(result.values, c)
    assert result.error == pytest.approx(0.9)
    assert result.orders() == "1 not"


def elastica_tip(load: float) -> tuple[float, float]:
    """Tip of an inextensible cantilever, l = EI = 1, dead load across it: theta'' = -load cos(theta)."""
    from scipy.integrate import solve_bvp

    s = np.linspace(0, 1, 41)

    def rates(_, y):
        return np.vstack((y[1], -load * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])))

    def ends(a, b):
        return np.array([a[0], b[1], a[2], a[3]])

    solution = solve_bvp(rates, ends, s, np.vstack((0.5 * s, 1 - s, s, 0.2 * s)), tol=1e-10, max_nodes=100000)
    assert solution.success
    return solution.y[2, -1], solution.y[3, -1]


def test_meshes_against_the_elastica():
    """A strongly bent cantilever: stated errors are true errors, estimates bound them, extrapolation gains digits."""
    deck = Deck.build(
        [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0, 0.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1, 2, 3)],
        [("EM", 1, 1.0), ("ESTIFF", 1, 0.0, 1.0), ("XF", 3, 0.0, 3.0)],
        mode=7,
    )
    trade = Trade(7, deck, (quantity("x[3,1]@end"), quantity("x[3,2]@end")), repeats=1)
    meshes = (3, 6, 12)
    cases, wanted = setups(trade, (), (), (), meshes), reference_setups(trade, meshes, 1e-6)
    rows = [run_setup(Job(trade, s)) for s in dict.fromkeys([*wanted, *cases])]
    ref = reference(trade, rows, wanted)
    truth = np.array(elastica_tip(3.0))

    def error(values):
        return np.max(np.abs(np.asarray(values)[:, 0] - truth) / truth)

    assert error(ref.values) <= ref.error < 1e-5
    by_key = {r["case"]: r for r in rows}
    entries = assess(trade, rows, cases, ref)
    for entry in entries[:3]:
        assert entry.error == pytest.approx(error(by_key[trade.key(entry.setup)]["values"]), rel=1e-2)
    extrapolated = entries[3]
    assert extrapolated.setup is None
    assert extrapolated.error <= extrapolated.estimate
    assert extrapolated.error < 1e-2 * entries[2].error


TRADE = ("trade", "crank", "--time", "0.01", "--steps", "4", "-i", "0,155", "-t", "1e-4,1e-6", "--repeats", "1")


@pytest.fixture
def pendulum():
    """A single rod as a pendulum."""
    Path("pendulum.dat").write_text(
        "PLBEAM 1 1 2 3 4\nX 3 1. 0.\nFIX 1\nDYNX 2 1\nEND HALT\nEM 1 1.\nGRAVITY 0. -9.81\nTIMESTEP 0.5 5\nEND END\n"
    )


def test_command_table_and_restart(call, pendulum):
    words = ("trade", "pendulum", "-i", "0,155", "-t", "1e-4,1e-6", "--repeats", "1")
    files = ("-o", "t.csv", "-o", "t.svg")
    done = call(*words, *files)
    assert (done.status, done.err) == (0, "")
    assert "cheapest for an error of 1e-06" in done.out
    assert "estimated error" in done.out
    table = list(csv.DictReader(Path("t.csv").read_text().splitlines()))
    assert [(r["integrator"], r["tolerance"]) for r in table] == [
        ("0", "0.0001"), ("0", "1e-06"), ("155", "0.0001"), ("155", "1e-06"),
    ]  # fmt: skip
    assert Path("t.svg").read_text().startswith("<?xml")
    rows = Path("t.csv.rows.jsonl").read_text()
    assert rows.count("\n") == 6
    call(*words, "-o", "t.csv")
    assert Path("t.csv.rows.jsonl").read_text() == rows  # nothing was run again
    Path("t.csv.rows.jsonl").write_text("\n".join(rows.splitlines()[:3]) + '\n{"ca')  # killed
    call(*words, "-o", "t.csv")
    assert Path("t.csv.rows.jsonl").read_text().count("\n") == 6


def test_command_json(call, pendulum):
    done = call("trade", "pendulum", "-i", "155", "-t", "1e-6", "--target", "1e-5", "--json", "--repeats", "1",
                "--variable", "x[3,2]")  # fmt: skip
    found = json.loads(done.out)
    assert found["recommended"]["integrator"] == 155
    assert found["settings"][0]["error"] < 1e-5
    assert found["reference"]["error"] < 1e-7


@pytest.mark.slow
def test_models_of_a_flexible_mechanism(call):
    """A rigid rod is a model with an error of its own, larger than that of integration."""
    call.done("trade", "crankfl", "--time", "0.002", "--steps", "2", "-i", "853", "-t", "1e-3",
                "--target", "1e-3", "--rigid", "--linear",
                "--repeats", "1", "--variable", "x[6,2]", "-j", "2", "-o", "m.json")  # fmt: skip
    found = {s["model"]: s["error"] for s in json.loads(Path("m.json").read_text())["settings"]}
    assert found["as given"] < 1e-3 < found["rigid beams"]
    assert found["as given"] < found["as given, linear strain"] < 1.0


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("crankfl", "-i", "999"), "integrator 999 does not exist"),
        (("crankfl", "-t", "0,1"), "must be positive"),
        (("crankfl", "--elements", "1.5"), "whole numbers"),
        (("crankfl", "--elements", "0"), "1 or more elements"),
        (("crankfl", "-m", "2"), "trade runs modes 1, 7, 8, 9, 10"),
        (("crankfl", "-o", "p.gif"), "must end with"),
        (("crankfl", "-o", "t.txt"), "must end with .csv"),
        (("crankfl", "--variable", "y"), "not known"),
        (("crank", "--elements", "1,2"), "no flexible PLBEAM or BEAM"),
        (("crank", "--rigid"), "no beam with dynamic deformations"),
        (("crank", "-m", "7"), "without flexible beams"),
        (("robotsim",), "free coordinates|TIMESTEP|without flexible"),
    ],
)
def test_wrong_usage(call, words, why):
    err = call.refused("trade", *words)
    assert re.search(why, err), err


def test_a_motion_without_dynamics_has_nothing_to_trade(call):
    """The prescribed crank is exact at every tolerance: every error is rounding."""
    done = call(*TRADE, "--json")
    assert all(s["error"] < 1e-12 for s in json.loads(done.out)["settings"])


def test_failed_settings_are_told(call):
    """Fixed implicit steps far too long still give a row; a method that fails is a row with its reason."""
    Path("stiff.dat").write_text(OSCILLATOR.replace("ESTIFF 1 200.", "ESTIFF 1 200.\nEDAMP 1 1e6"))
    words = ("-i", "140,430", "--substeps", "1", "--repeats", "1", "--time", "0.001", "--steps", "2")
    done = call("trade", "stiff", *words)
    assert done.status in (0, 1)
    assert "Traceback" not in done.err


def test_the_methods_of_the_reference_can_be_chosen(deck):
    trade = Trade(1, deck("crankfl", 1), ())
    wanted = reference_setups(trade, (1,), 1e-4, (595, 553))
    assert [s.integrator for s in wanted] == [595, 553]
    for wrong in ((853, 853), (853, 430), (853, 1)):
        with pytest.raises(UsageError, match="two different methods with variable step"):
            reference_setups(trade, (1,), 1e-4, wrong)


@pytest.mark.slow
@pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
def test_compiled_runs_give_the_same_errors(call):
    words = ("trade", "robotsim", "--time", "0.1", "--steps", "2", "-t", "1e-3,1e-5", "-i", "155", "--json")
    errors = []
    for more in (("--general",), ("--compiled",)):
        done = call.done(*words, *more)
        errors.append([row["error"] for row in json.loads(done.out)["settings"]])
    # the paths guess positions differently and leave them at a part of the tolerance: the errors agree in size only
    assert np.allclose(*errors, rtol=0.2)


def test_a_wrong_reference_is_refused_before_anything_runs(call):
    err = call.refused("trade", "robotsim", "--time", "0.1", "--steps", "2", "--reference", "853,430")
    assert "two different methods with variable step" in err
