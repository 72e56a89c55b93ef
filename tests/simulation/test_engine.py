"""Blocks, diagrams and the engine against closed forms."""

import numpy as np
import pytest
import scipy.integrate

import spacar
from spacar import simulation as sim
from spacar.errors import AnalysisError, UsageError
from spacar.integrators import NAMES, named
from spacar.simulation import Continuous, Diagram, Function, Linear, Spasim, simulate
from tests.examples import DATA
from tests.inverse import arm

from .diagrams import ring

TIMES = np.linspace(0.0, 2.0, 21)


def integrator(x0=0.0, name="i"):
    return sim.Linear(name, [[0.0]], [[1.0]], [[1.0]], x0=[x0])


def test_linear_loop_equals_the_closed_form():
    """x' = -3 x + 1 by feedback around an integrator."""
    d = sim.Diagram().add(integrator(2.0), sim.Gain("k", -3.0), sim.Function("one", lambda t: 1.0, 0, 1))
    d.connect("i", "k").connect("k", "i").connect("one", "i")
    r = sim.simulate(d, TIMES, rtol=1e-10, atol=1e-12)
    assert r["i"][:, 0] == pytest.approx(1 / 3 + (2 - 1 / 3) * np.exp(-3 * TIMES), abs=1e-9)
    assert r["k"][:, 0] == pytest.approx(-3 * r["i"][:, 0])


def test_sampled_feedback_equals_the_difference_equation():
    """x_(k+1) = x_k - T g x_k exactly, for a held u = -g x; with delay, u lags one period."""
    T, g = 0.1, 4.0
    for delay in (False, True):
        sampled = sim.Sampled("c", lambda t, m, u: (m + 1, -g * u), T, 1, 1, x0=0, delay=delay)
        r = sim.simulate(ring(integrator(1.0), sampled), TIMES, rtol=1e-10, atol=1e-12)
        x, u, truth = 1.0, 0.0, []
        for _ in TIMES:
            truth.append(x)
            now = u if delay else -g * x
            u = -g * x
            x += T * now
        assert r["i"][:, 0] == pytest.approx(truth, abs=1e-12)
        assert sampled.memory == len(TIMES)


def test_a_second_simulation_starts_afresh():
    sampled = sim.Sampled("c", lambda t, m, u: (m + 1, [m]), 0.5, 1, 1, x0=0)
    d = ring(integrator(), sampled)
    first, second = sim.simulate(d, TIMES), sim.simulate(d, TIMES)
    assert np.array_equal(first.y, second.y)


def test_events_are_located_and_can_end_the_simulation():
    """A fall from 1 m with g = 9.81: the ground is met at sqrt(2/g)."""
    fall = sim.Continuous("fall", lambda t, x, u: [x[1], -9.81], lambda t, x, u: x[:1], [1.0, 0.0], 0, 1)
    ground = sim.Event("ground", lambda t, s: s["fall:1"][0], terminal=True, direction=-1)
    half = sim.Event("half", lambda t, s: s["fall"][0] - 0.5)
    r = sim.simulate(sim.Diagram().add(fall), TIMES, events=[ground, half], rtol=1e-10, atol=1e-12)
    assert [name for _, name in r.events] == ["half", "ground"]
    # a parabola is exact for the method and its interpolation
    assert r.events[0][0] == pytest.approx(np.sqrt(1 / 9.81), abs=1e-12)
    assert r.t[-1] == pytest.approx(np.sqrt(2 / 9.81), abs=1e-12)
    assert r["fall"][-1, 0] == pytest.approx(0.0, abs=1e-12)


