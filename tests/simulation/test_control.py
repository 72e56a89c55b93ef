"""python-control systems (optional extra): the same closed loop through `control.interconnect`."""

import sys

import numpy as np
import pytest

import spacar
from spacar.errors import UsageError
from spacar.simulation import Sampled, Saturation, Spasim, TransportDelay, as_control, closed_loop
from tests.examples import DATA


def test_interconnect_gives_the_same_response():
    control = pytest.importorskip("control")
    moments = np.array([0.0, 196.98, 82.276])

    def law(t, y):
        return moments - 500.0 * y[:3] - 50.0 * y[3:6] + np.array([40.0 * np.sin(5.0 * t), 0.0, 0.0])

    times = np.linspace(0.0, 0.3, 16)
    ours = closed_loop(Spasim(DATA / "robotsim.dat"), law, times, feedback="1-6", rtol=1e-8, atol=1e-10)
    plant = as_control(Spasim(DATA / "robotsim.dat"), numbered=True)
    pd = control.NonlinearIOSystem(None, lambda t, x, u, params: law(t, u), name="pd", inputs=6, outputs=3)
    # accelerations (y7 to y9) are outputs of the whole and are not fed back: no algebraic loop
    loop = control.interconnect(
        [plant, pd],
        connections=[
            *[[f"pd.u[{k}]", f"plant.y{k + 1}"] for k in range(6)],
            *[[f"plant.u{k + 1}", f"pd.y[{k}]"] for k in range(3)],
        ],
        outlist=[f"plant.y{k + 1}" for k in range(9)],
    )
    x0 = Spasim(DATA / "robotsim.dat").start()
    theirs = control.input_output_response(loop, times, 0, x0, solve_ivp_kwargs={"rtol": 1e-8, "atol": 1e-10})
    assert pytest.approx(ours["plant"][:, :6], abs=1e-6) == theirs.outputs[:6].T
    assert pytest.approx(ours["plant:7-9"], abs=1e-3) == theirs.outputs[6:9].T


def test_names_follow():
    control = pytest.importorskip("control")
    robot = as_control(Spasim(DATA / "robotsim.dat", "robot"))
    assert robot.input_labels[0] == "INPUTS element 1 (HINGE) e1 relative rotation"
    assert robot.output_labels[9] == "OUTX node 8 x"
    assert robot.state_labels[3].startswith("rate of element 1")
    gain = control.ss([], [], [], [[-5.0]], name="p", inputs="q", outputs="M")
    loop = control.interconnect(
        [robot, gain],
        connections=[["p.q", f"robot.{robot.output_labels[0]}"], [f"robot.{robot.input_labels[0]}", "p.M"]],
        outlist=["robot.OUTX node 8 x"],
        warn_duplicate=False,
        check_unused=False,
    )
    assert loop.noutputs == 1
    limit = Saturation("limit", -1.0, 1.0)
    with pytest.raises(UsageError, match="limit is smooth only piecewise"):
        as_control(limit)


def test_state_space_of_a_result_has_names():
    result = spacar.run(9, DATA / "lever.dat")
    system = result.ss()
    A, B, C, D = system
    step = result.frames[0].state_space
    assert np.array_equal(A, step["A"])
    assert np.array_equal(B, step["B"])
    assert np.array_equal(C, step["C"])
    assert D.shape == (len(C), B.shape[1])
    assert len(system.states) == len(A)
    assert system.inputs == ("INX node 4 x",) or system.inputs[0].startswith("IN")
    assert "states" in repr(system)
    with pytest.raises(UsageError, match="step 2 does not exist"):
        result.ss(2)
    with pytest.raises(UsageError, match="mode 1 has no state space; modes 3, 4 and 9"):
        spacar.run(1, DATA / "slider.dat").ss()


def test_mode_3_names_every_column(robot):
    data = robot[1]
    assert len(data.inputs) == data.B.shape[2]
    assert len(data.outputs) == data.C.shape[1]


@pytest.mark.parametrize(
    ("block", "there", "said"),
    [
        (Sampled("c", lambda t, x, u: (x, u), 0.1, 1, 1), True, "c is sampled"),
        (TransportDelay("late", 1.0), True, "late remembers its input"),
        (Sampled("c", lambda t, x, u: (x, u), 0.1, 1, 1), False, r"pip install 'spacar\[control\]'"),
    ],
    ids=["sampled", "delay", "without python-control"],
)
def test_what_is_no_system_of_states(monkeypatch, block, there, said):
    if there:
        pytest.importorskip("control")
    else:
        monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(UsageError, match=said):
        as_control(block)
