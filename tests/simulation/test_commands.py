"""spacar 2, 3, sim, ltv, mrltv, spacntrl on real files, in process."""

import shutil

import numpy as np
import pytest
from spacar_formats.ltvfile import read_ltv

from spacar.compiled import compiled_evaluator
from spacar.dynamics import array_evaluator
from tests.command_line import call
from tests.examples import DATA


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The manipulator with the results of modes 2 and 3."""
    place = tmp_path_factory.mktemp("robot")
    for name in ("robotinv.dat", "robotinvlin.dat", "robotsim.dat", "robotsim.sim"):
        shutil.copy(DATA / name, place)
    call.done(2, place / "robotinv")
    call.done(3, place / "robotinvlin")
    return place


@pytest.fixture
def folder(made, monkeypatch):
    monkeypatch.chdir(made)
    return made


def test_closed_loop_from_the_model_file(folder):
    """The first third of the motion; `test_robot.py` follows the whole of it."""
    text = (folder / "robotsim.sim").read_text()
    assert "time = 1.5" in text
    text = text.replace("time = 1.5", "time = 0.5")
    (folder / "short.sim").write_text(f"\ufeff{text}", "utf-8")  # the byte order mark of editors on Windows
    status, out, err = call("sim", "short")
    assert (status, err) == (0, "")
    assert "51 times" in out
    found = np.load(folder / "short_sim.npz")
    reference = found["y0"][:, 9:12]
    assert np.linalg.norm(found["robot"][:, 9:12] - reference, axis=1).max() < 1e-3
    assert "block robot (Spasim): 3 inputs, 15 outputs, 6 states" in (folder / "short_sim.log").read_text()


@pytest.mark.parametrize("compiled", [True, False])
def test_inertia_that_may_be_rounding_is_said_and_logged(folder, monkeypatch, compiled):
    monkeypatch.setattr(array_evaluator, "is_doubtful", lambda *found: True)
    monkeypatch.setattr(compiled_evaluator, "is_checked", lambda *found: False)  # C leaves it to the general path
    monkeypatch.setattr(array_evaluator, "require_regular_mass", lambda *found: "little inertia")
    text = (folder / "robotsim.sim").read_text()
    (folder / "doubt.sim").write_text(text.replace("time = 1.5", "time = 0.01"))
    status, _, err = call("sim", "doubt", *[] if compiled else ["--general"])
    assert (status, err) == (0, "warning: robot: little inertia\n")
    assert "note: robot: little inertia" in (folder / "doubt_sim.log").read_text()


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("block = pd", "block = pdd", r"wrong.sim:24: [pd]: block = pdd; the blocks are spasim"),
        ("omega = 28", "omga = 28", "wrong.sim:26: [pd]: unknown key 'omga'; the keys are size, omega, damping"),
        ("omega = 28\n", "", "[pd]: 'omega' is missing"),
        ("omega = 28", "omega = fast", "omega = fast is no number"),
        ("omega = 28", "omega = nan", "omega = nan is no number"),
        (
            "block = pd\nsize = 3\nomega = 28\ndamping = 0.85",
            "block = rate-limiter\nrising = 1\nbandwidth = 9\noffset = 1",
            "offset = 1 needs 'period'",
        ),
        ("u0 -> robot\n", "u0 -> robbot\n", "[wires]: robbot: there is no block robbot"),
        ("u0 -> robot\n", "u0 robot\n", "is no wire"),
        ("pd -> m0", "pd:1 -> m0", "1 outputs cannot be connected to 3 inputs"),
        ("file = robotinv.ltv\nhold = yes\n\n[y0]", "file = nothing.ltv\n\n[y0]", "nothing.ltv not found"),
        ("time = 1.5", "time = -1", "must be positive"),
        ("[wires]", "[wire]", "section [wires] is missing"),
        ("rtol = 1e-6", "method = Euler", "method 'Euler' does not exist"),
        ("model = robotsim.dat", "model = robotsim2.dat", "robotsim2.dat"),
    ],
)
def test_wrong_model_files(folder, old, new, why):
    text = (folder / "robotsim.sim").read_text()
    assert old in text
    (folder / "wrong.sim").write_text(text.replace(old, new))
    assert why in call.refused("sim", "wrong")


def test_python_controller_in_a_model_file(folder):
    (folder / "hold.py").write_text(
        "def moments(t, y):\n    return [0.0, 196.98, 82.276]\n\n\ndef bad(t, y):\n    return [1.0]\n"
    )
    text = """
[simulation]
time = 0.1
step = 0.02
[robot]
block = spasim
model = robotsim
[law]
block = python
function = hold.py:moments
inputs = 6
outputs = 3
[wires]
robot:1-6 -> law
law -> robot
"""
    (folder / "hold.sim").write_text(text)
    call.done("sim", "hold.sim", "-o", "out.csv")
    table = np.genfromtxt(folder / "out.csv", delimiter=",", names=True)
    assert table["robot_8"] == pytest.approx(0.0, abs=1e-8)
    (folder / "bad.sim").write_text(text.replace(":moments", ":bad"))
    assert "the output of law at t = 0 has the shape (1,); expected (3,)" in call.refused("sim", "bad", status=1)


@pytest.mark.parametrize("heading", ["", "\ufeff", "t (s),M (N, m) µ\n"])
def test_a_table_keeps_its_first_line_of_numbers(folder, heading):
    """It was left out as a heading. Times are whole steps, and the end."""
    (folder / "ramp.csv").write_text(heading + "0,1\n2,5\n", "utf-8")
    (folder / "ramp.sim").write_text("""
