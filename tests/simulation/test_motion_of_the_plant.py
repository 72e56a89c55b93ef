"""`spacar sim` leaves the motion of its mechanism as mode 1 does: drawn, plotted, and the same numbers."""

import shutil

import numpy as np
from spacar_cli.main import main
from spacar_formats.getfrsbf import getfrsbf
from spacar_formats.signal_tables import write_motions

import spacar
from spacar.simulation import Diagram, Spasim, simulate
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
