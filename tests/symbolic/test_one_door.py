"""Symbolic results in `plot`, `draw`, `report`, and compiled speed from Python in one call."""

import csv
import hashlib
import io

import numpy as np
import pytest
from spacar_drawing.picture_source import open_source
from spacar_drawing.scene import positions, rotations
from spacar_formats.locate import open_result

from spacar.errors import UsageError
from spacar.symbolic.compiled_program import compiler
from tests.command_line import call as spacar

from .systems import pendulum

MODEL = """
[system]
gravity = [0, "-g", 0]
[parameters]
m = 2.0
L = 0.5
g = 9.81
[coordinates]
q = { speed = "s", start = 0.3 }
[[frame]]
name = "B"
parent = "N"
axis = 3
angle = "q - pi/2"
[[point]]
name = "P"
base = "O"
offset = ["L", 0, 0]
in = "B"
[[body]]
name = "bob"
at = "P"
mass = "m"
[outputs]
"T + V" = "m*(L*s)**2/2 - m*g*L*cos(q)"
"P.y" = "P.y"
"""


@pytest.fixture
def result(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pendulum.toml").write_text(MODEL)
    spacar.done("symbolic", "simulate", "pendulum.toml", "--time", "0.5", "--steps", "20")
    return tmp_path


def table(*arguments: str) -> np.ndarray:
    out = spacar.done("plot", "pendulum", *arguments, "--csv", "-").out
    return np.array(list(csv.reader(io.StringIO(out)))[1:], float)


def test_states_and_outputs_are_plotted_by_name_and_in_expressions(result):
    t, q, y, difference, energy = table("q", "P.y", "P.y + 0.5*cos(q)", "T + V").T
    assert np.allclose(t, np.linspace(0, 0.5, 21), atol=1e-15)
    assert np.max(abs(y + 0.5 * np.cos(q))) < 1e-15
    assert np.max(abs(difference)) < 1e-15
    assert np.ptp(energy) < 1e-6 * abs(energy[0])  # rtol 1e-8 of the run over half a period
    assert q[0] == 0.3
    assert q[-1] < 0


def test_a_picture_is_written_without_options_and_one_step_is_enough(result):
    assert spacar("plot", "pendulum", "q", "s")[0] == 0
    assert (result / "pendulum_plot.png").stat().st_size > 1000
    spacar("symbolic", "simulate", "pendulum.toml", "--time", "0.5", "--steps", "1")
    assert table("q").shape == (2, 2)


def test_a_result_knows_the_model_it_came_from(result):
    file = open_result("pendulum", "sbd")
    assert file.header["SOURCE"] == ["pendulum.toml"]
    assert file.header["SHA256"] == [hashlib.sha256((result / "pendulum.toml").read_bytes()).hexdigest()]
    file.close()
    (result / "pendulum.toml").write_text(MODEL + "# changed\n")
    for command in ("draw", "report"):
        assert "pendulum.toml, which has changed since" in spacar.refused(command, "pendulum")
    assert spacar("plot", "pendulum", "q", "--stale-ok")[0] == 0


def test_points_and_lines_are_drawn_where_they_are(result):
    source = open_source("pendulum")
    (link,) = source.scene.elements
    q, end = source.named["q"], positions(source.scene, source.x(21))[link.q - 1]
    assert end == pytest.approx([0.5 * np.sin(q[-1]), -0.5 * np.cos(q[-1]), 0.0], abs=1e-15)
    turn = rotations(source.scene, source.x(21))[link.q_turn - 1]
    assert turn[:2, 0] == pytest.approx(end[:2] / 0.5, abs=1e-14)
    assert source.scene.fixed_directions(link.p) == (0, 1)
    assert spacar("draw", "pendulum", "--strobe", "3", "-o", "p.png")[0] == 0
    assert (result / "p.png").stat().st_size > 1000


def test_a_report_has_the_named_quantities(result):
    assert spacar("report", "pendulum")[0] == 0
    page = (result / "pendulum.html").read_text()
    for text in ("spacar symbolic simulate", "Coordinates", "T + V", "Plots", "pendulum.toml"):
        assert text in page
    assert "Degrees of freedom" not in page


def test_flexible_and_spatial_models_are_drawn(tmp_path, monkeypatch):
    """The tip of a drawn beam is the section that the program computes."""
    monkeypatch.chdir(tmp_path)
    text = MODEL.replace('axis = 3\nangle = "q - pi/2"', 'axis = "32"\nangle = ["q", 0.3]')
    beam = '[[beam]]\nname = "rod"\nframe = "B"\nroot = "P"\nlength = "L"\nmass = "m"\nEI = 0.01\nbends = [2, 3]\n'
    outputs = "".join(f'"t{a}" = "rod.tip.{a}"\n' for a in "xyz")
    text = text.replace("[outputs]", f"{beam}field = 1\n[outputs]\n{outputs}")
    (tmp_path / "rod.toml").write_text(text)
    spacar.done("symbolic", "simulate", "rod.toml", "--time", "0.02", "--steps", "2", "--rtol", "1e-5")
    source = open_source("rod")
    tip = [source.named[f"t{a}"][-1] for a in "xyz"]
    last = source.scene.elements[-1]
    assert abs(tip[2]) > 0.01
    assert positions(source.scene, source.x(3))[last.q - 1] == pytest.approx(tip, abs=1e-13)
    assert spacar("draw", "rod", "-o", "rod.png")[0] == 0


def test_what_has_no_points_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.toml").write_text('[coordinates]\nq = { speed = "s" }\n')
    (tmp_path / "m.py").write_text(
        "from spacar.symbolic import MultibodySystem\nsystem = MultibodySystem()\nq, s = system.coordinate('q', 's')\n"
        "P = system.point('P', system.O, 0 * system.N[1], velocity=s * system.N[1])\nsystem.particle('p', P, 1)\n"
    )
    assert spacar("symbolic", "simulate", "m.py", "--steps", "2")[0] == 0
    assert "has no points that could be drawn: use spacar plot" in spacar.refused("draw", "m")
    assert spacar("plot", "m", "q")[0] == 0


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("cc", ["", "no-such-compiler"])
def test_a_compiler_that_cannot_be_used_is_told_before_anything_is_written(result, monkeypatch, cc):
    monkeypatch.setenv("CC", cc)
    before = (result / "pendulum.sbd").read_bytes()
    err = spacar.refused("symbolic", "simulate", "pendulum.toml", "--compiled")
    assert ("is empty" if not cc else "'no-such-compiler', was not found") in err
    assert (result / "pendulum.sbd").read_bytes() == before


@pytest.mark.parametrize("text", ["bogus", "x[1,2]", "q[1,1]"])
def test_an_unknown_name_is_answered_with_the_known_ones(result, text):
    assert "q, s, T + V, P.y" in spacar.refused("plot", "pendulum", text)


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_compile_is_one_call_and_gives_the_same_numbers():
    S, B, P = pendulum()
    S.torque(B, S.input("M") * S.N[3])
    program = S.derive("recursive").program({"height": P.position & S.N[2]})
    values, feeds = {"g": 9.81, "m": 2.0, "L": 0.5}, {"M": lambda t, y: 0.3 * t}
    f, slow = program.compile(values, feeds), program.function(values, feeds=feeds)
    y = [0.4, -1.1]
    assert np.allclose(f(0.7, y), slow(0.7, y), rtol=1e-14)
    assert np.allclose(f(0.7, y), [-1.1, -9.81 / 0.5 * np.cos(0.4) + 0.21 / 0.5], rtol=1e-14)
    assert np.allclose(f.jac(0.7, y), slow.jac(0.7, y), rtol=1e-14)
    run = program.simulate(values, {"q": 0.4}, t_end=0.2, steps=4, feeds=feeds, function=f)
    again = program.simulate(values, {"q": 0.4}, t_end=0.2, steps=4, feeds=feeds)
    assert np.allclose(run["q"], again["q"], atol=1e-9)
    with pytest.raises(UsageError, match="parameter L has no value"):
        program.compile({"g": 1.0, "m": 1.0})


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_many_states_in_one_call():
    S, B, _ = pendulum()
    S.torque(B, (S.input("M") + S.input("D", "-d*s")) * S.N[3])
    values, feeds = {"g": 9.81, "m": 2.0, "L": 0.5, "d": 0.1}, {"M": lambda t, y: 0.3 * t + y[0]}
    f = S.derive("recursive").program().compile(values, feeds)
    states = np.random.default_rng(1).uniform(-2, 2, (40, 2))
    times = np.linspace(0, 1, 40)
    assert np.array_equal(f.many(times, states), [f(t, y) for t, y in zip(times, states, strict=True)])
    assert np.array_equal(f.many(0.5, states[:3]), [f(0.5, y) for y in states[:3]])
    weightless = S.derive("recursive").program().compile(values | {"m": 0.0}, feeds)
    with pytest.raises(ArithmeticError, match="at state 1"):
        weightless.many(times, states)


def test_a_place_without_a_number_is_no_error(tmp_path, monkeypatch):
    """A point that no equation needs, at a parameter that has no value: the motion is computed, nothing is drawn."""
    monkeypatch.chdir(tmp_path)
    point = '[[point]]\nname = "Q"\nbase = "P"\noffset = ["a", 0, 0]\nin = "B"\n'
    text = MODEL.replace("[outputs]", f"{point}[outputs]").replace("g = 9.81", 'g = 9.81\na = ""')
    (tmp_path / "m.toml").write_text(text)
    spacar.done("symbolic", "simulate", "m.toml", "--steps", "2", "--time", "0.1")
    assert spacar("draw", "m")[0] == 2
    spacar.done("symbolic", "simulate", "m.toml", "--steps", "2", "--time", "0.1", "--set", "a=0.2")
    assert spacar("draw", "m", "-o", "m.png")[0] == 0
