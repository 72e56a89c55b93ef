"""Wheels in lanes: cases are their single runs with every explicit code, and one whose wheel lifts off says so."""

import numpy as np
import pytest

import spacar
from spacar.compiled.library import lanes_of_processor, why_off
from spacar.deck import read_deck
from spacar.studies.assignments import change, setting
from spacar.studies.ensemble import why_not
from tests.ensembles import ensemble
from tests.examples import DATA

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
