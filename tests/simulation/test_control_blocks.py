"""Blocks of a controller against closed forms, scipy.signal and difference equations written out."""

from functools import partial

import numpy as np
import pytest
from scipy import signal

from spacar import simulation as sim
from spacar.errors import AnalysisError, UsageError

from .diagrams import chain, ring

TIMES = np.linspace(0.0, 2.0, 201)
TIGHT = {"rtol": 1e-11, "atol": 1e-12}


def through(block, source, times=TIMES, **options):
    """The output of a block with one input behind a source."""
    return sim.simulate(chain(source, block), times, **{**TIGHT, **options})


def sine(t):
    return 2.0 * np.sin(2.0 * np.pi * t)


SINE = ("s", 2.0, 1.0)


# -- sources ------------------------------------------------------------------------------------------------------
def test_sources():
    d = sim.Diagram().add(
        sim.Constant("c", [1.0, 2.0]), sim.StepSignal("h", 0.735, 3.0, 1.0), sim.Ramp("r", 2.0, 0.5),
        sim.Sine(*SINE, phase=0.3, bias=1.0),
        sim.Pulses("p", 0.7, 0.25, 1.0, -1.0, time=0.1), sim.TimeSeries("v", [0.0, 1.0, 2.0], [0.0, 1.0, 4.0]),
    )  # fmt: skip
    r = sim.simulate(d, TIMES)
    assert np.all(r["c"] == [1.0, 2.0])
    np.testing.assert_array_equal(r["h"][:, 0], np.where(TIMES < 0.735, 1.0, 3.0))
    np.testing.assert_allclose(r["r"][:, 0], 2.0 * np.maximum(0.0, TIMES - 0.5), atol=1e-14)
    np.testing.assert_allclose(r["s"][:, 0], 1.0 + 2.0 * np.sin(2 * np.pi * TIMES + 0.3), atol=1e-14)
    part = (TIMES - 0.1) / 0.7 % 1.0
    clear = np.minimum(np.abs(part - 0.25), np.minimum(part, 1 - part)) > 1e-9  # not beside an edge
    truth = np.where((TIMES >= 0.1) & (part < 0.25), 1.0, -1.0)
    np.testing.assert_array_equal(r["p"][clear, 0], truth[clear])
    np.testing.assert_allclose(r["v"][:, 0], np.interp(TIMES, [0, 1, 2], [0, 1, 4]), atol=1e-14)


def test_edges_of_pulses_are_met_exactly():
    r = through(sim.Integrator("i"), sim.Pulses("p", 0.7, 0.25, time=0.1), [0.0, 1.9], rtol=1e-3, atol=1e-3)
    assert r["i"][-1, 0] == pytest.approx(3 * 0.175, abs=1e-13)  # 0.1, 0.8 and 1.5 s


def test_product():
    assert sim.simulate(chain(sim.Constant("c", [2.0, 3.0]), sim.Product("m")), [0.0, 1.0])["m"][-1] == [6.0]


# -- piecewise ----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("block", "truth"),
    [
        (sim.DeadZone("b", -0.5, 1.0), lambda u: np.where(u > 1, u - 1, np.where(u < -0.5, u + 0.5, 0.0))),
        (sim.Quantizer("b", 0.3), lambda u: 0.3 * np.floor(u / 0.3 + 0.5)),
        (sim.LookupTable("b", [-1, 0, 1.5], [3, 0, 1]), lambda u: np.interp(u, [-1, 0, 1.5], [3, 0, 1])),
        (sim.LookupTable("b", [-1, 0, 1.5], [3, 0, 1], beyond="extrapolate"),
         lambda u: np.where(u < 0, -3 * u, u / 1.5)),
        (sim.LookupTable("b", [-1, 0, 1.5], [3, 0, 1], "step"),
         lambda u: np.where(u >= 1.5, 1.0, np.where(u >= 0, 0.0, 3.0))),
    ],
)  # fmt: skip
def test_static_characteristics(block, truth):
    times = TIMES + 1e-4  # no time at an edge
    r = through(block, sim.Sine(*SINE), times)
    np.testing.assert_allclose(r["b"][:, 0], truth(sine(times)), atol=1e-12)