def test_jump_of_an_input_is_not_smeared():
    source = sim.Function("step", lambda t: float(t >= 0.73), 0, 1, breaks=[0.73])
    r = sim.simulate(sim.Diagram().add(source, integrator()).connect("step", "i"), TIMES)
    # exact but for the four rounding units next to the jump
    assert r["i"][:, 0] == pytest.approx(np.maximum(0.0, TIMES - 0.73), abs=1e-13)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [("step", [0.0, 0.0, 4.0, 4.0]), ("linear", [0.0, 0.4, 1.0 + 0.6 * 3.0, 4.0]), ("spline", [0.0, 0.16, 2.56, 4.0])],
)
def test_tables(kind, expected):
    """Values of t^2 stored at 0, 1, 2, 3: a not-a-knot spline reproduces it."""
    t = np.arange(4.0)
    table = sim.Table(t, t**2, kind)
    assert [float(table(v)) for v in (0.0, 0.4, 1.6, 2.0)] == pytest.approx(expected, abs=1e-12)


def test_beyond_the_table():
    table = sim.Table([0.0, 1.0], [2.0, 3.0], name="u0 of x.ltv")
    with pytest.raises(AnalysisError, match=r"u0 of x.ltv is stored from t = 0 to 1 s, but needed at t = 1.5"):
        table(1.5)
    assert sim.Table([0.0, 1.0], [2.0, 3.0], hold=True)(1.5) == 3.0


# -- refusals -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("returned", "why"),
    [
        ([1.0, 2.0], r"the output of c at t = 0 has the shape \(2,\); expected \(1,\)"),
        (np.nan, "the output of c at t = 0: component 1 is nan"),
        (None, "component 1 is nan|is no vector of numbers"),
        ("text", "is no vector of numbers"),
    ],
)
def test_controller_with_a_wrong_result(returned, why):
    sampled = sim.Sampled("c", lambda t, x, u: (x, returned), 0.1, 1, 1)
    for controller in (sim.Function("c", lambda t, u: returned, 1, 1), sampled):
        with pytest.raises(AnalysisError, match=why):
            sim.simulate(ring(integrator(), controller), TIMES)


def test_controller_that_raises_or_returns_no_pair():
    with pytest.raises(AnalysisError, match="c failed at t = 0: ZeroDivisionError"):
        sim.simulate(ring(integrator(), sim.Function("c", lambda t, u: 1 / 0, 1, 1)), TIMES)
    with pytest.raises(AnalysisError, match=r"c must return its new state and its output, \(x, y\)"):
        sim.simulate(ring(integrator(), sim.Sampled("c", lambda t, x, u: 1.0, 0.1, 1, 1)), TIMES)


def test_wrong_wires_and_names():
    d = sim.Diagram().add(integrator(), sim.Gain("k", np.eye(2)))
    for source, target, why in (
        ("i", "k", "1 outputs cannot be connected to 2 inputs"),
        ("x", "k", "there is no block x; the blocks are i, k"),
        ("i:2", "k:1", "block i has the outputs 1 to 1"),
        ("i:a", "k:1", "'a' is no signal number"),
    ):
        with pytest.raises(UsageError, match=why):
            d.connect(source, target)
    with pytest.raises(UsageError, match="two blocks with the name i"):
        d.add(integrator())
    with pytest.raises(UsageError, match="cannot be the name of a block"):
        d.add(integrator(name="my block"))


def test_unstable_loop_is_a_failure_with_advice():
    d = sim.Diagram().add(sim.Continuous("x", lambda t, x, u: x**2, lambda t, x, u: x, [1.0], 0, 1))
    with pytest.raises(AnalysisError, match=r"step size became too small|is inf|overflow"):
        sim.simulate(d, TIMES)


def test_unconnected_inputs_are_mentioned():
    r = sim.simulate(sim.Diagram().add(integrator(1.0)), TIMES)
    assert r.notes == ("input 1 (u1) of i is not connected: it is zero",)


