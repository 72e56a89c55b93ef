"""Wheels in lanes: cases are their single runs with every explicit code, and one whose wheel lifts off says so."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import spacar
from spacar.compiled.library import lanes_of_processor, why_off
from spacar.compiled.numbers import of_one
from spacar.compiled.numbers_of_cases import same
from spacar.deck import ELEMENT_TYPES, Deck, read_deck
from spacar.dynamics.loaded_mechanism import LoadedMechanism
from spacar.errors import AnalysisError
from spacar.mechanism import build
from spacar.studies import batched_cases
from spacar.studies.affine_cases import FEWEST, affine_cases
from spacar.studies.assignments import change, setting
from spacar.studies.ensemble import E_FIELDS, X_FIELDS, why_not
from tests.ensembles import ensemble, followed
from tests.examples import DATA

from .all_elements import MODELS, deck_of

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))

TOLERANCE = 1e-8
OPTIONS = {"duration": 0.1, "n_steps": 2, "rtol": TOLERANCE, "atol": TOLERANCE}


@pytest.mark.parametrize("name", ["trike2", "trike3i", "trike3v"])
@pytest.mark.parametrize("code", [-1, 155, 853, pytest.param(140, marks=pytest.mark.slow)])
def test_every_case_is_its_single_run(name, code):
    """The steering angle at the start is half a radian: far from the reference configuration."""
    options = OPTIONS | {"integrator": code} | ({"step": 1e-3} if code == 140 else {})
    base = read_deck(DATA / f"{name}.dat", 1)
    assert not why_not(base, **options)
    cases = lanes_of_processor() + 1
    decks = [change(base, [setting("XM.1")], [m]) for m in np.linspace(80.0, 90.0, cases)]
    results = ensemble(decks, **options)
    for k in (0, cases - 1):
        single = spacar.run(1, decks[k], **options)
        for variable in ("x", "xd", "e", "ed", "sig", "fxtot"):
            size = max(1.0, np.abs(single[variable]).max())
            np.testing.assert_allclose(results[k][variable], single[variable], atol=100 * TOLERANCE * size, rtol=0)


def test_start_values_of_their_own():
    """Speeds and steering angles differ: the way to a start leads over that of the first case."""
    base = read_deck(DATA / "trike2.dat", 1)
    settings = [setting("STARTDX.4.1[start rate]"), setting("STARTDE.6.1[start value]")]
    decks = [change(base, settings, [5.0 + k, -0.5 + 0.2 * k]) for k in range(5)]
    for deck, result in zip(decks, ensemble(decks, **OPTIONS), strict=True):
        single = spacar.run(1, deck, **OPTIONS)
        np.testing.assert_allclose(result["x"], single["x"], atol=100 * TOLERANCE, rtol=0)


@pytest.mark.parametrize("gravity", [True, False])
def test_a_wheel_that_leaves_the_ground(gravity):
    """Pressed by gravity it ends the run of the case, with the single run's words; without gravity it is a warning."""
    base = read_deck(DATA / "trike3v.dat", 1)
    text = base.text if gravity else base.text.replace("GRAVITY", "% GRAVITY")
    deck = spacar.deck.parse_deck(text, mode=1)
    fast = [4.0, 60.0] if gravity else [10.0, 11.0]
    options = OPTIONS | {"rtol": 1e-5, "atol": 1e-5, "duration": 0.1 if gravity else 1e-3}
    ask = deck, {"STARTDE.2.1[start rate]": fast}, "x[1,1]@end"
    rows, alone = (spacar.sweep(*ask, batch=batch, jobs=1, **options) for batch in (True, False))
    assert [r["status"] for r in rows] == [r["status"] for r in alone] == ["done", "failed" if gravity else "done"]
    assert rows[1]["reason"].split(" at t")[0] == alone[1]["reason"].split(" at t")[0]
    if not gravity:
        decks = [change(deck, [setting("STARTDE.2.1[start rate]")], [v]) for v in fast]
        said = [sorted(r.report) for r in ensemble(decks, **options)]
        assert [len(lines) for lines in said] == [len(spacar.run(1, d, **options).report) for d in decks]
        assert any("leaves the ground" in line for line in said[0])


