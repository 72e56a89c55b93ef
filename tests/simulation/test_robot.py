"""The manipulator example of the manual (bibliography.md), its section 3.11, as a controlled simulation."""

import numpy as np
import pytest
from numpy.linalg import norm

import spacar
from spacar import simulation as sim
from spacar.errors import UsageError
from spacar.inverse.profile import make_profile
from tests.examples import DATA
from tests.inverse import arm

from .diagrams import chain

TIMES = np.linspace(0.0, 1.5, 151)
WEIGHTS = np.array([0.0, 196.98, 82.276])  # moments that hold the arm


def tip_error(response, nominal):
    reference = sim.ReferenceY0(nominal, hold=True)
    y0 = np.array([reference.outputs(t, None, None)[9:12] for t in response.t])
    return norm(response["plant:10-12"] - y0, axis=1)


def test_static_moments_give_no_acceleration():
    plant = sim.Spasim(DATA / "robotsim.dat")
    y = plant.outputs(0.0, plant.start(), WEIGHTS)
    assert y[6:9] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
def test_closed_loop_stays_within_a_millimetre(robot):
    nominal, linear = robot
    law = sim.computed_torque(nominal, linear, 28.0, 0.85, positions=[1, 2, 3], rates=[4, 5, 6], hold=True)
    response = sim.closed_loop(sim.Spasim(DATA / "robotsim.dat"), law, TIMES, feedback="1-6")
    error = tip_error(response, nominal)
    assert error.max() == pytest.approx(0.000615, abs=0.000385)  # expected.json
    assert error.max() < 1e-3


def test_blocks_give_the_same_as_the_control_law(robot):
    """u = u0 + M0 PD(y0 - y) wired from blocks, as in the block diagram of the manual."""
    nominal, linear = robot
    times = TIMES[:61]
    law = sim.computed_torque(nominal, linear, 28.0, 0.85, positions=[1, 2, 3], rates=[4, 5, 6], hold=True)
    direct = sim.closed_loop(sim.Spasim(DATA / "robotsim.dat"), law, times, feedback="1-6")
    diagram = sim.Diagram().add(
        sim.Spasim(DATA / "robotsim.dat"), sim.SetpointU0(nominal, "u0"), sim.ReferenceY0(nominal, "y0"),
        sim.TimesM0(linear, "m0"), sim.proportional_derivative("pd", 3, 28.0, 0.85),
    )  # fmt: skip
    diagram.connect("u0", "plant").connect("y0:1-6", "pd").connect("plant:1-6", "pd", -1.0)
    diagram.connect("pd", "m0").connect("m0", "plant")
    wired = sim.simulate(diagram, times)
    # the same equations and tolerances; only the order of the sums differs
    assert wired["plant"][:, :6] == pytest.approx(direct["plant"][:, :6], abs=1e-7)


@pytest.mark.slow  # the closed loop is the fast one
def test_open_loop_drifts_away(robot):
    nominal, _ = robot
    response = sim.simulate(chain(sim.SetpointU0(nominal, "u0", hold=True), sim.Spasim(DATA / "robotsim.dat")), TIMES)
    assert tip_error(response, nominal)[-1] == pytest.approx(0.183, abs=0.05)  # expected.json


@pytest.mark.slow
def test_sampled_controller_tends_to_the_continuous_one(robot):
    """First order in the sampling period: halving it halves the difference."""
    nominal, linear = robot
    law = sim.computed_torque(nominal, linear, 28.0, 0.85, positions=[1, 2, 3], rates=[4, 5, 6])
    times = np.linspace(0.0, 0.5, 26)
    plant = sim.Spasim(DATA / "robotsim.dat")
    exact = sim.closed_loop(plant, law, times, feedback="1-6")["plant:1-3"]
    off = [
        np.abs(sim.closed_loop(plant, law, times, feedback="1-6", period=p)["plant:1-3"] - exact).max()
        for p in (0.01, 0.005)
    ]
    assert off[0] / off[1] == pytest.approx(2.0, abs=0.5)


