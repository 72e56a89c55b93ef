"""Sweeps in lanes: one that cannot be followed takes its block along
to single runs and no other one, threads change nothing, and what is done is kept when the rest is interrupted."""

import csv
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.compiled.library import lanes_of_processor, why_off
from spacar.studies import batched_cases
from spacar.studies import ensemble as studies_ensemble
from spacar.studies.affine_cases import FEWEST, affine_cases
from spacar.studies.assignments import change, setting
from spacar.studies.ensemble import why_not
from spacar.studies.runs import workers
from tests.ensembles import ensemble, followed
from tests.examples import DATA

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))

OPTIONS = {"duration": 0.3, "n_steps": 3, "rtol": 1e-7, "atol": 1e-7}


@pytest.fixture(scope="module")
def robot():
    return spacar.read_deck(DATA / "robotsim.dat", 1)


@pytest.fixture(scope="module")
def decks(robot):
    """Two blocks and one case."""
    return [change(robot, [setting("XM.8")], [m]) for m in np.linspace(20.0, 40.0, 2 * lanes_of_processor() + 1)]


def test_belts_that_start_turns_away():
    """The turns of a belt in one case are not those of another one: alone, or the exact start stress -EA/l r_q phi."""
    text = "PLBELT 1 1 2 3 4 .05 {} X 3 .5 0 FIX 1 FIX 2 FIX 3 DYNX 4 RLSE 1 END HALT ESTIFF 1 1e3 XM 4 .01"
    text += " STARTDX 4 1 30 0 TIMESTEP .1 2 END END"
    radii = (0.049, 0.0499, 0.05, -0.03, 0.3)
    for r, result in zip(radii, ensemble([spacar.parse_deck(text.format(r), mode=1) for r in radii]), strict=True):
        exact = -1e3 / np.sqrt(0.25 - (0.05 - r) ** 2) * r * 30
        assert result is None or result["sig"][0] == pytest.approx(exact, rel=1e-12)


def test_threads_change_nothing(decks):
    one, two = (ensemble(decks, threads=k, **OPTIONS) for k in (1, 2))
    for a, b in zip(one, two, strict=True):
        assert np.array_equal(a["x"], b["x"])


@pytest.mark.parametrize("targets", [("XM.8",), ("X.8[coordinate x1]", "EM.4")])
def test_a_block_knows_nothing_of_the_blocks_before_it(robot, targets):
    """Numbers that go into a model in C leave nothing of the ones before, to the last digit; the orders of pivots are
    those of the first block."""
    n = lanes_of_processor()
    values = np.random.default_rng(3).uniform(0.95, 1.05, (3 * n, len(targets)))
    sizes = {"XM.8": 30.0, "X.8[coordinate x1]": 0.5, "EM.4": 4.0}
    settings = [setting(t) for t in targets]
    decks = [change(robot, settings, [sizes[t] * v for t, v in zip(targets, row, strict=True)]) for row in values]
    third, second = ensemble(decks, **OPTIONS)[2 * n :], ensemble(decks[:n] + decks[2 * n :], **OPTIONS)[n:]
    for a, b in zip(third, second, strict=True):
        for name in ("x", "xdd", "sig", "fxtot"):
            assert np.array_equal(a[name], b[name]), name


def test_rows_without_a_file_touch_no_file(robot, monkeypatch):
    def opened(*_, **__):
        raise AssertionError("a file was opened")

    monkeypatch.setattr(Path, "open", opened)
    rows = spacar.sweep(robot, {"XM.8": [25.0, 30.0]}, "z: x[8,3]@end", **OPTIONS)
    assert [row["status"] for row in rows] == 2 * ["done"]


PENDULUM = """PLTRUSS 1 1 2   X 2 0. -1.   FIX 1   DYNX 2 1   END HALT
XM 2 1.   GRAVITY 0. -10.   STARTDX 2 1 0. 0.5   END END
"""