def tyre(stiffness, *starts):
    rows = [
        ("X", 1, 0.1, 0.2, 0.5), ("X", 3, 0.1, 0.2, 0.0), ("DYNX", 2, 2, 3, 4), ("KINX", 1, 1), ("DYNX", 1, 2),
        ("TWHEEL", 1, 1, 2, 3, 0.5, 0.1, 0.3, 1.0, 0.0), ("RLSE", 1, 6), ("DYNE", 1, 1),
    ]  # fmt: skip
    dynamics = [("XM", 1, 5.0), ("XM", 2, 0.4, 0.0, 0.0, 0.3, 0.0, 0.3), ("ESTIFF", 1, stiffness)]
    return Deck.build(rows, [*dynamics, ("GRAVITY", 0.02, 0.03, -1.0), *starts])


def test_tyres_without_deformation_stay_on_the_ground():
    """Their normal forces are zero at the start, with the sign of rounding."""
    decks = []
    for turned in np.random.default_rng(1).normal(0.0, 0.06, (20, 3)).tolist():
        decks.append(tyre(66.0, *[("STARTDX", 2, c, value, 0.1) for c, value in enumerate(turned, 2)]))
    results = ensemble(decks, duration=1e-3, n_steps=1)
    normal = [result.element(1, 1, "sig")[0] for result in results]
    assert max(normal) > 0.0  # a pull
    assert np.abs(normal).max() < 1e-12 * 5.0  # of the weight


def test_a_soft_tyre_beside_a_stiff_one_has_its_own_rounding():
    """A pull of a millionth of the weight on 66 N/m; rounding of 1e10 N/m is more, which hid it."""
    decks = [tyre(S, ("STARTDE", 1, 1, e, 0.0)) for S, e in ((1e10, -1e-9), (66.0, 1e-7))]
    options = {"integrator": 155, "duration": 1e-4, "n_steps": 1}
    with pytest.raises(AnalysisError, match="leaves the ground"):
        spacar.run(1, decks[1], **options)
    assert ensemble(decks, **options) == [None, None]  # they are to be run alone


# Every element type, moments, MEE and prescribed motions in lanes: cases with other lengths and masses are their
# single runs, and their numbers, made for all cases at once, are those of decks of their own.
ROUNDING = 1e-9


def test_every_type_is_there():
    used = {row[0] for kinematics, _ in MODELS.values() for row in kinematics}
    assert set(ELEMENT_TYPES) - {"PLBEAR"} <= used  # which has no equations


def varied(name):
    """Settings of a position and a mass, and values of FEWEST cases in no order."""
    deck = deck_of(name)
    x = next(s for s in deck.of("X", block=1) if s.values[0] == 3)
    mass = deck.of("XM", block=2)[0]
    axis = 0 if "WHEEL" not in name or name.startswith("PL") else 1
    settings = setting(f"X.3[{axis + 2}]"), setting(f"XM.{mass.values[0]}[2]")
    random = np.random.default_rng(3).random((FEWEST, 2))
    place = x.values[1 + axis] + 0.1 * (random[:, 0] if axis == 0 else 0.0 * random[:, 0])
    return deck, settings, np.column_stack((place, mass.values[1] * (1.0 + random[:, 1]))).tolist()


@pytest.mark.parametrize("name", MODELS)
def test_numbers_of_all_cases_are_those_of_their_decks(name):
    deck, settings, values = varied(name)
    cases = affine_cases(deck, settings, values)
    assert cases is not None
    assert list(cases.chosen) == list(range(FEWEST))
    for k in range(0, FEWEST, 3):
        own = of_one(LoadedMechanism.of(build(change(deck, settings, values[k]), 1)))
        assert same(own, cases.numbers.take(np.array([k]))), k