def test_cubic_table_is_monotone_and_meets_its_points():
    from scipy.interpolate import PchipInterpolator

    x, y = [-2.0, -1.0, 0.0, 1.0, 2.0], [0.0, 0.0, 1.0, 1.0, 3.0]
    r = through(sim.LookupTable("b", x, y, "cubic"), sim.Sine(*SINE))
    np.testing.assert_allclose(r["b"][:, 0], PchipInterpolator(x, y)(sine(TIMES)), atol=1e-12)


def test_the_end_of_a_table_is_an_error_when_asked():
    why = r"b at t = 0.16666\d*: input 1 is 1.73\d*, the table reaches from -9 to 1.73"
    with pytest.raises(AnalysisError, match=why):
        through(sim.LookupTable("b", [-9.0, np.sqrt(3.0)], [0.0, 1.0], beyond="error"), sim.Sine(*SINE))


def test_quantized_signal_is_integrated_exactly():
    """The integral of floor(t/q + 1/2) q: each level is met at its time although the steps could be long."""
    d = chain(sim.Ramp("t", 1.0), sim.Quantizer("q", 0.3), sim.Integrator("i"))
    r = sim.simulate(d, [0.0, 1.0], rtol=1e-3, atol=1e-3)
    truth = 0.3 * (1 - 0.15) + 0.3 * (1 - 0.45) + 0.3 * (1 - 0.75)
    assert r["i"][-1, 0] == pytest.approx(truth, abs=1e-13)
    assert [round(t, 12) for t, _ in r.events] == [0.15, 0.45, 0.75]
    assert r.events[0][1] == "level of q"


def test_limit_cycle_of_a_relay_with_hysteresis():
    """x' = -y, y = +-1 with limits +-h: a triangle of amplitude h and period 4 h."""
    h = 0.13
    d = chain(sim.Integrator("x", initial=0.05), sim.Relay("y", -h, h, off=-1.0, on=1.0)).connect("y", "x", -1.0)
    r = sim.simulate(d, TIMES, rtol=1e-6)
    switches = [t for t, name in r.events if name == "switch of y"]
    np.testing.assert_allclose(switches, 0.08 + 2 * h * np.arange(len(switches)), atol=1e-12)
    assert len(switches) == 8
    assert np.abs(r["x"]).max() <= h + 1e-12


def test_a_relay_without_hysteresis_chatters_and_says_so():
    d = chain(sim.Integrator("x", initial=0.5), sim.Relay("y", 0.0, 0.0, -1.0, 1.0)).connect("y", "x", -1.0)
    with pytest.raises(AnalysisError, match=r"y chatters at t = 0.5: .*hysteresis"):
        sim.simulate(d, TIMES)


def test_modes_without_a_consistent_choice():
    """y = relay(u), u = 0.5 - y: on asks for off and off for on."""
    d = chain(sim.Constant("c", 0.5), sim.Relay("y", 0.0, 0.0), sim.Integrator("x")).connect("y", "y", -1.0)
    with pytest.raises(AnalysisError, match="the modes of y do not settle at t = 0"):
        sim.simulate(d, TIMES)


@pytest.mark.parametrize("block", [sim.unit_delay, partial(sim.sampled_rate_limiter, rising=1.0), sim.TransportDelay])
def test_initial_values_are_one_for_each_signal(block):
    with pytest.raises(UsageError, match="b: initial values are one number or 2, one for each signal"):
        block("b", 0.1, initial=[1.0, 2.0, 3.0], size=2)


# -- continuous controllers ---------------------------------------------------------------------------------------
def test_transfer_function():
    """(s + 3)/(s^2 + 2 s + 5) against scipy, and a constant one."""
    for numerator in ([1, 3], [2, 3, 4]):
        r = through(sim.transfer_function("g", numerator, [1, 2, 5]), sim.StepSignal("h"))
        _, truth = signal.step(signal.lti(numerator, [1, 2, 5]), T=TIMES)
        np.testing.assert_allclose(r["g"][:, 0], truth, atol=1e-9)
    assert through(sim.transfer_function("g", [6], [3]), sim.StepSignal("h"))["g"][-1, 0] == 2.0
    with pytest.raises(UsageError, match=r"no lower degree than the numerator, found \[1, 0\] over \[2\]"):
        sim.transfer_function("g", [1, 0], [2])