@pytest.mark.parametrize("front", [0, 1, 2])
def test_forward_dynamics_with_the_torques_retraces_the_path(front):
    """Closed-form torques of the inverse problem on the free arm (error tolerance 1e-10, growth over 1 s about 100)."""
    end = np.array([-0.1, 0.75])
    length = float(norm(end - arm.START))
    profile = make_profile(length, 1.0, 0.3, 1.3, front)
    unit = (end - arm.START) / length

    def torque(t):
        p, v, a = profile.at(t)
        return arm.torques(*arm.joints(arm.START + p * unit, v * unit, a * unit))

    ports = [("INPUTS", 1, 1, 1), ("INPUTS", 2, 2, 1), ("OUTX", 1, 7, 1), ("OUTX", 2, 7, 2)]
    plant = sim.Spasim(arm.deck(arm.FREE_JOINTS, ports, mode="simulation"))
    source = sim.Function("u", torque, 0, 2, breaks=profile.breaks)
    times = np.linspace(0.0, 1.0, 11)
    response = sim.simulate(chain(source, plant), times, method="DOP853", rtol=1e-10, atol=1e-11)
    path = arm.START + np.outer([profile.at(t)[0] for t in times], unit)
    assert response["plant"] == pytest.approx(path, abs=1e-8)


def test_mode_2_torques_retrace_the_path_through_a_spline():
    """u0 of mode 2 interpolated by a cubic spline: an error of order h^4, micrometres (h = 5 ms, front 2)."""
    motion = [
        ("TRAJECT", 1), ("TRANS", 7, -0.1, 0.75), ("TRFRONT", 7, 2), ("TRTIME", 1.0, 200), *arm.MOTORS, *arm.REFERENCES,
    ]  # fmt: skip
    inverse = spacar.run(2, arm.deck(arm.END_POINT, motion))
    ports = [("INPUTS", 1, 1, 1), ("INPUTS", 2, 2, 1), ("OUTX", 1, 7, 1), ("OUTX", 2, 7, 2)]
    plant = sim.Spasim(arm.deck(arm.FREE_JOINTS, ports, mode="simulation"))
    u0 = sim.SetpointU0(sim.TimeVarying.of(inverse), "u0", "spline")
    response = sim.simulate(chain(u0, plant), inverse.t, rtol=1e-9, atol=1e-10)
    assert response["plant:1"][:, 0] == pytest.approx(inverse.node(7, 1), abs=1e-5)


def test_accelerations_may_be_fed_back_but_not_to_a_sampled_law(robot):
    """Accelerations that are fed back are an algebraic loop, which is solved; to a sampled law it is refused."""
    plant = sim.Spasim(DATA / "robotsim.dat")
    with pytest.raises(UsageError, match=r"algebraic loop: .*control.*accelerations"):
        sim.closed_loop(plant, lambda t, y: np.zeros(3), TIMES, period=0.01)
    moved = np.array([5.0, 196.98, 82.276])
    start = sim.closed_loop(plant, lambda t, y: moved, TIMES[:2], feedback="1-6")["plant:7-9"][0]
    fed = sim.closed_loop(plant, lambda t, y: moved - 2.0 * y[6:9], TIMES[:2], rtol=1e-9)
    a, u = fed["plant:7-9"][0], fed["control"][0]
    assert u == pytest.approx(moved - 2.0 * a, abs=1e-10)
    assert 0.0 < a[0] < start[0]
    heavier = np.linalg.solve(np.diag([start[0] / 5.0, 1, 1]), [a[0], 0, 0])[0]  # J a = u with J = 5 / start
    assert heavier == pytest.approx(u[0], rel=1e-9)
    response = sim.closed_loop(plant, lambda t, y: WEIGHTS, TIMES[:11], feedback="1-6")
    assert response["plant:7-9"] == pytest.approx(0.0, abs=1e-8)
    delayed = sim.closed_loop(plant, lambda t, y: WEIGHTS, TIMES[:3], feedback="1-6", period=0.01)
    assert delayed["plant:7-9"] == pytest.approx(0.0, abs=1e-8)
