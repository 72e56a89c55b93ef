"""Laws with jumps in Python and C (in Fortran: test_fortran.py); silent misreadings refused; TOML read as Python is."""

import math

import numpy as np
import pytest
import sympy as sp

from spacar.errors import InputError, UsageError
from spacar.symbolic import MultibodySystem, transform
from spacar.symbolic.compiled_program import CompiledFunction, compiler
from spacar.symbolic.model_reader import read_model

LAW = (
    "-mu*sign(v) - c*abs(v)*v + max(0, x, 0.1) - min(x, 1) + (k if t > 0.5 else 2*k*x)"
    " + smoothmax(-q, 0.01) - smoothsign(w, 0.1)"
)
VALUES = {"m": 2.0, "g": 9.81, "mu": 0.1, "c": 0.2, "k": 3.0}


def law(t, x, q, v, w):
    """The same by hand."""
    spring = 3.0 if t > 0.5 else 6.0 * x
    contact = (-q + math.sqrt(q * q + 1e-4)) / 2
    return -0.1 * np.sign(v) - 0.2 * abs(v) * v + max(0, x, 0.1) - min(x, 1) + spring + contact - math.tanh(10 * w)


def mass(text):
    S = MultibodySystem(gravity=(0, "-g", 0))
    x, _ = S.coordinate("x", speed="v")
    q, _ = S.coordinate("q", speed="w")
    P = S.point("P", S.O, x * S.N[1] + q * S.N[2])
    S.particle("body", P, "m")
    S.force(P, S.input("f", text) * S.N[1])
    return S.derive("recursive").program()


STATES = [(t, y) for t in (0.2, 0.6) for y in ([0.3, -0.2, 0.5, 0.1], [-0.3, 0.2, 0.0, -0.1], [1.5, 0.1, -0.5, 0.0])]


def test_laws_with_jumps_in_python_and_c():
    program = mass(LAW)
    f = program.function(VALUES)
    compiled = CompiledFunction(program, VALUES) if compiler() else None
    for t, y in STATES:
        expected = law(t, *y) / 2.0
        assert f(t, y)[2] == pytest.approx(expected, rel=1e-14)
        assert f(t, np.array(y))[2] == f(t, y)[2]  # as solvers of SciPy call it
        if compiled:
            assert compiled(t, np.array(y))[2] == pytest.approx(expected, rel=1e-14)
            assert compiled.jac(t, np.array(y)) == pytest.approx(np.asarray(f.jac(t, y)), rel=1e-13)
        if y[2] != 0.0:  # differences do not know the slope at a jump
            for k in range(4):
                e = 1e-6 * np.eye(4)[k]
                slope = (law(t, *(np.array(y) + e)) - law(t, *(np.array(y) - e))) / 4e-6
                assert f.jac(t, y)[2, k] == pytest.approx(slope, abs=1e-8)


def test_t_is_time_in_texts():
    """A frame that turns with 3 t carries its mass on a circle: the radial acceleration is −9 r."""
    S = MultibodySystem()
    r, _ = S.coordinate("r", speed="v")
    B = S.frame("B", S.N, 3, "3*t")
    S.particle("P", S.point("P", S.O, r * B[1]), "m")
    program = S.derive().program()
    assert "t" not in [s.name for s in program.parameters]
    assert program.function({"m": 1.0})(0.2, [0.5, 0.0])[1] == pytest.approx(4.5, rel=1e-14)


def test_laws_may_read_fields_and_velocities():
    """A damper at the tip by a law of its pseudo-speed equals the same force as a vector."""
    forces = []
    for route in ("law", "vector"):
        S = MultibodySystem()
        q, _ = S.coordinate("q", speed="s")
        B = S.frame("B", S.N, 3, q)
        beam = S.beam("arm", B, S.O, "L", "rho", EI="EI", field=2, foreshortening=False)
        velocity = beam.tip.velocity & B[2]
        force = S.input("damper", -3 * velocity) if route == "law" else -3 * velocity
        S.force(beam.tip, force * B[2])
        program = S.derive("recursive").program()
        assert {s.name for s in program.parameters} == {"L", "rho", "EI"}
        y = [0.3, 0.01, -0.02, 1.0, 0.2, -0.3]
        forces.append(program.function({"L": 1.0, "rho": 2.0, "EI": 5.0})(0.0, y))
    assert forces[0] == pytest.approx(forces[1], rel=1e-12)


