"""Symbolic results in `plot`, `draw`, `report`, and compiled speed from Python in one call."""

from __future__ import annotations

import csv
import io
from contextlib import redirect_stderr, redirect_stdout

import numpy as np
import pytest

pytest.importorskip("sympy")

from spacar_cli.main import main

from spacar.errors import UsageError
from spacar.symbolic import MultibodySystem
from spacar.symbolic.compiled_program import compiler

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


def spacar(*arguments: str) -> tuple[int, str, str]:
    """Exit status, stdout, stderr of the command line."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        status = main([*arguments])
    return status, out.getvalue(), err.getvalue()


@pytest.fixture
def result(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pendulum.toml").write_text(MODEL)
    status, _, err = spacar("symbolic", "simulate", "pendulum.toml", "--time", "0.5", "--steps", "20")
    assert status == 0, err
    return tmp_path


def table(*arguments: str) -> np.ndarray:
    status, out, err = spacar("plot", "pendulum", *arguments, "--csv", "-")
    assert status == 0, err
    return np.array(list(csv.reader(io.StringIO(out)))[1:], float)


def test_states_and_outputs_are_plotted_by_name_and_in_expressions(result):
    t, q, y, difference, energy = table("q", "P.y", "P.y + 0.5*cos(q)", "T + V").T
    assert np.allclose(t, np.linspace(0, 0.5, 21), atol=1e-15)
    assert np.max(abs(y + 0.5 * np.cos(q))) < 1e-15
    assert np.max(abs(difference)) < 1e-15
    assert np.ptp(energy) < 1e-6 * abs(energy[0])  # rtol 1e-8 of the run over half a period
    assert q[0] == 0.3
    assert q[-1] < 0


def test_a_picture_is_written_without_options(result):
    assert spacar("plot", "pendulum", "q", "s")[0] == 0
    assert (result / "pendulum_plot.png").stat().st_size > 1000


def test_one_step_is_enough(result):
    spacar("symbolic", "simulate", "pendulum.toml", "--time", "0.5", "--steps", "1")
    assert table("q").shape == (2, 2)


@pytest.mark.parametrize("command", ["draw", "report", "visual"])
def test_what_needs_nodes_says_in_one_sentence_why_not(result, command):
    status, _, err = spacar(command, "pendulum")
    assert status == 2
    assert "result of spacar symbolic" in err
    assert "use spacar plot" in err
    assert "Traceback" not in err


@pytest.mark.parametrize("text", ["bogus", "x[1,2]", "q[1,1]"])
def test_an_unknown_name_is_answered_with_the_known_ones(result, text):
    status, _, err = spacar("plot", "pendulum", text)
    assert status == 2
    assert "q, s, T + V, P.y" in err


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_compile_is_one_call_and_gives_the_same_numbers():
    S = MultibodySystem(gravity=("0", "-g", "0"))
    q, _ = S.coordinate("q", speed="s")
    m, L = S.parameters("m L")
    B = S.frame("B", S.N, 3, q)
    P = S.point("P", S.O, L * B[1])
    S.particle("bob", P, m)
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
