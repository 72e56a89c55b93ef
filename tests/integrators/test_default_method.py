"""Without INTEGRAT the method chooses itself: what is not stiff is that of code 0, stiff models keep ERROR."""

import models
import numpy as np
import pytest

import spacar
from spacar import Deck, parse_deck
from spacar.compiled.library import why_off
from spacar.forward.driver import Integrand
from spacar.integrators import Problem, automatic, integrate
from spacar.integrators.automatic import Automatic
from tests.examples import DATA

ENGINE = pytest.mark.skipif(why_off() is not None, reason="no engine")
STORED = ("x", "xd", "xdd", "e", "sig", "fxtot")


def crank(n: int, duration: float) -> Deck:
    return parse_deck(models.slider_crank(n, duration, 5), mode=1)


def cantilever(n: int, duration: float, *more: str) -> Deck:
    """Unit cantilever of n beams, released under gravity 1; highest frequency about 60 n^2 rad/s."""
    dynamics = ("GRAVITY 0. -1.", f"TIMESTEP {duration} 5", *more)
    return parse_deck(models.cantilever(n, EI=1.0, length=1.0, dynamics=dynamics), mode=1)


def fourbar(n: int, duration: float) -> Deck:
    """A crank that turns with 10 rad/s, a flexible coupler of n equal beams 2 ... n + 1, a rigid rocker."""
    node, turn = [3, *range(12, 2 * n + 11, 2)], [5, *range(13, 2 * n + 12, 2)]
    rows = ["PLBEAM 1 1 2 3 4", f"PLBEAM {n + 2} {node[n]} 6 7 8"]
    rows += [f"PLBEAM {i + 2} {node[i]} {turn[i]} {node[i + 1]} {turn[i + 1]}\nDYNE {i + 2} 2 3" for i in range(n)]
    rows += [f"X {node[i]} {i / n!r} {0.2 + 0.3 * i / n!r}" for i in range(n + 1)]
    rows += ["X 7 1. 0.", "FIX 1", "FIX 7", "INPUTX 2 1"]
    loads = [f"EM {i + 2} 1.\nESTIFF {i + 2} 0. 50." for i in range(n)]
    loads += [f"EM {n + 2} 1.", "INPUTX 2 1 0. 10. 0.", f"TIMESTEP {duration} 5"]
    return parse_deck(models.deck(rows, loads), mode=1)


def total(result: spacar.Result, what: str = "steps") -> int:
    return sum(frame.statistics.get(what, 0) for frame in result.frames)


@pytest.mark.parametrize("name", ["crank", "fourbar", "crankfl", "finger", "fingersim", "screw", "trike2", "trike3v"])
def test_examples_are_computed_as_by_code_0(name: str) -> None:
    """Flexible, belts, wheels, Euler parameters: to the last digit, with the same evaluations."""
    short = {"n_steps": 2, "duration": 0.01 if name == "crankfl" else 0.05}
    file = DATA / f"{name}.dat"
    adams, default = spacar.run(1, file, integrator=0, **short), spacar.run(1, file, **short)
    assert default.mechanism.settings.integrator == -1
    assert (total(default), total(default, "rhs")) == (total(adams), total(adams, "rhs"))
    for what in STORED:
        np.testing.assert_array_equal(default[what], adams[what])


@ENGINE
def test_looking_leaves_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    """A double pendulum on a spring moves as fast as its highest frequency: looked at, not tried, the same digits."""
    looks = []
    look = Automatic._frequencies

    def spy(method: Automatic, t: float, y: np.ndarray) -> tuple[tuple[float, float], tuple[float, float]]:
        looks.append(look(method, t, y))
        return looks[-1]

    monkeypatch.setattr(Automatic, "_frequencies", spy)
    monkeypatch.setattr(automatic, "LOOK", 0.0)  # else it is asked with 37,500 steps ahead
    rows = [("PLRBEAM", 1, 1, 4, 2), ("PLRBEAM", 2, 2, 5, 3), ("PLTRUSS", 3, 1, 3)]
    rows += [("X", 2, 0.5, -0.9), ("X", 3, 1.0, -1.8), ("FIX", 1), ("DYNX", 4, 1), ("DYNX", 5, 1), ("RLSE", 3, 1)]
    more = [("EM", 1, 1.0), ("EM", 2, 1.0), ("ESTIFF", 3, 20.0), ("GRAVITY", 0.0, -9.81), ("TIMESTEP", 400.0, 100)]
    model = Deck.build(rows, more)
    adams, default = spacar.run(1, model, integrator=0), spacar.run(1, model)
    assert looks
    assert all(fast < 4 * slow for (fast, slow), _ in looks)
    assert total(default, "jacobians") == 0
    for what in STORED:
        np.testing.assert_array_equal(default[what], adams[what])