def test_turns_about_one_axis_merge():
    S = MultibodySystem()
    names = ("q1", "q2", "q4")
    q = [S.coordinate(n, speed=f"s{n}")[0] for n in names]
    frame = S.N
    for k, angle in enumerate(q):
        frame = S.frame(f"B{k}", frame, 3, angle)
    assert transform(S.N[1] & frame[1]) == sp.cos(sum(q))


REFUSED = {
    "inertia as a text": (lambda S, B: S.rigid_body("b", B, S.O, 1, inertia="Jzz"), "3 or 6 numbers, not 'Jzz'"),
    "eight numbers": (lambda S, B: S.rigid_body("b", B, S.O, 1, inertia=range(8)), "3 or 6 numbers, not 8"),
    "parameter as coordinate": (lambda S, B: S.parameters("q"), "the name of a coordinate"),
    "parameter t": (lambda S, B: S.parameters("t"), "the name of time"),
    "vector as text": (lambda S, B: S.vector("abc", B), "a list of 3 measure numbers"),
    "two components": (lambda S, B: S.vector((1, 2), B), "a list of 3 measure numbers"),
    "offset": (lambda S, B: S.point("P", S.O, (1, 0, 0)), "must be a vector such as"),
    "force": (lambda S, B: S.force(S.O, (1, 0, 0)), "must be a vector such as"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_silent_misreadings_are_refused(name):
    make, message = REFUSED[name]
    S = MultibodySystem()
    q, _ = S.coordinate("q", speed="s")
    with pytest.raises(UsageError, match=message):
        make(S, S.frame("B", S.N, 3, q))


def test_a_symbol_named_like_a_coordinate_is_refused():
    S = MultibodySystem()
    q, _ = S.coordinate("q", speed="s")
    B = S.frame("B", S.N, 3, q)
    S.particle("P", S.point("P", S.O, sp.Symbol("q") * B[1]), 1)
    with pytest.raises(UsageError, match="q is a function of time and also a parameter"):
        S.derive().program()


TOML = """
[parameters]
m = 1.0
[coordinates]
x = { speed = "vx", start = 0.0, speed_start = 1.0 }
y = { speed = "vy" }
a = { speed = "w", start = 0.5, speed_start = 2.0 }
[[frame]]
name = "B"
parent = "N"
axis = 3
angle = "a"
[[point]]
name = "P"
base = "O"
offset = ["x", "y", 0]
[[body]]
name = "sledge"
at = "P"
mass = "m"
frame = "B"
inertia = [0, 0, 0.1]
[[constraint]]
name = "edge"
CONSTRAINT
[simulate]
time = 0.5
steps = 5
rtol = 1e-9
[outputs]
edge = "edge_force"
ax = "P.ax"
alpha = "w_dot"
"""


@pytest.mark.parametrize(
    "text", ['expression = "cos(a)*P.vy - sin(a)*P.vx"', 'point = "P"\ndirection = [0, 1, 0]\nin = "B"']
)
def test_constrained_models_from_files(tmp_path, text):
    """A knife edge at the centre of mass: v along b1 and w stay constant, the force is m v w."""
    path = tmp_path / "edge.toml"
    path.write_text(TOML.replace("CONSTRAINT", text))
    model = read_model(path)
    program = model.system.derive("recursive").program(model.outputs)
    run = program.simulate(model.values, model.start, t_end=0.5, steps=5, rtol=1e-9)
    v = 1.0 / math.cos(0.5)  # vx = 1 is given, vy is assembled
    assert run["vy"][0] == pytest.approx(math.tan(0.5), rel=1e-12)
    assert run["edge"] == pytest.approx(v * 2.0, rel=1e-7)
    assert run["ax"] == pytest.approx(-v * 2.0 * np.sin(run["a"]), rel=1e-6)
    assert run["alpha"] == pytest.approx(0.0, abs=1e-10)


def test_wrong_constraint_tables(tmp_path):
    path = tmp_path / "edge.toml"
    path.write_text(TOML.replace("CONSTRAINT", 'point = "P"'))
    with pytest.raises(InputError, match="either key 'expression', or keys 'point' and 'direction'"):
        read_model(path)
