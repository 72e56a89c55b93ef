"""Scopes: drawn when asked, stored with the result, plotted by name, beside the mechanism in pictures."""

import shutil

import numpy as np
import pytest
from spacar_drawing.curves import curves_of, evaluate
from spacar_drawing.picture_source import open_source
from spacar_formats.getfrsbf import getfrsbf

from tests.command_line import call as run
from tests.examples import DATA

HELD = """
[simulation]
time = 0.02
step = 0.005
[robot]
block = spasim
model = robotsim
[weight]
block = constant
value = 0 196.98 82.276
[fast]
block = pulses
every = 0.01
high = 5
[angles]
block = scope
size = 2
title = angles
labels = shoulder, elbow
unit = rad
[both]
block = scope
[wires]
weight -> robot
fast -> robot:1
robot:2-3 -> angles
robot:1 -> both
fast -> both * -0.5
"""
ALONE = """
[simulation]
time = 1
step = 0.01
[command]
block = step
time = 0.25
[controller]
block = pid
kp = 4
ki = 6
kd = 0.2
filter = 50
lower = -2
upper = 2
anti_windup = clamping
[motor]
block = transfer-function
numerator = 1
denominator = 0.1 1 0
[sensor]
block = quantizer
interval = 0.02
[wires]
command -> controller
sensor -> controller * -1
controller -> motor
motor -> sensor
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("scopes")
    shutil.copy(DATA / "robotsim.dat", place)
    (place / "held.sim").write_text(HELD)
    (place / "alone.sim").write_text(ALONE)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        assert run("sim", "held", "-q", "-o", "held.png")[0] == 0
        assert run("sim", "alone", "-q")[0] == 0
    return place


@pytest.fixture
def here(folder, monkeypatch):
    monkeypatch.chdir(folder)
    return folder


def test_scopes_are_stored(here):
    found = np.load("held_sim.npz")
    np.testing.assert_array_equal(found["angles"], found["robot"][:, 1:3])
    np.testing.assert_allclose(found["both"][:, 0], found["robot"][:, 0] - 0.5 * found["fast"][:, 0], atol=1e-15)
    table = open_source("held_sim").signals
    assert [p.title for p in table.panels] == ["angles", "both"]
    assert table.panels[0].labels == ("shoulder", "elbow")
    assert table.panels[1].labels == ("robot OUTE element 1 (HINGE) e1 relative rotation - 0.5 fast y1",)
    np.testing.assert_array_equal(getfrsbf("held_sim.sbd", "signal")[:, :15], found["robot"])
    assert (here / "held.png").stat().st_size > 10_000


def test_signals_are_plotted_by_name(here):
    source = open_source("held_sim")
    curves = curves_of(source, "robot:10-12")
    assert [c.text for c in curves] == ["OUTX node 8 x", "OUTX node 8 y", "OUTX node 8 z"]
    assert [c.group for c in curves_of(source, "angles")] == ["angles (rad)"] * 2
    same = evaluate(source, "robot[10] - x[8,1]").values
    np.testing.assert_allclose(same, 0.0, atol=1e-15)
    assert run("plot", "held_sim", "angles", "robot:4-6", "x[8,1]", "-o", "p.png")[0] == 0
    assert run("plot", "alone_sim", "motor", "command", "-x", "t", "--csv", "-")[1].splitlines()[0] == "t,y1,y1"
    for text, why in (
        ("robt:1", "there is no block robt with signals; there are robot, weight, fast, angles, both"),
        ("robot:16", "robot has the signals 1 to 15"),
        ("robot:a", "cannot read"),
    ):
        assert why in run.refused("plot", "held_sim", text)


def test_a_diagram_without_mechanism_has_its_signals_too(here):
    assert run("plot", "alone_sim", "controller:1", "motor[1] - command[1]", "-o", "alone.png")[0] == 0
    assert "use spacar plot" in run.refused("draw", "alone_sim")
    assert "BLOCK:NUMBER of command, controller, motor, sensor" in run.refused("plot", "alone_sim", "x[1,1]")


def test_scopes_stand_beside_the_mechanism(here):
    from PIL import Image

    for name, option in (("with", "--scopes"), ("without", "--no-scopes")):
        files = ("-o", f"{name}.png", "-o", f"{name}.gif")
        assert run("draw", "held_sim", option, *files, "--frames", 2, "--dpi", 40)[0] == 0
    for ending in ("png", "gif"):
        with Image.open(f"with.{ending}") as wide, Image.open(f"without.{ending}") as narrow:
            assert wide.size[0] > 1.4 * narrow.size[0]
            assert wide.size[1] == narrow.size[1]
            frames = getattr(wide, "n_frames", 1)
    assert frames == 2
    with Image.open("with.gif") as film:  # the line of the time moves
        film.seek(0)
        first = np.array(film.convert("RGB"))[:, -120:]
        film.seek(1)
        assert np.any(np.array(film.convert("RGB"))[:, -120:] != first)


def test_no_window_without_a_display(here, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "MPLBACKEND"):
        monkeypatch.delenv(name, raising=False)
    assert "no window can be opened here" in run.refused("sim", "alone", "--show", "-o", "never.npz")
    assert not (here / "never.npz").exists()  # told before the run


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("kd = 0.2\nfilter = 50", "kd = 0.2", "alone.sim:8: [controller]: a derivative (kd) needs `filter`"),
        ("anti_windup = clamping", "anti_windup = clamp", "[controller]: anti_windup = clamp must be one of back-calc"),
        ("lower = -2", "lower = 3", "[controller]: every lower limit must be below the upper one"),
        ("interval = 0.02", "interval = 0", "[sensor]: the interval of a quantizer must be positive"),
        ("numerator = 1\n", "numerator = 1 0 0 0\n", "no lower degree than the numerator, found [1.0, 0.0, 0.0, 0.0]"),
        ("interval = 0.02", "interval = 0.02\nsize = 1.5", "size = 1.5 must be a positive whole number"),
        ("kp = 4", "kp = 4 5", "[controller]: gains are one number or 1"),
        ("time = 0.25", "time = 0.25\ntime = 3", "alone.sim:8: alone.sim is no model of a simulation: time of ["),
        ("[sensor]", "[motor]", "the section [motor] stands in line 17 already"),
        ("kp = 4", "kp = 4\nperiod = -1", "alone.sim:11: [controller]: period = -1 must be positive"),
    ],
)
def test_wrong_blocks(here, old, new, why):
    assert old in ALONE
    (here / "wrong.sim").write_text(ALONE.replace(old, new, 1))
    assert why.replace("alone.sim", "wrong.sim") in run.refused("sim", "wrong")


def test_every_example_simulation_is_listed_and_copied_with_its_models(tmp_path):
    listed = run("examples")[1]
    for name in ("robotopen", "robotflexltv", "robotsim.sim"):
        assert name in listed
    assert run("examples", "robotflexltv", "--output-dir", tmp_path)[0] == 0
    names = {p.name for p in tmp_path.iterdir()}
    assert names == {"robotflexltv.sim", "robotflexinv.dat", "robotflexinvlin.dat"}


def test_the_page_of_blocks_is_made_from_the_table():
    from spacar_formats.sim_blocks import page

    assert (DATA.parent / "docs" / "reference" / "blocks.md").read_text(encoding="utf-8") == page()
