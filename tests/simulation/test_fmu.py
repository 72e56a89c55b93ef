"""Co-simulation: the mechanism from one communication point to the next, and as a unit that FMPy opens."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from spacar_cli.main import main
from spacar_formats.fmu import export_fmu, identifier, variables

from spacar.errors import UsageError
from spacar.simulation import Spasim, closed_loop
from spacar.simulation.co_simulation import CoSimulation

DATA = Path(__file__).parents[2] / "data"
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


def test_a_unit_in_fmpy(tmp_path, monkeypatch):
    pytest.importorskip("pythonfmu", reason="pythonfmu is not installed")
    fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
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
    ours = closed_loop(
        Spasim("robotsim.dat"), lambda t, y: MOMENTS, times, feedback="1", rtol=1e-9, atol=1e-11
    )
    np.testing.assert_allclose(found["OUTX_node_8_x"], ours["plant:10"][:, 0], rtol=0, atol=1e-9)


def test_without_pythonfmu(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pythonfmu", None)
    with pytest.raises(UsageError, match=r"pythonfmu is not installed: pip install 'spacar\[fmu\]'"):
        export_fmu(DATA / "robotsim.dat", tmp_path / "a.fmu")
