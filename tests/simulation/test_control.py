"""python-control systems (optional extra): the same closed loop through `control.interconnect`."""

import shutil
import sys

import numpy as np
import pytest
from spacar_cli.main import main
from spacar_formats.fmu import export_fmu, identifier, variables

import spacar
from spacar.errors import UsageError
from spacar.simulation import Function, Sampled, Saturation, Spasim, TransportDelay, as_control, closed_loop
from spacar.simulation.co_simulation import CoSimulation
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
        (type("Now", (Function,), {"period": 0.0})("c", lambda t, u: u, 1, 1), True, "c is sampled"),
        (TransportDelay("late", 1.0), True, "late remembers its input"),
        (Sampled("c", lambda t, x, u: (x, u), 0.1, 1, 1), False, r"pip install 'spacar\[control\]'"),
    ],
    ids=["sampled", "period zero", "delay", "without python-control"],
)
def test_what_is_no_system_of_states(monkeypatch, block, there, said):
    if there:
        pytest.importorskip("control")
    else:
        monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(UsageError, match=said):
        as_control(block)


# Co-simulation: the mechanism from one communication point to the next, and as a unit that FMPy opens.
MOMENTS = np.array([5.0, 196.98, 82.276])


def law(t, y):
    return MOMENTS - 300.0 * y[:3] - 30.0 * y[3:6]


def test_steps_equal_a_sampled_law_in_a_diagram():
    """A held input between communication points is what a sampled controller gives."""
    h, n = 0.01, 8
    times = np.arange(n + 1) * h
    ours = closed_loop(Spasim(DATA / "robotsim.dat"), law, times, feedback="1-6", period=h, rtol=1e-10, atol=1e-12)
    unit = CoSimulation(Spasim(DATA / "robotsim.dat"), rtol=1e-10, atol=1e-12)
    found = []
    for _ in range(n):
        unit.u[:] = law(unit.t, unit.outputs())
        found.append(unit.outputs())
        unit.advance(h)
    np.testing.assert_allclose(np.array(found)[:, :6], ours["plant:1-6"][:n], rtol=0, atol=1e-9)
    with pytest.raises(UsageError, match="communication step must be positive"):
        unit.advance(0.0)


def test_names():
    assert identifier("OUTX node 8 x") == "OUTX_node_8_x"
    assert identifier("3d arm") == "_3d_arm"
    assert variables(["a b", "a.b", "c"]) == ["a_b_1", "a_b_2", "c"]


@pytest.fixture
def fmpy():
    pytest.importorskip("pythonfmu", reason="pythonfmu is not installed")
    return pytest.importorskip("fmpy", reason="FMPy is not installed")


def test_a_unit_in_fmpy(fmpy, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "robotsim.dat", tmp_path)
    assert main(["fmu", "robotsim", "--rtol", "1e-9", "--atol", "1e-11"]) == 0
    about = fmpy.read_model_description("robotsim.fmu")
    assert about.fmiVersion == "2.0"
    assert about.modelName == "robotsim"
    inputs = [v.name for v in about.modelVariables if v.causality == "input"]
    assert inputs[0] == "INPUTS_element_1_HINGE_e1_relative_rotation"
    times = np.linspace(0.0, 0.05, 6)
    signals = np.array([(t, *MOMENTS) for t in (0.0, 1.0)], dtype=[(n, float) for n in ("time", *inputs)])
    found = fmpy.simulate_fmu(
        "robotsim.fmu", stop_time=0.05, step_size=0.01, output_interval=0.01, input=signals, output=["OUTX_node_8_x"]
    )
    ours = closed_loop(Spasim("robotsim.dat"), lambda t, y: MOMENTS, times, feedback="1", rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(found["OUTX_node_8_x"], ours["plant:10"][:, 0], rtol=0, atol=1e-9)


USER = """PLBEAM 1 1 2 3 4   X 3 1. 0.   FIX 1   FIX 2   DYNE 1 2 3   END HALT
EM 1 1.   ESTIFF 1 1e5 10.   USERSIG push   TIMESTEP 0.1 2   END HALT
INPUTF 1 3 2   OUTX 1 3 2   OUTXP 2 4 1   END END
"""


def test_a_unit_with_a_user_function(fmpy, tmp_path, monkeypatch):
    """The function pushes as the input does: half of the force each gives the motion of the whole force."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.dat").write_text(USER)
    found = []
    for force, given in ((0.5, 0.5), (0.0, 1.0)):
        (tmp_path / "push.py").write_text(f"def push(t, *rest):\n    return t, [], [[3, 2, {force}]]\n")
        assert main(["fmu", "a", "-o", f"{tmp_path}/b{force:.0f}{given:.0f}.fmu"]) == 0
        name = f"b{force:.0f}{given:.0f}.fmu"
        about = fmpy.read_model_description(name)
        (tmp_path / "push.py").unlink()  # the unit has its own
        units = {v.name: v.unit for v in about.modelVariables}
        inputs = [v.name for v in about.modelVariables if v.causality == "input"]
        outputs = [v.name for v in about.modelVariables if v.causality == "output"]
        assert [units[name] for name in inputs + outputs] == ["N", "m", "rad/s"]
        signals = np.array([(t, given) for t in (0.0, 1.0)], dtype=[("time", float), (inputs[0], float)])
        options = {"stop_time": 0.05, "step_size": 0.01, "output_interval": 0.01}
        got = fmpy.simulate_fmu(name, input=signals, output=outputs, **options)
        found.append(got[outputs[0]])
    assert found[0][-1] > 1e-3
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-7)


def test_a_unit_that_fails_stops_its_simulation(fmpy, tmp_path, monkeypatch):
    """With the error of FMI, not with a shorter result; its description is valid."""
    from fmpy.validation import validate_fmu

    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.dat").write_text(USER)
    (tmp_path / "push.py").write_text("def push(t, *rest):\n    return (t, [], []) if t < 0.02 else exit(3)\n")
    assert main(["fmu", "a"]) == 0
    assert validate_fmu("a.fmu") == []
    with pytest.raises(fmpy.fmi1.FMICallException, match="fmi2DoStep failed"):
        fmpy.simulate_fmu("a.fmu", stop_time=0.05, step_size=0.01)


def test_without_pythonfmu(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pythonfmu", None)
    with pytest.raises(UsageError, match=r"pythonfmu is not installed: pip install 'spacar\[fmu\]'"):
        export_fmu(DATA / "robotsim.dat", tmp_path / "a.fmu")