def test_wrong_size_of_a_direct_call():
    plant = Spasim(arm.deck(arm.FREE_JOINTS, [("INPUTS", 1, 1, 1), ("OUTE", 1, 1, 1)], mode="simulation"))
    with pytest.raises(ValueError, match=r"state has the shape \(3,\), expected \(4,\)"):
        plant.derivative(0.0, np.zeros(3), np.zeros(1))
    with pytest.raises(ValueError, match=r"input has the shape \(2,\), expected \(1,\)"):
        plant.derivative(0.0, plant.start(), np.zeros(2))
    with pytest.raises(UsageError, match="needs dynamic degrees of freedom"):
        Spasim(arm.deck(arm.PRESCRIBED_JOINTS, mode="simulation"))
    with pytest.raises(AnalysisError, match=r"output of control at t = 0 has the shape \(3,\)"):
        sim.closed_loop(plant, lambda t, y: np.zeros(3), TIMES)


def test_force_inputs_equal_applied_forces():
    """INPUTF u against XF of the same size in mode 1: accelerations of the joints."""
    ports = [("INPUTF", 1, 7, 1), ("INPUTF", 2, 7, 2), ("INPUTS", 3, 2, 1), ("OUTEDP", 1, 1, 1), ("OUTEDP", 2, 2, 1)]
    plant = Spasim(arm.deck(arm.FREE_JOINTS, ports, mode="simulation"))
    y = plant.outputs(0.0, plant.start(), np.array([3.0, -7.0, 2.5]))
    # a driving moment u is the stress -u
    loaded = arm.deck(arm.FREE_JOINTS, mode=1, dynamics=[*arm.DYNAMICS, ("XF", 7, 3.0, -7.0), ("ESIG", 2, -2.5)])
    expected = spacar.run(1, loaded)
    assert y == pytest.approx([expected.element(i, 1, "edd")[0] for i in (1, 2)], rel=1e-12)


def test_nonholonomic_plant_equals_mode_1():
    """The tricycle rolls in the simulation as in mode 1 (tolerances 1e-9)."""
    path = DATA / "trike2.dat"
    text = path.read_text().replace("END\nEND", "END\nHALT\nINPUTS 1 6 1\nOUTX 1 1 1\nOUTXDP 2 1 1\nEND\nEND")
    plant = Spasim(spacar.parse_deck(text, "trike2.dat", "simulation"))
    times = np.linspace(0.0, 1.0, 11)
    r = sim.simulate(sim.Diagram().add(plant), times, rtol=1e-9, atol=1e-10)
    truth = spacar.run(1, path, atol=1e-10, rtol=1e-9)
    assert r["plant:1"][:, 0] == pytest.approx(truth.node(1, 1)[::10], abs=1e-8)
    assert r["plant:2"][:, 0] == pytest.approx(truth.node(1, 1, "xdd")[::10], abs=1e-7)


# Simulations run on the integrators of mode 1, by the same codes; the names of SciPy are aliases in one table.
def oscillator():
    """x'' = -9 x - 0.4 x' + cos 2 t."""
    plant = Linear("p", [[0.0, 1.0], [-9.0, -0.4]], [[0.0], [1.0]], [[1.0, 0.0]], x0=[1.0, 0.0])
    return Diagram().add(plant, Function("force", lambda t: np.cos(2 * t), 0, 1)).connect("force", "p")


def truth():
    """By a code of other people at its tightest tolerance."""

    def rhs(t, y):
        return [y[1], -9 * y[0] - 0.4 * y[1] + np.cos(2 * t)]

    return scipy.integrate.solve_ivp(rhs, (0, 2), [1, 0], "DOP853", TIMES, rtol=1e-13, atol=1e-14).y[0]