def test_limited_integrator():
    """x' = 2 sin(2 pi t) with x <= 0.5: it meets the limit, waits for the sign, and comes back without delay."""
    r = through(sim.Integrator("i", upper=0.5), sim.Sine(*SINE), TIMES)
    meets = np.arccos(1 - 0.5 * np.pi) / (2 * np.pi)
    assert r.events[0][0] == pytest.approx(meets, abs=1e-10)
    assert r.events[1][0] == pytest.approx(0.5, abs=1e-10)
    late = TIMES[(TIMES > 0.5) & (TIMES < 1.0)]
    np.testing.assert_allclose(
        r["i"][(TIMES > 0.5) & (TIMES < 1.0), 0], 0.5 - (1 + np.cos(2 * np.pi * late)) / np.pi, atol=1e-9
    )


def test_rate_limiter():
    """A step of 1 with rate 2 and bandwidth w: a ramp until w (1 - y) = 2, then exponential."""
    w = 20.0
    r = through(sim.RateLimiter("l", 2.0, bandwidth=w), sim.StepSignal("h"))
    t1 = (1 - 2 / w) / 2
    truth = np.where(t1 > TIMES, 2 * TIMES, 1 - 2 / w * np.exp(-w * (TIMES - t1)))
    np.testing.assert_allclose(r["l"][:, 0], truth, atol=1e-9)
    r = through(sim.RateLimiter("l", 2.0, 4.0, bandwidth=1e4), sim.Pulses("p", 2.0, 0.5), early := TIMES[TIMES <= 1.1])
    np.testing.assert_allclose(r["l"][early == 0.25, 0], 0.5, atol=1e-9)
    np.testing.assert_allclose(r["l"][early == 1.1, 0], 0.6, atol=3e-4)


def test_pid_without_limits_is_its_transfer_function():
    kp, ki, kd, N = 2.0, 3.0, 0.5, 10.0
    r = through(sim.PID("c", kp, ki, kd, filter=N), sim.Sine(*SINE))
    num = np.polyadd(np.polyadd(kp * np.array([1, N, 0]), ki * np.array([0, 1, N])), [kd * N, 0, 0])
    t = np.linspace(0, 2, 50001)  # linear between these: 2 (2 pi h)^2/8 = 2e-8 of error
    _, truth, _ = signal.lsim(signal.lti(num, [1, N, 0]), sine(t), t)
    np.testing.assert_allclose(r["c"][:, 0], truth[::250], atol=1e-6)


@pytest.mark.parametrize(("method", "integral"), [("none", 1.5), ("clamping", 0.5), ("back-calculation", None)])
def test_windup(method, integral):
    """kp = 1, ki = 1, e = 1 for 1.5 s, then -1; y <= 1.5, so v = 1 + t meets the limit at 0.5 s. Then v - 1 goes on
    (none), stays (clamping), or follows I' = 1 - (v - 1.5)/Tt: I = 0.5 + Tt (1 - exp(-(t - 0.5)/Tt))."""
    Tt = 0.2
    controller = sim.PID("c", 1.0, 1.0, upper=1.5, anti_windup=method, tracking_time=Tt)
    r = through(controller, sim.StepSignal("e", 1.5, -1.0, 1.0))
    if integral is None:
        integral = 0.5 + Tt * (1 - np.exp(-1.0 / Tt))
    k = np.searchsorted(TIMES, 1.6)
    assert np.all(r["c"][(TIMES > 0.51) & (TIMES < 1.49)] == 1.5)
    assert r["c"][k, 0] == pytest.approx(-1 + integral - (TIMES[k] - 1.5), abs=1e-9)


