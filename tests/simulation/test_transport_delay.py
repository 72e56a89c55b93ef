"""The transport delay against solutions by the method of steps and shifted signals."""

from math import factorial

import numpy as np
import pytest

from spacar import simulation as sim
from spacar.errors import UsageError

from .diagrams import chain, ring

TIMES = np.linspace(0.0, 4.0, 101)
TIGHT = {"rtol": 1e-10, "atol": 1e-12}


def by_steps(t):
    """x' = -x(t - 1), x = 1 for t <= 0: the sum of (-1)^k (t - k + 1)^k / k! over k with t > k - 1."""
    return sum((-1) ** k * max(t - k + 1.0, 0.0) ** k / factorial(k) for k in range(1, 7)) + 1.0


@pytest.mark.parametrize("code", [155, 853, pytest.param(553, marks=pytest.mark.slow)])
def test_a_loop_with_a_delay_follows_the_method_of_steps(code):
    d = ring(sim.Integrator("x", 1.0), sim.TransportDelay("late", 1.0, 1.0), sim.Gain("minus", -1.0))
    found = sim.simulate(d, TIMES, method=code, **TIGHT)["x"][:, 0]
    # steps of 1e-10 of the size; a kink that the step size control has to find costs some of them
    assert np.allclose(found, [by_steps(t) for t in TIMES], rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("lag", [0.003, 1.0 / 3.0, *(pytest.param(s, marks=pytest.mark.slow) for s in (0.25, 7.0))])
def test_a_fast_signal_comes_out_later(lag):
    d = chain(sim.Sine("s", 2.0, 5.0), sim.TransportDelay("late", lag, -1.0))
    found = sim.simulate(d, TIMES, **TIGHT)["late"][:, 0]
    want = np.where(lag > TIMES, -1.0, 2.0 * np.sin(10.0 * np.pi * (TIMES - lag)))
    inside = abs(TIMES - lag) > 1e-12
    assert np.allclose(found[inside], want[inside], rtol=0.0, atol=1e-9)


def test_jumps_come_out_at_their_time():
    """The integral of delayed pulses is exact only if a step ends at every edge that comes out."""
    lag = 0.37
    d = chain(sim.Pulses("p", 0.7, 0.25), sim.TransportDelay("late", lag), sim.Integrator("area"))
    found = sim.simulate(d, TIMES, rtol=1e-3, atol=1e-3)
    full, rest = np.divmod(np.maximum(TIMES - lag, 0.0), 0.7)
    exact = 0.175 * full + np.minimum(rest, 0.175)
    assert np.allclose(found["area"][:, 0], exact, rtol=0.0, atol=1e-12)


def test_a_delay_of_whole_samples_is_a_chain_of_unit_delays():
    filtered = sim.Sine("s", 1.0, 0.6), sim.sampled_transfer_function("filter", 0.1, [0.3], [1.0, -0.7])
    d = chain(*filtered, *(sim.unit_delay(f"d{k}", 0.1) for k in range(3)))
    d.add(sim.TransportDelay("late", 0.3)).connect("filter", "late")
    found = sim.simulate(d, np.linspace(0.05, 3.95, 40))
    assert np.allclose(found["late"], found["d2"], rtol=0.0, atol=1e-12)


def test_a_step_through_two_delays():
    delays = sim.TransportDelay("a", 0.2), sim.TransportDelay("b", 0.3)
    found = sim.simulate(chain(sim.StepSignal("h", 0.5, 2.0), *delays, sim.Integrator("i")), TIMES)
    assert np.allclose(found["i"][:, 0], 2.0 * np.maximum(TIMES - 1.0, 0.0), rtol=0.0, atol=1e-12)


def test_a_relay_behind_a_delay_oscillates_with_its_dead_time():
    """x' = 1 or -1 by a relay at +-0.1 that sees x 0.05 late: amplitude 0.1 + 0.05, period 4 times that."""
    d = ring(sim.Integrator("x"), sim.TransportDelay("late", 0.05), sim.Relay("r", -0.1, 0.1, 1.0, -1.0))
    response = sim.simulate(d, np.linspace(0.0, 3.0, 301), **TIGHT)
    switched = [t for t, _ in response.events]
    assert np.allclose(switched, 0.15 + 0.3 * np.arange(len(switched)), rtol=0.0, atol=1e-9)
    assert len(switched) == 10


def test_a_delay_breaks_an_algebraic_loop():
    d = sim.Diagram().add(sim.StepSignal("h", 0.0), sim.Function("sum", lambda t, u: u[0] - 0.5 * u[1], 2, 1))
    d.add(sim.TransportDelay("late", 0.5)).connect("h", "sum:1").connect("late", "sum:2").connect("sum", "late")
    found = sim.simulate(d, TIMES)
    assert not any("algebraic" in note for note in found.notes)
    # u_k = 1 - u_(k-1)/2 in the k-th half second
    want, value = [], 0.0
    for _ in range(8):
        value = 1.0 - 0.5 * value
        want.append(value)
    assert np.allclose(found["sum"][6:100:12, 0], want, rtol=0.0, atol=1e-12)


def test_wrong_delays():
    for lag in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(UsageError, match="late: the delay must be positive"):
            sim.TransportDelay("late", lag)
