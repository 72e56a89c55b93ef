"""An absolute ERROR that is large beside the motion is told, lengths and rotations apart; jumps are found."""

from math import cos
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.compiled.library import why_off

ENGINES = [pytest.param(True, marks=pytest.mark.skipif(why_off() is not None, reason="no engine")), False]


def resonator(start: float, *, turning: bool = False) -> spacar.Deck:
    """2 pi rad/s; turning: an inertia on a hinge instead of a mass on a truss."""
    if turning:
        rows = [("HINGE", 1, 1, 2, 0.0, 0.0, 1.0), ("FIX", 1), ("DYNE", 1, 1)]
        more = [("XM", 2, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0), ("ESTIFF", 1, 4.0 * np.pi**2)]
    else:
        length = 1e-4 if start < 1e-5 else 1.0
        rows = [("PLTRUSS", 1, 1, 2), ("X", 2, length), ("FIX", 1), ("FIX", 2, 2), ("DYNE", 1, 1)]
        more = [("XM", 2, 1.0), ("ESTIFF", 1, 4.0 * np.pi**2 * length)]
    return spacar.Deck.build(rows, [*more, ("STARTDE", 1, 1, start, 0.0), ("TIMESTEP", 3.0, 20)])


@pytest.mark.parametrize("compiled", ENGINES)
@pytest.mark.parametrize(("start", "turning", "kind"), [(1e-7, False, "lengths"), (1e-6, True, "rotations")])
def test_a_motion_below_error_is_told(start: float, turning: bool, kind: str, compiled: bool) -> None:
    result = spacar.run(1, resonator(start, turning=turning), compiled=compiled)
    (line,) = result.report
    assert line.startswith("warning: ERROR allows 1e-05")
    assert kind in line
    advised = spacar.run(1, resonator(start, turning=turning), compiled=compiled, atol=2e-4 * start)
    assert advised.report == ()
    exact = start * np.cos(2.0 * np.pi * np.linspace(0.0, 3.0, 21))
    np.testing.assert_allclose(advised.element(1, 1, "e"), exact, rtol=0, atol=1e-3 * start)


def test_a_motion_of_centimetres_is_not() -> None:
    assert spacar.run(1, resonator(2e-5 / 0.01)).report == ()
    assert spacar.run(1, resonator(0.0)).report == ()


# Jumps of user functions that nobody declares: outputs inside them show them, wherever the steps lie.
BEGIN, END = 3.0031, 3.0531
OSCILLATOR = """
PLTRUSS 1 1 2   X 1 0. 0.   X 2 100. 0.   FIX 1   FIX 2 2   DYNE 1 1   END HALT
XM 2 1.   ESTIFF 1 400.   USERSIG push   STARTDE 1 1 0.01 0.   TIMESTEP 10. 1000   END END
"""
PULSE = f"""
def push(t, ne, le, e, ep, nx, lnp, x, xp):
    return t, [], [[2, 1, 20.0 if {BEGIN} < t < {END} else 0.0]]
"""
SMOOTH = """
from math import sin
def push(t, ne, le, e, ep, nx, lnp, x, xp):
    return t, [], [[2, 1, 0.1 * sin(t)]]
"""

def model(folder: Path, text: str, name: str, function: str) -> Path:
    (folder / f"{name}.py").write_text(function)
    (folder / "model.dat").write_text(text)
    return folder / "model.dat"


def after_the_pulse(t: float) -> float:
    """Mass 1, k = EA/l = 4: two steps of the force 20."""
    return 100.0 + 0.01 * cos(2.0 * t) + 5.0 * (cos(2.0 * (t - END)) - cos(2.0 * (t - BEGIN)))


@pytest.mark.parametrize("compiled", ENGINES)
@pytest.mark.parametrize("code", [-1, 0, 155, 853, 553, 595])
def test_a_pulse_between_two_steps_is_seen(tmp_path: Path, code: int, compiled: bool) -> None:
    file = model(tmp_path, OSCILLATOR, "push", PULSE)
    result = spacar.run(1, file, integrator=code, compiled=compiled, duration=5.0, n_steps=500, rtol=1e-6, atol=1e-7)
    within = 1e-4 if code in (553, 595) else 1e-5  # whose errors of velocities add up (docs/studies.md)
    assert result.node(2, 1, "x")[-1] == pytest.approx(after_the_pulse(5.0), abs=within)


@pytest.mark.parametrize("compiled", ENGINES)
def test_a_smooth_force_costs_nothing_more(tmp_path: Path, compiled: bool) -> None:
    """Declared breaks (outside of the motion) are those of a run that does not look."""
    file = model(tmp_path, OSCILLATOR, "push", SMOOTH)
    looked = spacar.run(1, file, compiled=compiled)
    model(tmp_path, OSCILLATOR, "push", SMOOTH + "push.breaks = (-1.0,)\n")
    plain = spacar.run(1, file, compiled=compiled)
    np.testing.assert_array_equal(looked["x"], plain["x"])


def test_accuracy_sees_the_pulse(tmp_path: Path) -> None:
    result = spacar.run(1, model(tmp_path, OSCILLATOR, "push", PULSE), accuracy=1e-4)
    found = result.header["accuracy"]
    t = np.linspace(0.0, 10.0, 1001)[400:]
    exact = np.array([after_the_pulse(s) for s in t])
    error = np.abs(result.node(2, 1, "x")[400:] - exact).max() / np.ptp(exact)
    assert found.met
    assert error <= found.estimate