# -- sampled ------------------------------------------------------------------------------------------------------
def test_sampled_systems_against_dlsim():
    T, t = 0.1, np.arange(0.0, 2.05, 0.1)
    u = sine(t) + 0.3
    cases = [
        (sim.sampled_transfer_function("b", T, [1.0, 0.2], [1.0, -0.5, 0.06]), ([1.0, 0.2], [1.0, -0.5, 0.06], T)),
        (
            sim.sampled_transfer_function("b", T, [2.0, 1.0, 0.2], [1.0, -0.5, 0.06]),
            ([2.0, 1.0, 0.2], [1, -0.5, 0.06], T),
        ),
        (sim.sampled_linear("b", T, [[0.5]], [[1.0]], [[2.0]], [[0.3]]), ([[0.5]], [[1.0]], [[2.0]], [[0.3]], T)),
        (sim.unit_delay("b", T), ([1.0], [1.0, 0.0], T)),
        (sim.zero_order_hold("b", T), ([1.0], [1.0], T)),
    ]
    for block, system in cases:
        r = through(block, sim.Sine(*SINE, bias=0.3), np.concatenate((t, [2.05])))
        np.testing.assert_allclose(r["b"][: len(t), 0], signal.dlsim(system, u)[1][:, 0], atol=1e-12)
        assert r["b"][-1, 0] == r["b"][-2, 0]  # held


