"""`spacar sim` leaves the motion of its mechanism as mode 1 does: drawn, plotted, and the same numbers."""

import shutil

import numpy as np
import pytest
from spacar_cli.main import main
from spacar_formats.getfrsbf import getfrsbf
from spacar_formats.signal_tables import write_motions

import spacar
from spacar.errors import AnalysisError
from spacar.simulation import Constant, Diagram, Spasim, simulate
from spacar.simulation.co_simulation import CoSimulation
from tests.examples import DATA

SIM = """
[simulation]
time = 0.05
step = 0.01
rtol = 1e-9
atol = 1e-11
[robot]
block = spasim
model = robotsim
[wires]
"""


def test_motion_without_control_is_that_of_mode_1(tmp_path, monkeypatch):
    """Without wires the inputs are zero: the arm falls as in forward dynamics."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "robotsim.dat", tmp_path)
    (tmp_path / "fall.sim").write_text(SIM)
    assert main(["sim", "fall", "-q"]) == 0
    free = spacar.run(1, "robotsim.dat", duration=0.05, n_steps=5, rtol=1e-10, atol=1e-12)
    x, xdd = getfrsbf("fall_sim.sbd", "x"), getfrsbf("fall_sim.sbd", "xdd")
    np.testing.assert_allclose(x, [f.x for f in free.frames], rtol=0, atol=1e-7)
    scale = max(np.abs(f.xdd).max() for f in free.frames)
    np.testing.assert_allclose(xdd, [f.xdd for f in free.frames], rtol=0, atol=1e-6 * scale)
    assert main(["draw", "fall_sim", "-o", "fall.png", "--strobe", "3"]) == 0
    assert main(["plot", "fall_sim", "x[8,1]"]) == 0


def test_the_results_of_the_model_stay(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "robotsim.dat", tmp_path)
    (tmp_path / "robotsim.sbd").write_bytes(b"of mode 1")
    (tmp_path / "fall.sim").write_text(SIM)
    assert main(["sim", "fall", "-q", "-o", "robotsim.npz"]) == 0
    assert (tmp_path / "robotsim.sbd").read_bytes() == b"of mode 1"
    assert (tmp_path / "robotsim_sim.sbd").is_file()


def test_every_mechanism_has_its_file(tmp_path):
    diagram = Diagram().add(Spasim(DATA / "robotsim.dat", "left"), Spasim(DATA / "robotsim.dat", "right"))
    response = simulate(diagram, [0.0, 0.001])
    assert [p.name for p in write_motions(response, tmp_path / "two")] == ["two_left.sbd", "two_right.sbd"]


BENT = """
PLBEAM 1 1 2 3 4
X 3 1. 0.
FIX 1
FIX 2
DYNE 1 2 3
END HALT
XM 3 1.
XM 4 0.01
ESTIFF 1 1e4 1.
EDAMP 1 0. 0.5
END HALT
INPUTF 1 3 2
OUTX 1 3 2
END END
"""
ROLLING = """
WHEEL 1 1 2 3 0 1 0
X 1 0. 0. 0.3
X 3 0. 0. 0.
FIX 2
FIX 1 2
DYNX 1 1
RLSE 1 5 6
END HALT
XM 1 2.
GRAVITY 0. 0. -9.81
END HALT
INPUTF 1 1 3
OUTX 1 1 1
END END
"""


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize(("text", "force", "words"), [
    (BENT, -20.0, "element 1 .PLBEAM. at t = 1: end p is rotated by 148.0 degrees"),
    (ROLLING, 25.0, "element 1 .WHEEL. at t = 0: the wheel leaves the ground, its normal force would be a pull of 5"),
])  # fmt: skip
def test_limits_of_elements_are_those_of_mode_1(text, force, words, compiled):
    plant = Spasim(spacar.parse_deck(text, "limits"), "plant")
    plant.choose(compiled)
    diagram = Diagram().add(plant, Constant("force", force)).connect("force", "plant")
    with pytest.raises(AnalysisError, match=words):
        simulate(diagram, np.arange(11.0))


@pytest.mark.parametrize("compiled", [True, False])
def test_a_mechanism_starts_again_where_it_started(compiled):
    """Wherever it has been: here the end of the beam has gone over to the other side of its root."""
    plant = Spasim(spacar.parse_deck(BENT, "start"), "plant")
    plant.choose(compiled)
    force = np.array([-20.0])
    rates = plant.derivative(0.0, plant.start(), force).copy()
    diagram = Diagram().add(plant, Constant("force", force)).connect("force", "plant")
    with pytest.raises(AnalysisError):
        simulate(diagram, np.arange(11.0))
    assert np.array_equal(plant.derivative(0.0, plant.start(), force), rates)


@pytest.mark.parametrize("compiled", [True, False])
def test_limits_end_a_step_of_co_simulation(compiled):
    plant = Spasim(spacar.parse_deck(ROLLING, "limits"), "plant")
    plant.choose(compiled)
    master = CoSimulation(plant)
    master.advance(0.1)
    master.u[0] = 25.0
    with pytest.raises(AnalysisError, match=r"element 1 .WHEEL. at t = 0.2: the wheel leaves the ground"):
        master.advance(0.1)
    assert master.t == 0.1


@pytest.mark.parametrize("compiled", [True, False])
def test_what_limits_warn_of_is_noted(compiled):
    plant = Spasim(spacar.parse_deck(ROLLING.replace("GRAVITY 0. 0. -9.81", ""), "weightless"), "plant")
    plant.choose(compiled)
    diagram = Diagram().add(plant, Constant("force", 1.0)).connect("force", "plant")
    for _ in range(2):
        notes = simulate(diagram, [0.0, 0.5, 1.0]).notes
        assert [note[:54] for note in notes] == ["plant: element 1 (WHEEL) at t = 0: the wheel leaves th"]
