"""The generated Fortran solves and differentiates: rhs, outputs and jac against Python and central differences."""

import ctypes

import numpy as np
import pytest

from .systems import links
from .test_emit import build

VALUES = {"g": 9.81, "m": 1.3, "L": 0.4, "J": 0.02, "d": 0.5, "k": 3.0, "EI": 2.0, "rho": 0.3, "c": 0.2}


LAW = (
    "-k*sign(s1)*abs(q1) + sin(t) - P1.vx + max(0, q1, 0.1) - min(q1, 1) + (k if t > 0.5 else 2*k*q1)"
    " + smoothmax(-q1, 0.01) - smoothsign(s1, 0.1)"
)


def driven(count, closed, flexible=False):
    S, frame, end = links(count)
    if flexible:
        end = S.beam("rod", frame, end, "L", "rho", EI="EI", field=2, damping="c").tip
    S.torque(frame, S.input("M", LAW) * S.N[3])
    S.force(end, S.input("F") * S.N[1])
    if closed:
        S.close(end, S.point("G", S.O, S.expression("d") * S.N[1]), [S.N[1], S.N[2]], "loop")
    outputs = {"height": end.position & S.N[2], "s1_dot": "s1_dot"} | ({"force": "loop_1_force"} if closed else {})
    return S.derive("recursive").program(outputs)


class Fortran:
    """The routines of a compiled module by ctypes, with the constants of one set of parameters."""

    def __init__(self, program, folder):
        flags = "-Wextra", "-Wno-error=compare-reals", "-fcheck=all"
        text = program.text("fortran", jacobian=True)
        self.library, self.program = build("fortran", text, folder, *flags), program
        self.p = np.array([VALUES[s.name] for s in program.parameters])
        self.c = np.zeros(max(len(program.jacobian.once), 1))
        self.library.eom_once(*self.at(self.p, self.c))

    def at(self, *arrays):
        return [a.ctypes.data_as(ctypes.c_void_p) for a in arrays]

    def call(self, name, size, t, y, u):
        result, u = np.zeros(size), np.array(u, float)
        bad = getattr(self.library, name)(ctypes.c_double(t), *self.at(self.c, self.p, np.array(y), u, result))
        return bad, result


@pytest.mark.parametrize(
    ("count", "closed", "flexible"),
    [(2, False, False), pytest.param(3, True, False, marks=pytest.mark.slow), (1, True, True)],
)
def test_fortran_equals_python(tmp_path, count, closed, flexible):
    """On both sides of a switch in time; laws with jumps too, that test_laws.py knows in closed form."""
    program = driven(count, closed, flexible)
    feeds = {"F": lambda t, y: 0.7}
    python, fortran = program.function(VALUES, feeds=feeds), Fortran(program, tmp_path)
    n = len(program.state)
    y = np.random.default_rng(count).uniform(-0.8, 0.8, n)
    if flexible:
        y[count : n // 2] *= 1e-2
    u = [0.7 if s.name == "F" else 0.0 for s in program.inputs]
    for t in (0.6, 0.3):
        bad, rates = fortran.call("rhs", n, t, y, u)
        assert bad == 0
        exact = np.array(python(t, y.tolist()))
        assert np.max(abs(rates - exact)) < 1e-11 * np.max(abs(exact))  # eps times the condition of I
    _, J = fortran.call("jac", n * n, 0.3, y, u)
    assert np.max(abs(J.reshape(n, n) - python.jac(0.3, y.tolist()))) < 1e-11 * np.max(abs(J))
    _, out = fortran.call("outputs", len(program.outputs), 0.3, y, u)
    assert out == pytest.approx(python.outputs(0.3, y.tolist()), rel=1e-10)
    for k in range(n):
        e = np.eye(n)[k] * 1e-6 * max(abs(y[k]), 1e-3)
        ends = [fortran.call("rhs", n, 0.3, y + s * e, u)[1] for s in (1, -1)]
        slope = (ends[0] - ends[1]) / (2 * e[k])
        assert J.reshape(n, n)[:, k] == pytest.approx(slope, rel=1e-5, abs=1e-6 * np.max(abs(J)))


def test_pivots_are_reported(tmp_path):
    """A negative mass gives the number of the speed; two equal constraints at one place give −1."""
    program = driven(2, False)
    fortran = Fortran(program, tmp_path)
    fortran.p[[s.name for s in program.parameters].index("m")] = -9.0
    fortran.library.eom_once(*fortran.at(fortran.p, fortran.c))
    assert fortran.call("rhs", 4, 0.0, np.array([0.1, 0.2, 0.3, 0.4]), [0.0] * len(program.inputs))[0] == 1
    (tmp_path / "two").mkdir()
    closed = Fortran(driven(2, True), tmp_path / "two")
    stretched = np.zeros(4)  # both links along the line to G: the rows of the loop along y remain, along x vanish
    assert closed.call("rhs", 4, 0.0, stretched, [0.0] * len(closed.program.inputs))[0] == -1
