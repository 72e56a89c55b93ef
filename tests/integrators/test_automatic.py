"""INTEGRAT -1: code 0 step by step where nothing is stiff, Radau of order 9 where a vibration limits the steps."""

import models
import numpy as np
import pytest

import spacar
from spacar import Deck, parse_deck
from spacar.compiled.library import why_off
from spacar.forward.driver import Integrand
from spacar.integrators.automatic import Automatic
from tests.examples import DATA

ENGINE = pytest.mark.skipif(why_off() is not None, reason="no engine")


def cantilever(n: int) -> Deck:
    """Unit cantilever of n beams, released under gravity 1; highest frequency about 60 n^2 rad/s."""
    dynamics = ("GRAVITY 0. -1.", "TIMESTEP 0.9 6")
    return parse_deck(models.cantilever(n, EI=1.0, length=1.0, dynamics=dynamics), mode=1)


def steps(result: spacar.Result) -> int:
    return sum(frame.statistics.get("steps", 0) for frame in result.frames)


def test_what_is_not_stiff_is_computed_as_by_adams() -> None:
    for name in ("crank", "fourbar", "crankfl"):
        adams, chosen = (spacar.run(1, DATA / f"{name}.dat", integrator=code, duration=0.01) for code in (0, -1))
        assert steps(chosen) == steps(adams)
        np.testing.assert_array_equal(chosen["x"], adams["x"])


def test_without_a_jacobian_there_is_nothing_to_change_to(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Automatic, "__init__", lambda *_: pytest.fail("no method has to be chosen"))
    options = {"duration": 0.1, "n_steps": 3}
    adams, chosen = (spacar.run(1, DATA / "robotsim.dat", integrator=code, **options) for code in (0, -1))
    np.testing.assert_array_equal(chosen["x"], adams["x"])
    assert chosen.header["integrator"] != adams.header["integrator"]  # the name of what was asked for


@ENGINE
def test_a_refined_beam_changes_to_radau() -> None:
    """The steps in C are handed on to those in Python, which Radau makes."""
    adams, chosen = (spacar.run(1, cantilever(16), integrator=code, atol=1e-5, rtol=1e-3) for code in (0, -1))
    (line,) = chosen.report
    assert "INTEGRAT 595" in line
    assert "limits the steps" in line
    assert steps(chosen) < steps(adams) / 20
    np.testing.assert_allclose(chosen["x"], adams["x"], rtol=0, atol=2e-5)


def test_without_the_engine_it_changes_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Thousands of steps of Adams are ahead; the watch of dead points knows it too."""
    resolved, switched = [], Integrand.switched

    def spy(integrand: Integrand, t: float, code: int, omega: float | None) -> None:
        switched(integrand, t, code, omega)
        assert integrand.continuity is not None
        resolved.append((code, integrand.continuity.resolved))

    monkeypatch.setattr(Integrand, "switched", spy)
    options = {"atol": 1e-5, "rtol": 1e-3, "duration": 0.2, "n_steps": 2}
    chosen = spacar.run(1, cantilever(16), integrator=-1, compiled=False, **options)
    assert resolved == [(595, False)] * 2
    assert 100 <= steps(chosen) < 400
    adams = spacar.run(1, cantilever(16), integrator=0, **options)  # in C where it is there
    np.testing.assert_allclose(chosen["x"], adams["x"], rtol=0, atol=2e-5)


@ENGINE
def test_a_vibration_that_is_the_motion_is_tried_and_left_to_adams() -> None:
    """A mass on a spring with 2000 periods: Radau takes longer steps, but not as much longer as they cost."""
    rows = [("PLTRUSS", 1, 1, 2), ("X", 2, 1.0), ("FIX", 1), ("FIX", 2, 2), ("DYNE", 1)]
    more = [("XM", 2, 1.0), ("ESTIFF", 1, 1.0), ("STARTDE", 1, 1, 0.1, 0.0), ("TIMESTEP", 8000.0, 4)]
    adams, chosen = (
        spacar.run(1, Deck.build(rows, [*more, ("ERROR", 1e-8, 1e-8)]), integrator=code) for code in (0, -1)
    )
    assert chosen.report == ()
    np.testing.assert_allclose(chosen["x"], adams["x"], rtol=0, atol=1e-4)
    assert steps(chosen) < 1.1 * steps(adams)