@pytest.mark.parametrize("name", MODELS)
def test_every_element_is_its_single_run(name):
    deck, settings, values = varied(name)
    options = {"rtol": ROUNDING, "atol": ROUNDING}
    assert not why_not(deck, **options)
    cases = affine_cases(deck, settings, values, **options)
    results = followed(cases, **options)
    decks = [change(deck, settings, v) for v in values]
    of_decks = ensemble(decks[:3], **options)
    for k in (0, 1, FEWEST - 1):
        single = spacar.run(1, decks[k], **options)
        for found in (results[k], *of_decks[k : k + 1]):
            assert found is not None
            assert np.array_equal(found.t, single.t)
            for variable in (*X_FIELDS, *E_FIELDS):
                want = single[variable]
                size = max(1.0, np.abs(want).max())
                np.testing.assert_allclose(found[variable], want, atol=100 * ROUNDING * size, rtol=0, err_msg=variable)


# Sweeps over models with user functions run in lanes: every case has functions of its own, which Python calls once a
# lane for each evaluation; a function that fails takes nothing along but its case.
MODEL = """PLBEAM 1 1 2 3 4   X 3 1. 0.   FIX 1   {classes}   END HALT
XM 3 2.   EM 1 0.5   XM 4 0.1   {more}   TIMESTEP 0.4 4   END END
"""
HEAD = "import counted\n\ndef push(t, ne, le, e, ep, nx, lnp, x, xp):\n"
SPRING = "    return t, [[1, 2, 3.0 * e[le[0][1]] + 0.05 * ep[le[0][1]]]], [[3, 2, -5.0 - xp[lnp[2][1]]]]\n"
# the steps of a case do not depend on those beside it, and positions are exact
FIXED_STEPS = {"integrator": 140, "step": 0.005, "rtol": 1e-10, "atol": 1e-10}
MASS = setting("XM.3")


@pytest.fixture
def counted(monkeypatch):
    """What user functions of a test write down."""
    found = SimpleNamespace(calls=[])
    monkeypatch.setitem(sys.modules, "counted", found)
    return found


def written(folder: Path, law: str, classes: str = "DYNX 2 1\nDYNE 1 2", more: str = "USERSIG push") -> Deck:
    (folder / "push.py").write_text(HEAD + law)
    (folder / "model.dat").write_text(MODEL.format(classes=classes, more=more))
    return read_deck(folder / "model.dat", 1)


def variants(deck: Deck, n: int) -> list[Deck]:
    return [change(deck, [MASS], [m]) for m in np.linspace(1.0, 3.0, n)]


def compare(decks: list[Deck], options: dict) -> None:
    """Stages know their positions to 1e-11, which the law of the stresses magnifies in accelerations."""
    assert not why_not(decks[0], **options)
    for deck, found in zip(decks, ensemble(decks, **options), strict=True):
        alone = spacar.run(1, deck, **options)
        for name in ("x", "xd", "xdd", "e", "sig", "fx", "fxtot"):
            size = max(1.0, np.abs(alone[name]).max())
            np.testing.assert_allclose(found[name], alone[name], atol=1e-9 * size, rtol=0, err_msg=name)


def test_a_batch_is_its_single_runs_to_rounding(tmp_path, counted):
    """A block that is full, and one that is filled up."""
    compare(variants(written(tmp_path, SPRING), lanes_of_processor() + 2), FIXED_STEPS)


@pytest.mark.parametrize("integrator", [-1, 0])  # 155 looks for jumps with calls of its own
def test_a_block_of_one_asks_what_a_run_alone_asks(integrator, tmp_path, counted):
    """At the same times, each as often: the start is evaluated and shown once."""
    deck = written(tmp_path, "    counted.calls.append(t)\n    return t, [], [[3, 2, -0.01]]\n", "DYNX 2 1")
    spacar.run(1, deck, integrator=integrator)
    alone = counted.calls[:]
    counted.calls.clear()
    assert None not in ensemble([deck], integrator=integrator)
    assert counted.calls == alone