def test_discrete_controller_of_a_continuous_plant_equals_the_discretized_plant():
    """A PI controller in z around 1/(s^2 + s + 2), between samples as cont2discrete (zero-order hold) says."""
    T, n = 0.05, 60
    A, B, C = np.array([[0.0, 1.0], [-2.0, -1.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
    Ad, Bd, *_ = signal.cont2discrete((A, B, C, [[0.0]]), T)
    control = sim.sampled_transfer_function("c", T, [3.0, -2.8], [1, -1])
    d = sim.Diagram().add(sim.Constant("r", 1.0), sim.Linear("plant", A, B, C), control)
    d.connect("r", "c").connect("plant", "c", -1.0).connect("c", "plant")
    r = sim.simulate(d, np.arange(n) * T, **TIGHT)
    x, u, e, truth = np.zeros(2), 0.0, 0.0, []
    for _ in range(n):
        truth.append(x[0])
        new = 1.0 - x[0]
        u, e = u + 3.0 * new - 2.8 * e, new
        x = Ad @ x + Bd[:, 0] * u
    np.testing.assert_allclose(r["plant"][:, 0], truth, atol=1e-10)


def test_two_rates_and_an_offset():
    """A delay of 0.2 s behind a hold of 0.1 s, sampled 0.05 s later."""
    d = chain(sim.Ramp("t", 1.0), sim.zero_order_hold("h", 0.1, offset=0.05), sim.unit_delay("d", 0.2))
    r = sim.simulate(d, [0.0, 0.12, 0.22, 0.42, 0.62])
    np.testing.assert_allclose(r["h"][:, 0], [0.0, 0.05, 0.15, 0.35, 0.55], atol=1e-14)
    np.testing.assert_allclose(r["d"][:, 0], [0.0, 0.0, 0.0, 0.15, 0.35], atol=1e-14)


@pytest.mark.parametrize("method", ["none", "clamping", "back-calculation"])
def test_sampled_pid_is_its_difference_equation(method):
    T, n, kp, ki, kd, N, Tt = 0.05, 40, 2.0, 3.0, 0.1, 15.0, 0.3
    c = sim.sampled_pid("c", T, kp, ki, kd, filter=N, lower=-2.0, upper=1.5, anti_windup=method, tracking_time=Tt)
    r = through(c, sim.Sine(*SINE), np.arange(n) * T)
    integral = slope = 0.0
    old, truth = 0.0, []
    for k in range(n):
        e = sine(k * T)
        slope = (slope + kd * N * (e - (old if k else e))) / (1 + N * T)
        v = kp * e + integral + slope
        y = min(max(v, -2.0), 1.5)
        truth.append(y)
        grows = not (method == "clamping" and (v - y) * e > 0)
        integral += T * ki * e * grows + (T / Tt * (y - v) if method == "back-calculation" else 0.0)
        old = e
    np.testing.assert_allclose(r["c"][:, 0], truth, atol=1e-12)


def test_sampled_rate_limiter():
    times = np.append(0.0, np.arange(20) * 0.1 + 0.01)
    r = through(sim.sampled_rate_limiter("l", 0.1, 2.0, 4.0), sim.Pulses("p", 2.0, 0.5), times)
    truth = [0.2, 0.4, 0.6, 0.8, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.6, 0.2, 0, 0, 0, 0, 0, 0, 0, 0]
    np.testing.assert_allclose(r["l"][1:, 0], truth, atol=1e-12)


# -- algebraic loops ----------------------------------------------------------------------------------------------
def test_a_linear_loop_is_solved():
    """y = K (r - y) + 1 in two channels: y = (1 + K)^-1 (K r + 1)."""
    K = np.array([[2.0, 1.0], [-1.0, 3.0]])
    d = sim.Diagram().add(
        sim.Sine("r", [1.0, 3.0], 1.0), sim.Gain("k", K), sim.Gain("b", -np.eye(2)), sim.Constant("one", [1.0, 1.0])
    )
    d.add(sim.Gain("sum", np.eye(2)))
    d.connect("r", "k").connect("b", "k").connect("k", "sum").connect("one", "sum").connect("sum", "b")
    r = sim.simulate(d, TIMES)
    truth = np.linalg.solve(np.eye(2) + K, K @ r["r"].T + 1.0).T
    np.testing.assert_allclose(r["sum"], truth, rtol=0, atol=1e-14)
    assert any("the algebraic loop" in note and "2 unknowns" in note for note in r.notes)


def test_a_nonlinear_loop_is_solved():
    """y = cos y by a function fed back to itself: the Dottie number."""
    d = chain(sim.Function("cos", lambda t, u: np.cos(u), 1, 1), sim.Integrator("i")).connect("cos", "cos")
    r = sim.simulate(d, [0.0, 1.0])
    assert r["cos"][:, 0] == pytest.approx(0.7390851332151607, abs=1e-15)
    assert r["i"][-1, 0] == pytest.approx(0.7390851332151607, abs=1e-13)


def test_a_loop_through_a_saturation():
    """y = clip(3 (r - y), -1, 1): 0.75 r inside, the limit outside; switches at |r| = 4/3."""
    d = chain(sim.Sine(*SINE), sim.Gain("k", 3.0), sim.Saturation("lim", -1.0, 1.0), sim.Integrator("i"))
    d.connect("lim", "k", -1.0)
    r = sim.simulate(d, TIMES)
    np.testing.assert_allclose(r["lim"][:, 0], np.clip(0.75 * sine(TIMES), -1, 1), atol=1e-13)
    first = np.arcsin(2 / 3) / (2 * np.pi)
    assert r.events[0][0] == pytest.approx(first, abs=1e-13)


def test_loops_that_have_no_solution_are_named():
    for gain, K in ((1.0, 1.0), (0.5, 2.0)):
        d = ring(sim.Gain("a", gain), sim.Gain("b", K)).add(sim.Constant("c", 1.0), sim.Integrator("i"))
        d.connect("c", "a").connect("a", "i")
        why = r"algebraic loop a <- b <- a has no solution at t = 0: it has the gain one"
        with pytest.raises(AnalysisError, match=why):
            sim.simulate(d, TIMES)
    d = ring(sim.Function("f", lambda t, u: u * u + 1.0, 1, 1))
    with pytest.raises(AnalysisError, match=r"the algebraic loop f <- f has no solution at t = 0: "):
        sim.simulate(d, TIMES)


def test_acceleration_feedback_is_virtual_mass():
    """m x'' = F - k x'' is a mass m + k: x = F t^2 / (2 (m + k))."""
    m, k = 2.0, 3.0
    mass = sim.Linear("mass", [[0, 1], [0, 0]], [[0], [1 / m]], [[1, 0], [0, 0]], [[0], [1 / m]])
    d = chain(sim.Constant("F", 7.0), mass).connect("mass:2", "mass", -k)
    r = sim.simulate(d, TIMES, **TIGHT)
    np.testing.assert_allclose(r["mass:1"][:, 0], 7.0 / (2 * (m + k)) * TIMES**2, atol=1e-12)


def test_a_sampled_block_in_a_loop_is_refused_and_a_delay_breaks_it():
    with pytest.raises(UsageError, match=r"algebraic loop: (a <- h <- a|h <- a <- h); .* the sampled block h cannot"):
        sim.simulate(ring(sim.Gain("a", 0.5), sim.zero_order_hold("h", 0.1)), TIMES)
    d = ring(sim.Gain("a", 0.5), sim.unit_delay("h", 0.1, initial=1.0))
    assert sim.simulate(d, TIMES)["h"][-1, 0] == pytest.approx(0.5**20)