@ENGINE
@pytest.mark.parametrize(
    ("model", "error"),
    [
        pytest.param(crank(16, 0.012), 1e-3, id="crank", marks=pytest.mark.slow),
        pytest.param(crank(8, 0.05), 1e-5, id="longer crank", marks=pytest.mark.slow),
        pytest.param(cantilever(16, 0.9), 1e-5, id="cantilever", marks=pytest.mark.slow),
        pytest.param(cantilever(24, 0.3), 1e-6, id="fine cantilever", marks=pytest.mark.slow),
        pytest.param(cantilever(16, 0.3, *(f"EDAMP {k} 0. 1e-3" for k in range(1, 17))), 1e-5, id="damped cantilever"),
        pytest.param(fourbar(8, 0.5), 1e-3, id="fourbar", marks=pytest.mark.slow),
        pytest.param(fourbar(16, 0.05), 1e-5, id="finer fourbar", marks=pytest.mark.slow),
    ],
)
def test_stiff_models_keep_error_for_positions(model: Deck, error: float) -> None:
    """Against code 0 with a small ERROR, which follows every vibration. Rotations too, to twice ERROR."""
    exact = spacar.run(1, model, integrator=0, atol=1e-9, rtol=1e-9)
    default = spacar.run(1, model, atol=error, rtol=error)
    (line,) = default.report
    assert "INTEGRAT 595" in line
    assert "limits the steps" in line
    assert total(default) < total(exact) / 10
    off = np.abs(default["x"] - exact["x"]) / (error * (1.0 + np.abs(exact["x"])))
    assert off[:, exact.mechanism.numbering.positions.ravel()].max() < 1.0
    assert off.max() < 2.0


class Shaken(Problem):
    """A slow oscillator, and one of 300 rad/s that is shaken with 250 rad/s from t = 12 s on."""

    n_positions = 2

    def __init__(self) -> None:
        self.changes: list[tuple[float, int]] = []

    def rhs(self, t: float, y: np.ndarray) -> np.ndarray:
        shaking = 3e4 * np.sin(250.0 * t) * 0.5 * (1.0 + np.tanh(20.0 * (t - 12.0)))
        return np.array([y[2], y[3], -y[0], -9e4 * y[1] + shaking])

    def jacobian(self, t: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        J = np.zeros((4, 4))
        J[0, 2] = J[1, 3] = 1.0
        J[2, 0], J[3, 1] = -1.0, -9e4
        return J, np.zeros(4)

    def switched(self, t: float, code: int, omega: float | None) -> None:
        self.changes.append((t, code))


def test_a_motion_that_becomes_fast_is_given_back_to_adams() -> None:
    problem = Shaken()
    start, times = np.array([1.0, 1e-10, 0.0, 0.0]), np.linspace(0.0, 14.0, 141)
    outputs = list(integrate(problem, start, times, -1, 1e-9, 1e-9))
    assert [code for _, code in problem.changes] == [595, 595, 0]
    assert 11.0 < problem.changes[-1][0] < 13.0
    exact = list(integrate(Shaken(), start, times, 853, 1e-12, 1e-12))
    np.testing.assert_allclose([out.y[:2] for out in outputs], [out.y[:2] for out in exact], rtol=0, atol=1e-5)


@pytest.mark.parametrize("compiled", [pytest.param(True, marks=ENGINE), False])
@pytest.mark.parametrize("c", [1e6, 1e9, 1e12])
def test_a_stiff_damper_needs_few_evaluations(c: float, compiled: bool) -> None:
    """1 kg on a spring k and a damper c, released at 0.1 m: (l2 exp(l1 t) - l1 exp(l2 t))/(l2 - l1), l1 l2 = k.

    The only direction of the rates is that of the decay. Radau alone needs some 60 evaluations; the first
    look at Adams is after 100 steps. With 1e12 no first step of Adams is small enough."""
    k = 1e-3 * c
    rows = [("PLTRUSS", 1, 1, 2), ("X", 2, 1.0), ("FIX", 1), ("FIX", 2, 2), ("DYNE", 1, 1)]
    more = [("XM", 2, 1.0), ("ESTIFF", 1, k), ("EDAMP", 1, c), ("STARTDE", 1, 1, 0.1, 0.0), ("TIMESTEP", 800.0, 4)]
    found = spacar.run(1, Deck.build(rows, more), compiled=compiled)
    assert total(found, "rhs") < 500
    fast = -0.5 * c * (1.0 + np.sqrt(1.0 - 4.0 * k / c**2))
    slow, t = k / fast, np.array([0.0, 200.0, 400.0, 600.0, 800.0])
    exact = 1.0 + 0.1 * (fast * np.exp(slow * t) - slow * np.exp(fast * t)) / (fast - slow)
    np.testing.assert_allclose(found.node(2, 1, "x"), exact, rtol=0, atol=2e-5)


# INTEGRAT -1: code 0 step by step where nothing is stiff, Radau of order 9 where a vibration limits the steps.
def test_without_a_jacobian_there_is_nothing_to_change_to(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Automatic, "__init__", lambda *_: pytest.fail("no method has to be chosen"))
    options = {"duration": 0.1, "n_steps": 3}
    adams, chosen = (spacar.run(1, DATA / "robotsim.dat", integrator=code, **options) for code in (0, -1))
    np.testing.assert_array_equal(chosen["x"], adams["x"])
    assert chosen.header["integrator"] != adams.header["integrator"]  # the name of what was asked for


def test_without_the_engine_it_changes_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Thousands of steps of Adams are ahead; the watch of dead points knows it too."""
    resolved, switched = [], Integrand.switched

    def spy(integrand: Integrand, t: float, code: int, omega: float | None) -> None:
        switched(integrand, t, code, omega)
        assert integrand.continuity is not None
        resolved.append((code, integrand.continuity.resolved))

    monkeypatch.setattr(Integrand, "switched", spy)
    options = {"atol": 1e-5, "rtol": 1e-3, "duration": 0.2, "n_steps": 2}
    chosen = spacar.run(1, cantilever(16, 0.9), integrator=-1, compiled=False, **options)
    assert resolved == [(595, False)] * 2
    assert 100 <= total(chosen) < 400
    adams = spacar.run(1, cantilever(16, 0.9), integrator=0, **options)  # in C where it is there
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
    assert total(chosen) < 1.1 * total(adams)
