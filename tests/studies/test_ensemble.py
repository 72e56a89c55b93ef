"""Batches: what is refused, and that a failing case does not harm the others; test_wheels_in_lanes.py compares them
with single runs."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.compiled.library import why_off
from spacar.errors import UsageError
from spacar.studies.assignments import axis, change, setting
from spacar.studies.batched_cases import reason
from spacar.studies.ensemble import why_not
from spacar.studies.policies.sweep import Study
from spacar.studies.runs.quantities import quantity
from spacar.studies.side_by_side import alike
from tests.ensembles import ensemble

ROBOT = {"duration": 0.3, "n_steps": 3}
LANES = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))


@LANES
def test_frames_are_made_when_they_are_asked_for(deck):
    result = ensemble(2 * [deck("robotsim", 1)], integrator=853, duration=0.1, n_steps=2)[1]
    assert [f.t for f in result.frames] == [0.0, 0.05, 0.1]
    assert np.array_equal(result.frames[1].sig, result["sig"][1])
    assert np.array_equal(result.node(8, 3), result["x"][:, result.mechanism.numbering.x_index(8, 3)])
    assert sum(frame.statistics["rhs"] for frame in result.frames) > 0


@LANES
def test_a_case_near_a_dead_point_is_left_to_a_single_run():
    """A falling slider-crank with the slider as degree of freedom: it has to be followed alone, which explains."""
    kinematics = ["PLBEAM 1 1 2 3 4", "PLBEAM 2 3 5 6 7", "X 3 0.15 0.1", "X 6 0.45 0.", "FIX 1", "FIX 6 2", "DYNX 6 1"]
    dynamics = ["XM 6 0.03", "EM 1 0.2", "EM 2 0.2", "GRAVITY 0. -9.81", "STARTDX 6 1 0.45 1.", "TIMESTEP 1. 10"]
    deck = spacar.parse_deck("\n".join([*kinematics, "END", "HALT", *dynamics, "END", "END", ""]), mode=1)
    assert ensemble([deck, deck]) == [None, None]


@LANES
def test_normalizations_of_every_case_are_found(deck):
    """The last fixed deformations of a spatial model belong to nodes; they are zero to rounding in every case."""
    base = deck("robotsim", 1)
    result = ensemble([base, base, base], **ROBOT)
    rows = [row for _, row in result[0].mechanism.numbering.normalization]
    assert len(rows) == 6
    for r in result:
        assert np.abs(r["e"][:, rows]).max() < 1e-10
        assert np.abs(r["x"] - result[0]["x"]).max() < 1e-12  # pivots of the band need not be the same


@LANES
def test_what_is_alike(deck):
    base = deck("robotsim", 1)
    assert alike(base, change(base, [setting("XM.8")], [1.0]))
    heavy = spacar.parse_deck(base.text.replace("XM 5", "GRAVITY 0 0 -9.81\nXM 5"), mode=1)
    light = change(heavy, [setting("GRAVITY[3]")], [-1.62])
    assert not alike(base, heavy)
    assert not alike(heavy, light)
    with pytest.raises(UsageError, match="differ in more than numbers"):
        ensemble([heavy, light], **ROBOT)


@pytest.mark.parametrize(
    ("name", "options", "why"),
    [
        ("robotsim", {}, "no TIMESTEP"),
        ("robotsim", {**ROBOT, "integrator": 430}, "implicit"),
        ("robotsim", {**ROBOT, "integrator": 553}, "implicit"),
        ("robotsim", {**ROBOT, "integrator": 220}, "method 220 runs alone"),
        ("robotsim", {**ROBOT, "integrator": 225}, "method 225 runs alone"),
        ("crank", {}, "nothing is integrated"),
    ],
)
def test_what_has_no_batch(deck, name, options, why):
    assert re.search(why, why_not(deck(name, 1), **options))
    with pytest.raises(UsageError, match=why):
        ensemble(2 * [deck(name, 1)], **options)


@pytest.mark.parametrize("given", ["FIX 3", ""])  # one condition too many, one too few
def test_an_ill_defined_mechanism_has_no_batch(given):
    text = f"PLTRUSS 1 1 2 PLTRUSS 2 2 3 X 2 1 0 X 3 2 0 FIX 1 {given} DYNX 2 1 END HALT XM 2 1 TIMESTEP 1 2 END END"
    assert "differ in number" in why_not(spacar.parse_deck(text, mode=1))


@LANES
def test_user_functions_have_batches():
    scenarios = Path(__file__).parents[2] / "benchmarks" / "peers" / "scenarios"
    assert not why_not(spacar.read_deck(scenarios / "S4.dat", 1))


def sweep_words(*more):
    return ("sweep", "robotsim", "--time", "0.1", "--steps", "2", "--rtol", "1e-7", "--atol", "1e-7",
            "-r", "z: x[8,3]@end", *more)  # fmt: skip


def column(path, name):
    with Path(path).open(newline="") as file:
        return {r["XM.8"]: r[name] for r in csv.DictReader(file)}


@LANES
def test_sweep_with_and_without_batches(call):
    words = sweep_words("--set", "XM.8=20:40:6")
    assert call(*words, "--batch", "-o", "a.csv").status == 0
    assert call(*words, "--no-batch", "-o", "b.csv").status == 0
    general = call.done(*words, "--general", "-o", "c.csv")
    assert "one by one, not in batches: --general" in general.out
    assert call(*words, "--batch", "--general", "-o", "d.csv").status == 2
    alone = column("b.csv", "z")
    for together in (column(name, "z") for name in ("a.csv", "c.csv")):
        assert together.keys() == alone.keys()
        assert all(abs(float(together[m]) - float(alone[m])) < 1e-6 for m in alone)


def test_every_case_runs_once(call):
    call.done(*sweep_words("--set", "XM.8=20:40:20", "-o", "c.csv"))
    assert len(column("c.csv", "z")) == 20


@LANES
def test_a_failing_case_fails_alone(call):
    """A beam of length zero is a failed row, the others are right."""
    words = sweep_words("--set", "X.8[coordinate x1]=0.5,0.268,0.55", "--set", "X.8[coordinate x3]=0,0.6467")
    call.refused(*words, "--batch", "-o", "d.csv", status=1)
    rows = list(csv.DictReader(Path("d.csv").read_text().splitlines()))
    bad = [r for r in rows if r["status"] == "failed"]
    assert len(rows) == 6
    assert [(r["X.8[coordinate x1]"], r["X.8[coordinate x3]"]) for r in bad] == [("0.268", "0.6467")]
    assert bad[0]["reason"]


def test_batch_that_is_not_possible(call):
    assert "nothing is integrated" in call.refused("sweep", "crank", "--set", "XM.6=1,2", "-r", "x[6,1]@end", "--batch")


def test_reason_of_another_mode(deck):
    study = Study(7, deck("plbeam5", 7), (axis("XF.11[Fy]=1").setting,), (quantity("x[11,2]@end"),))
    assert "mode 1" in reason(study, (1.0,))[0]