def test_every_case_has_a_function_of_its_own(tmp_path, counted):
    """One that remembers how often it was called would mix the cases up."""
    law = "    push.calls = getattr(push, 'calls', 0) + 1\n    return t, [], [[3, 2, -0.01 * push.calls]]\n"
    compare(variants(written(tmp_path, law, "DYNX 2 1"), 3), FIXED_STEPS)


def test_prescribed_motion_by_a_function(tmp_path, counted):
    """The start values of the polynomial below it differ from case to case."""
    law = "def push(t, step):\n    return t, [[1, 1, 0.1 * t * t, 0.2 * t, 0.2]], []\n"
    more = "USERINP push\nINPUTX 2 1 0. 0.5 0.\nESTIFF 1 0. 5."
    deck = written(tmp_path, SPRING, "INPUTE 1 1\nINPUTX 2 1\nDYNE 1 2", more)
    (tmp_path / "push.py").write_text(law)
    decks = [change(deck, [MASS, setting("INPUTX.2.1[start rate]")], [m, 0.5 * m]) for m in (1.0, 2.0, 3.0)]
    compare(decks, FIXED_STEPS)


def test_functions_are_called_once_a_lane(tmp_path, counted):
    """As often as alone: lanes that fill the block up are not asked."""
    law = "    counted.calls.append(t)\n" + SPRING
    decks = variants(written(tmp_path, law), 2)
    for deck in decks:
        spacar.run(1, deck, **FIXED_STEPS)
    alone = len(counted.calls)
    counted.calls.clear()
    ensemble(decks, **FIXED_STEPS)
    assert len(counted.calls) == pytest.approx(alone, rel=0.02)  # the start is looked at in NumPy, once for all


def test_a_function_that_fails_fails_its_case_only(tmp_path, counted, monkeypatch):
    """The heaviest one; no other is run alone."""
    law = "    if x[lnp[2][1]] < -0.35: raise RuntimeError('too low')\n    return t, [], [[3, 2, -5.0]]\n"
    deck, n = written(tmp_path, law, "DYNX 2 1"), lanes_of_processor()
    masses = [0.4, *np.linspace(1.0, 3.0, n - 1)]
    follow, alone = batched_cases.run_case, []
    monkeypatch.setattr(batched_cases, "run_case", lambda case: alone.append(case.values) or follow(case))
    rows = spacar.sweep(deck, {"XM.3": masses}, "y: x[3,2]@end", **FIXED_STEPS)
    assert [row["status"] for row in rows] == ["failed", *["done"] * (n - 1)]
    assert "the user function push failed" in rows[0]["reason"]
    assert "RuntimeError: too low" in rows[0]["reason"]
    assert alone == [(0.4,)]


def test_ctrl_c_in_a_function_ends_the_sweep(tmp_path, counted):
    law = "    if t > 0.2: raise KeyboardInterrupt\n    return t, [], [[3, 2, -5.0]]\n"
    deck = written(tmp_path, law, "DYNX 2 1")
    for options in (FIXED_STEPS, {"integrator": 155}):
        with pytest.raises(KeyboardInterrupt):
            spacar.sweep(deck, {"XM.3": [1.0, 2.0]}, "y: x[3,2]@end", jobs=1, **options)


def test_stresses_that_cannot_act_are_told(tmp_path, counted):
    law = "    return t, [[1, 1, 2.0]], [[3, 2, -5.0]]\n"
    deck = written(tmp_path, law, "DYNX 2 1")
    alone = spacar.run(1, deck, **FIXED_STEPS)
    found = ensemble([deck, deck], **FIXED_STEPS)
    assert alone.report
    assert [list(result.report) for result in found] == [list(alone.report)] * 2