@pytest.mark.parametrize("method", [135, 155, 853, 553, 595, "853"])
def test_codes_of_integrat(method):
    r = simulate(oscillator(), TIMES, method=method, rtol=1e-8, atol=1e-10)
    # errors of some hundred steps of 1e-8 add up
    assert r["p"][:, 0] == pytest.approx(truth(), abs=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_the_code_bit_for_bit(name):
    by_name, by_code = (simulate(oscillator(), TIMES, method=m) for m in (name, NAMES[name]))
    assert np.array_equal(by_name.y, by_code.y)
    assert by_name.statistics == by_code.statistics
    assert named(name.lower()) is named(NAMES[name])


def test_155_takes_the_steps_that_scipy_takes():
    """The same pair of formulas under the same tolerance: about the same number of steps."""
    r = simulate(oscillator(), TIMES, rtol=1e-8, atol=1e-10)
    s = scipy.integrate.RK45(
        lambda t, y: [y[1], -9 * y[0] - 0.4 * y[1] + np.cos(2 * t)], 0, [1, 0], 2, rtol=1e-8, atol=1e-10
    )
    n = 0
    while s.status == "running":
        s.step()
        n += 1
    assert 0.8 * n <= r.statistics["steps"] <= 1.25 * n


def test_a_stiff_loop_wants_an_implicit_code():
    """x' = -1e6 (x - cos t): stability holds 155 to 2e6/3.3 steps, 553 takes less than 200."""
    stiff = Continuous("s", lambda t, x, u: [-1e6 * (x[0] - np.cos(t))], lambda t, x, u: x, [1.0], 0, 1)
    r = simulate(Diagram().add(stiff), TIMES, method=553)
    assert r.statistics["steps"] < 200
    assert r["s"][:, 0] == pytest.approx(np.cos(TIMES), abs=2e-6)  # x lags by 1e-6 s


def test_the_largest_step_is_kept():
    """A pulse of 0.02 s between the steps of a slow motion is seen when max_step is 0.01 s."""
    pulse = Continuous("s", lambda t, x, u: [float(0.9 < t < 0.92)], lambda t, x, u: x, [0.0], 0, 1)
    r = simulate(Diagram().add(pulse), TIMES, max_step=0.01)
    assert r["s"][-1, 0] == pytest.approx(0.02, rel=1e-4)
    assert r.statistics["steps"] >= 200


@pytest.mark.parametrize(
    ("method", "sentence"),
    [("Euler", "method 'Euler' does not exist"), (7, "unknown integration code 7"),
     (410, "method 410 cannot be used here"),
     (0, "method 0 cannot be used here; choose 135, 155, 553, 595, 853")],
)  # fmt: skip
def test_wrong_methods(method, sentence):
    with pytest.raises(UsageError, match=sentence):
        simulate(oscillator(), TIMES, method=method)


def test_a_mistake_of_a_block_is_not_tried_again():
    calls = []

    def wrong(t, x, u):
        calls.append(t)
        return [np.nan if t > 0.5 else 1.0]

    block = Continuous("c", wrong, lambda t, x, u: x, [0.0], 0, 1)
    with pytest.raises(AnalysisError, match=r"states of c at t = .*component 1 is nan") as found:
        simulate(Diagram().add(block), TIMES)
    assert found.value.code.startswith("simulation.")
    assert sum(t > 0.5 for t in calls) == 1


def test_an_edge_at_the_last_time_does_not_enter_the_piece_before_it():
    """The area of pulses is exact, and the last value is that behind the edge."""
    d = Diagram().add(sim.Pulses("p", 0.1, 0.5), sim.Integrator("area")).connect("p", "area")
    r = simulate(d, [0.0, 1.0, 2.0])
    assert r["area"][:, 0] == pytest.approx([0.0, 0.5, 1.0], abs=1e-13)
    assert r["p"][-1] == 1.0


@pytest.mark.parametrize(
    "block", [sim.Pulses("fast", 1e-7), sim.zero_order_hold("fast", 5e-8)], ids=["edges", "samples"]
)
def test_stops_that_do_not_fit_in_memory_are_refused_before_the_start(block):
    d = Diagram().add(sim.Constant("one", 1.0), block)
    with pytest.raises(UsageError, match=r"fast: the integration stops 2e\+07 times in 1 s.*a longer period helps"):
        simulate(d.connect("one", "fast") if block.n_in else d, [0.0, 1.0])