[simulation]
time = 1
step = 0.4
[ramp]
block = table
file = ramp.csv
[half]
block = gain
gain = 0.5
[wires]
ramp -> half
""")
    call.done("sim", "ramp.sim", "-o", "ramp.npz")
    found = np.load(folder / "ramp.npz")
    assert found["t"] == pytest.approx([0.0, 0.4, 0.8, 1.0], abs=1e-15)
    assert found["half"].ravel() == pytest.approx(0.5 + found["t"], abs=1e-15)


def test_gain_reduction_and_response(folder):
    call.done("spacntrl", "robotinvlin", "--omega", 28, "--damping", 0.85)
    before, after = read_ltv(folder / "robotinvlin")[0], read_ltv(folder / "robotinvlinkp")[0]
    assert after.k0b - before.k0b == pytest.approx(28.0**2 * before.m0, abs=1e-8)
    assert np.array_equal(after.B, before.B)
    out = call.done("mrltv", "robotinvlinkp", 2).out
    assert "kept: modes 1 (" in out
    assert "quasi-static: modes 3 (" in out
    assert read_ltv(folder / "robotinvlinkpmr")[0].A.shape == (141, 4, 4)
    call.done("ltv", "robotinvlinkpmr", "-o", "r.npz")
    assert np.load(folder / "r.npz")["z"].shape == (141, 4)


def test_gain_from_numbers_and_from_a_function(folder):
    (folder / "gains.py").write_text("calls = []\ndef kp(step):\n    return [[step, 0, 0], [0, 2, 0], [0, 0, 3]]\n")
    call.done("spacntrl", "robotinvlin", "--kp", "gains.py:kp", "-o", "f.ltv")
    call.done("spacntrl", "robotinvlin", "--kp", "7,2,3", "-o", "n.ltv")
    f, n, before = (read_ltv(folder / name)[0].k0b for name in ("f.ltv", "n.ltv", "robotinvlin.ltv"))
    assert (f - before)[:, 0, 0] == pytest.approx(np.arange(1, 142), abs=1e-9)
    assert f[6] == pytest.approx(n[6], abs=1e-9)
    for words, why in (
        (("--kp", "1,2"), "2 gains for 3 nominal inputs"),
        (("--kp", "x"), "neither a list of numbers nor FILE.csv nor FILE.py:NAME"),
        (("--kp", "gains.py:none"), "does not define a function none"),
        ((), "give either --kp or --omega"),
    ):
        assert why in call.refused("spacntrl", "robotinvlin", *words)


@pytest.mark.parametrize("raised", ["SystemExit(3)", "GeneratorExit", "IndexError('a')"])
def test_a_function_of_gains_that_fails(folder, raised):
    (folder / "gains.py").write_text(f"def kp(step):\n    if step > 2: raise {raised}\n    return 3 * [3 * [0.0]]\n")
    err = call.refused("spacntrl", "robotinvlin", "--kp", "gains.py:kp", status=1)
    assert f"error: gains.py:kp failed at step 3: {raised.split('(')[0]}" in err


# -- mode 3 finds mode 2 --------------------------------------------------------------------------------------------
def test_missing_stale_and_named_setpoints(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for name in ("robotinvlin.dat", "robotinv.dat"):
        shutil.copy(DATA / name, tmp_path)
    err = call.refused(3, "robotinvlin")
    assert "no mode 2 result to linearize along for robotinvlin.dat" in err
    assert "robotinvli.sbd" in err
    call.done(2, "robotinv")
    text = (tmp_path / "robotinv.dat").read_text()
    (tmp_path / "robotinv.dat").write_text(text.replace("XM 8 30.", "XM 8 31."))
    err = call.refused(3, "robotinvlin")
    assert "the mode 2 result is stale" in err
    assert "--setpoints robotinv" in err
    call.done(3, "robotinvlin", "--setpoints", "robotinv")
    assert "has changed since" in (tmp_path / "robotinvlin.log").read_text()


def test_other_mechanism_is_refused(made, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for name in ("robotinv.sbd", "robotinv.ltv", "robotinv.dat", "robotinvlin.dat"):
        shutil.copy(made / name, tmp_path)
    text = (tmp_path / "robotinvlin.dat").read_text()
    (tmp_path / "robotinvlin.dat").write_text(text.replace("HINGE 3 6 7", "HINGE 3 7 6"))
    err = call.refused(3, "robotinvlin")
    assert "mechanism" in err
    assert "element 3 is HINGE with nodes 7 6 here, HINGE with nodes 6 7 there" in err
