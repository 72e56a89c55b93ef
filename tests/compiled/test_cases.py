"""Compiled batches: every case is its single run, and what cannot be followed together is refused."""

from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.compiled.library import why_off
from spacar.deck import read_deck
from spacar.errors import UsageError
from spacar.studies.assignments import change, setting
from spacar.studies.ensemble import ensemble, why_not
from spacar.studies.followers import E_FIELDS, X_FIELDS

DATA = Path(__file__).parents[2] / "data"
TOLERANCE = 1e-8

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))


def compare(decks, options, variables=(*X_FIELDS, *E_FIELDS)):
    """Within ten tolerances of the largest value of a variable: both keep the tolerance, with other steps."""
    found = ensemble(decks, compiled=True, **options)
    for one, result in zip(decks, found, strict=True):
        alone = spacar.run(1, one, **options)
        assert np.array_equal(alone.t, result.t)
        for name in variables:
            a, b = alone[name], result[name]
            assert a.shape == b.shape
            assert np.abs(a - b).max() <= 10 * TOLERANCE * max(1.0, np.abs(a).max()), name
    return found


@pytest.mark.parametrize("code", [0, *(pytest.param(c, marks=pytest.mark.slow) for c in (155, 853))])
def test_a_batch_is_its_single_runs(code):
    """Nine cases are two blocks, the second one filled up; masses and lengths differ."""
    base = read_deck(DATA / "robotsim.dat", 1)
    settings = [setting("XM.8"), setting("X.8[coordinate x1]")]
    decks = [change(base, settings, [20.0 + 3.0 * k, 0.4 + 0.02 * k]) for k in range(9)]
    options = {"integrator": code, "rtol": TOLERANCE, "atol": TOLERANCE, "duration": 0.3, "n_steps": 3}
    compare(decks, options)


def test_flexible_and_prescribed_members():
    """crankfl: prescribed rotation, fixed and dynamic deformations; stiffness, damping and speed differ."""
    base = read_deck(DATA / "crankfl.dat", 1)
    settings = [setting("ESTIFF.*[EI]"), setting("INPUTX.2.1[start rate]")]
    decks = [change(base, settings, values) for values in ((13.0, 150.0), (6.0, 100.0), (9.0, 50.0))]
    # the rates of the vibrations are far larger than the deformations: a hundredth of the tolerance for a step
    step = 0.01 * TOLERANCE
    options = {"integrator": 853, "rtol": step, "atol": step, "duration": 0.004, "n_steps": 2}
    compare(decks, options, ("x", "e", "xd", "ed"))


def test_frames_are_made_when_they_are_asked_for():
    deck = read_deck(DATA / "robotsim.dat", 1)
    options = {"integrator": 853, "duration": 0.1, "n_steps": 2, "compiled": True}
    result = ensemble([deck, deck], **options)[1]
    assert len(result.frames) == 3
    assert result.frames[-1].t == 0.1
    assert [f.t for f in result.frames[:2]] == [0.0, 0.05]
    assert np.array_equal(result.frames[1].sig, result["sig"][1])
    assert sum(frame.statistics["rhs"] for frame in result.frames) > 0


def test_a_case_near_a_dead_point_is_left_to_a_single_run():
    """A falling slider-crank with the slider as degree of freedom: it has to be followed alone, which explains."""
    kinematics = ["PLBEAM 1 1 2 3 4", "PLBEAM 2 3 5 6 7", "X 3 0.15 0.1", "X 6 0.45 0.", "FIX 1", "FIX 6 2", "DYNX 6 1"]
    dynamics = ["XM 6 0.03", "EM 1 0.2", "EM 2 0.2", "GRAVITY 0. -9.81", "STARTDX 6 1 0.45 1.", "TIMESTEP 1. 10"]
    deck = spacar.deck.parse_deck("\n".join([*kinematics, "END", "HALT", *dynamics, "END", "END", ""]), mode=1)
    assert ensemble([deck, deck], compiled=True) == [None, None]


@pytest.mark.parametrize(
    ("name", "options", "why"),
    [
        ("robotsim", {"integrator": 430}, "implicit"),
    ],
)
def test_what_has_no_compiled_batch(name, options, why):
    deck = read_deck(DATA / f"{name}.dat", 1)
    options = {"duration": 0.1, "n_steps": 1, "compiled": True, **options}
    import re

    assert re.search(why, why_not(deck, **options))
    with pytest.raises(UsageError, match=why):
        ensemble([deck, deck], **options)