def test_only_the_block_of_a_case_that_fails_is_run_alone():
    """A pendulum whose degree of freedom is x comes to the horizontal in one case, a dead point of x: the others of its
    block are run alone, all are right."""
    base, lanes, rate = spacar.parse_deck(PENDULUM, mode=1), lanes_of_processor(), "STARTDX.2.1[start rate]"
    rates = [0.5 + 0.01 * k for k in range(2 * lanes)]
    rates[1] = 20.0
    decks = [change(base, [setting(rate)], [v]) for v in rates]
    assert not why_not(decks[0], **OPTIONS)
    missing = [k for k, r in enumerate(ensemble(decks, **OPTIONS)) if r is None]
    assert missing == [k for k in range(len(decks)) if k // lanes == 1 // lanes]
    rows = spacar.sweep(base, {rate: rates}, "x: x[2,1]@end", **OPTIONS)
    for k in (0, 2, lanes):
        single = spacar.run(1, decks[k], **OPTIONS)
        assert rows[k]["status"] == "done"
        assert rows[k]["x"] == pytest.approx(single.node(2, 1)[-1], abs=1e-6)


def test_rows_that_are_there_survive_an_interruption(robot, tmp_path, monkeypatch):
    begun = []
    follow = studies_ensemble.Follower.follow

    def interrupted(self, group):
        begun.append(group)
        if len(begun) > 1:
            raise KeyboardInterrupt
        return follow(self, group)

    monkeypatch.setattr(studies_ensemble.Follower, "follow", interrupted)
    monkeypatch.setattr(studies_ensemble, "LARGEST", 8)
    output = tmp_path / "rows.csv"
    ask = (robot, {"XM.8": list(np.linspace(20.0, 40.0, 20))}, "z: x[8,3]@end")
    with pytest.raises(KeyboardInterrupt):
        spacar.sweep(*ask, output=output, jobs=1, **OPTIONS)
    assert len(list(csv.DictReader(output.open()))) == sum(map(len, begun[0]))  # a block has the processor's lanes
    monkeypatch.setattr(studies_ensemble.Follower, "follow", follow)
    rows = spacar.sweep(*ask, output=output, **OPTIONS)
    assert [row["status"] for row in rows] == 20 * ["done"]
    assert len(list(csv.DictReader(output.open()))) == 20


def test_processes_come_when_one_takes_long(monkeypatch):
    """Without a number of processes the first cases run here; what is left then goes to all cores."""
    monkeypatch.setattr(workers, "HERE", 0.0)
    monkeypatch.setattr(workers, "cores", lambda: 2)
    asked = []

    def pool(function, cases, jobs):
        asked.append(jobs)
        yield from ((case, function(case)) for case in cases)

    monkeypatch.setattr(workers, "_on_processes", pool)
    assert [value for _, value in workers.run(abs, [-1, -2, -3, -4], None)] == [1, 2, 3, 4]
    assert asked == [2]


def test_without_lanes_the_sweep_says_why(call):
    words = ("sweep", "robotsim", "--set", "XM.8=1,2", "-r", "x[1,1]@end", "--time", "0.01", "--steps", "1")
    done = call(*words, "--integrator", "553")
    assert "one by one, not in batches: implicit" in done.out


# Cases whose numbers are combinations of those of a few: they are those of decks of their own; an integer or a
# setting of the run has decks of its own.
BEAMS = """BEAM 1 1 2 3 4 0. 1. 0.   BEAM 2 3 4 5 6 0. 1. 0.   X 3 1. 0. 0.   X 5 2. 0. 0.1
FIX 1   FIX 2   DYNE 1 2 3 4 5 6   DYNE 2 2 3 4 5 6   END HALT
EM 1 0.3 0.01 0.02 0.02   EM 2 0.3 0.01 0.02 0.02   XM 6 0.1 0. 0. 0.2 0. 0.3
ESTIFF 1 0. 4. 5. 6.{shear}   ESTIFF 2 0. 4. 5. 6.   EDAMP 1 0. 0.4 0.5 0.6   ESIG 2 0. 0.1
XF 5 0. 0. -1.   STARTDE 1 3 0. 0.1   GRAVITY 0. 1. -9.81   TIMESTEP 0.05 2   END END
"""
AFFINE_OPTIONS = {"rtol": 1e-8, "atol": 1e-8}


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
    deck = spacar.parse_deck(BEAMS.format(shear=""), mode=1)
    settings, values = tuple(map(setting, targets)), table(len(targets))
    cases = affine_cases(deck, settings, values, **AFFINE_OPTIONS)
    assert cases is not None
    decks = [change(deck, settings, row) for row in values]
    assert cases.deck(5).text == decks[5].text
    for one, other in zip(followed(cases, **AFFINE_OPTIONS), ensemble(decks, **AFFINE_OPTIONS), strict=True):
        for name in ("x", "xd", "sig", "fxtot"):
            size = max(1.0, np.abs(other[name]).max())
            np.testing.assert_allclose(one[name], other[name], atol=1e-9 * size, rtol=0, err_msg=name)


def test_prescribed_motions():
    deck = spacar.read_deck(DATA / "crankfl.dat", 1)
    settings, values = (setting("INPUTX.2.1[start rate]"),), [[100.0 + 3.0 * k] for k in range(FEWEST)]
    options = AFFINE_OPTIONS | {"duration": 0.001, "n_steps": 1}
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
    deck = spacar.parse_deck(BEAMS.format(shear=" 0.3 0.2"), mode=1)
    values = [[low * (1.0 + 0.01 * k)] * len(targets) for k in range(FEWEST)]
    angle = {"beams": "angle"}
    assert (affine_cases(deck, tuple(map(setting, targets)), values, **AFFINE_OPTIONS, **angle) is None) == bool(why)


def test_a_sweep_takes_them_and_gives_the_rows_of_single_runs(robot, monkeypatch):
    taken = []
    monkeypatch.setattr(batched_cases, "affine_cases", lambda *a, **o: taken.append(affine_cases(*a, **o)) or taken[-1])
    ask = robot, {"XM.8": np.linspace(20.0, 40.0, FEWEST + 1)}, "z: x[8,3]@end"
    rows, alone = (spacar.sweep(*ask, batch=batch, jobs=1, **OPTIONS) for batch in (None, False))
    assert taken
    assert taken[0] is not None
    for one, other in zip(rows, alone, strict=True):
        assert (one["status"], one["XM.8"], one["case"]) == ("done", other["XM.8"], other["case"])
        assert one["z"] == pytest.approx(other["z"], abs=1e-6)


@pytest.mark.parametrize("first", [True, False])
def test_a_length_that_cannot_be_fails_alone_with_its_message(first, monkeypatch):
    """Also where it is the first of all cases, from which the others are counted."""
    kept = []
    monkeypatch.setattr(batched_cases, "affine_cases", lambda *a, **o: kept.append(affine_cases(*a, **o)) or kept[-1])
    deck = spacar.parse_deck(BEAMS.format(shear=""), mode=1)
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
