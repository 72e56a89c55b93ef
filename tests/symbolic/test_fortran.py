"""The generated Fortran solves and differentiates: rhs, outputs and jac against Python and central differences."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

pytest.importorskip("sympy")

from spacar.symbolic import MultibodySystem

pytestmark = pytest.mark.skipif(shutil.which("gfortran") is None, reason="no gfortran")

VALUES = {"g": 9.81, "m": 1.3, "L": 0.4, "J": 0.02, "d": 0.5, "k": 3.0, "EI": 2.0, "rho": 0.3, "c": 0.2}


def links(count, closed, flexible=False):
    S = MultibodySystem(gravity=(0, "-g", 0))
    frame, end = S.N, S.O
    for i in range(1, count + 1):
        q, _ = S.coordinate(f"q{i}", speed=f"s{i}")
        frame = S.frame(f"B{i}", frame, 3, q)
        middle = S.point(f"C{i}", end, S.expression("L/2") * frame[1])
        S.rigid_body(f"body{i}", frame, middle, "m", (0, 0, "J"))
        end = S.point(f"P{i}", end, S.expression("L") * frame[1])
    if flexible:
        end = S.beam("rod", frame, end, "L", "rho", EI="EI", field=2, damping="c").tip
    S.torque(frame, S.input("M", "-k*sign(s1)*abs(q1) + sin(t) - P1.vx") * S.N[3])
    S.force(end, S.input("F") * S.N[1])
    if closed:
        S.close(end, S.point("G", S.O, S.expression("d") * S.N[1]), [S.N[1], S.N[2]], "loop")
    outputs = {"height": end.position & S.N[2], "s1_dot": "s1_dot"} | ({"force": "loop_1_force"} if closed else {})
    return S.derive("recursive").program(outputs)


class Fortran:
    """The routines of a compiled module by ctypes, with the constants of one set of parameters."""

    def __init__(self, program, folder):
        (folder / "m.f90").write_text(program.text("fortran", jacobian=True))
        flags = ["-std=f2008", "-Wall", "-Wextra", "-Werror", "-Wno-error=compare-reals", "-fcheck=all", "-O1"]
        done = subprocess.run(
            ["gfortran", *flags, "-shared", "-fPIC", "-J", str(folder), "-o", str(folder / "m.so"),
             str(folder / "m.f90")], capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        self.library, self.program = ctypes.CDLL(str(folder / "m.so")), program
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
    program = links(count, closed, flexible)
    feeds = {"F": lambda t, y: 0.7}
    python, fortran = program.function(VALUES, feeds=feeds), Fortran(program, tmp_path)
    n = len(program.state)
    y = np.random.default_rng(count).uniform(-0.8, 0.8, n)
    if flexible:
        y[count : n // 2] *= 1e-2
    u = [0.7 if s.name == "F" else 0.0 for s in program.inputs]
    bad, rates = fortran.call("rhs", n, 0.3, y, u)
    assert bad == 0
    exact = np.array(python(0.3, y.tolist()))
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
    program = links(2, False)
    fortran = Fortran(program, tmp_path)
    fortran.p[[s.name for s in program.parameters].index("m")] = -9.0
    fortran.library.eom_once(*fortran.at(fortran.p, fortran.c))
    assert fortran.call("rhs", 4, 0.0, np.array([0.1, 0.2, 0.3, 0.4]), [0.0] * len(program.inputs))[0] == 1
    (tmp_path / "two").mkdir()
    closed = Fortran(links(2, True), tmp_path / "two")
    stretched = np.zeros(4)  # both links along the line to G: the rows of the loop along y remain, along x vanish
    assert closed.call("rhs", 4, 0.0, stretched, [0.0] * len(closed.program.inputs))[0] == -1
