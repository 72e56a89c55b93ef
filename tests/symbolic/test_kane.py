"""Rigid systems against SymPy's KanesMethod (an independent derivation in components), both strategies."""

import random
from functools import cache

import numpy as np
import pytest
import sympy as sp
from sympy.physics import mechanics as me
from sympy.physics.vector import dynamicsymbols

from spacar.symbolic import MultibodySystem, transform
from spacar.symbolic.kanes import from_kanes_method

from .systems import links

STRATEGIES = ["held", "recursive"]


def numbers(program, values):
    result = program.evaluate(values, 30)
    return result["mass"], result["rhs"]


def assert_same(eq, oracle):
    """Equal mass matrices and right-hand sides at a random point, 30 digits, names shared."""
    p, o = eq.program(), oracle.program()
    chance = random.Random(4)
    names = sorted({s.name for s in [*p.parameters, *p.state, *o.parameters, *o.state]})
    values = {name: chance.uniform(0.3, 1.4) for name in names}
    (M, f), (K, g) = numbers(p, values), numbers(o, values)
    assert max(abs(x) for x in M - K) < 1e-25 * max(abs(x) for x in K)
    assert max(abs(x) for x in f - g) < 1e-25 * max(abs(x) for x in g)


# -- double pendulum --------------------------------------------------------------------------------------------


def double_pendulum():
    S = MultibodySystem(gravity=("0", "-g", "0"))
    m, L = S.parameters("m L")
    q1, _ = S.coordinate("q1", speed="s1")
    q2, _ = S.coordinate("q2", speed="s2")
    A = S.frame("A", S.N, 3, q1)
    B = S.frame("B", S.N, 3, q2)
    P = S.point("P", S.O, L * A[1])
    S.particle("one", P, m)
    S.particle("two", S.point("Q", P, L * B[1]), 2 * m)
    return S


@cache
def kane_pendulum():
    q1, q2, s1, s2 = dynamicsymbols("q1 q2 s1 s2", real=True)
    m, L, g = sp.symbols("m L g", real=True)
    N = me.ReferenceFrame("N")
    A, B = (N.orientnew(n, "Axis", (q, N.z)) for n, q in (("A", q1), ("B", q2)))
    A.set_ang_vel(N, s1 * N.z)
    B.set_ang_vel(N, s2 * N.z)
    O, P, Q = me.Point("O"), me.Point("P"), me.Point("Q")
    O.set_vel(N, 0)
    P.set_pos(O, L * A.x)
    Q.set_pos(P, L * B.x)
    P.v2pt_theory(O, N, A)
    Q.v2pt_theory(P, N, B)
    kane = me.KanesMethod(N, [q1, q2], [s1, s2], [q1.diff() - s1, q2.diff() - s2])
    bodies = [me.Particle("one", P, m), me.Particle("two", Q, 2 * m)]
    kane.kanes_equations(bodies, [(P, -m * g * N.y), (Q, -2 * m * g * N.y)])
    return from_kanes_method(kane)


def test_imported_kane_model_is_simulated():
    """The import route serves the whole chain: program, Jacobian, integration; equal to ours."""
    values, start = {"m": 1.0, "L": 0.5, "g": 9.81}, {"q1": 0.3, "q2": -0.4}
    theirs = kane_pendulum().program().simulate(values, start, t_end=1.0, steps=5, rtol=1e-9)
    ours = double_pendulum().derive("recursive").program().simulate(values, start, t_end=1.0, steps=5, rtol=1e-9)
    assert abs(theirs.state - ours.state).max() < 1e-7


# -- rolling disk -----------------------------------------------------------------------------------------------


INERTIA = ("m*r**2/4", "m*r**2/2", "m*r**2/4")


def disk(*more):
    """System, coordinates, frame of the disk, radius from the ground to the centre, velocity of the centre.

    Coordinates: yaw, lean, spin, and what `more` names. Speeds: measure numbers of the angular velocity as leaned."""
    S = MultibodySystem(gravity=("0", "0", "-g"))
    q = [S.coordinate(name) for name in ("q1", "q2", "q3", *more)]
    s = [S.speed(f"s{i}") for i in (1, 2, 3)]
    S.kinematic(q[1], s[0])
    S.kinematic(q[0], s[2] / sp.cos(q[1]))
    S.kinematic(q[2], s[1] - s[2] * sp.tan(q[1]))
    A = S.frame("A", S.frame("Y", S.N, 3, q[0]), 1, q[1])
    D = S.frame("D", A, 2, q[2])
    w = s[0] * A[1] + s[1] * A[2] + s[2] * A[3]
    radius = S.expression("r") * A[3]
    return S, q, D, radius, w ^ radius


def rolling_disk():
    S, _, D, radius, rolling = disk()
    S.rigid_body("disk", D, S.point("C", S.O, radius, velocity=rolling), "m", INERTIA)
    return S


@cache
def kane_disk():
    q1, q2, q3, s1, s2, s3 = dynamicsymbols("q1 q2 q3 s1 s2 s3", real=True)
    r, m, g = sp.symbols("r m g", real=True)
    N = me.ReferenceFrame("N")
    Y = N.orientnew("Y", "Axis", [q1, N.z])
    A = Y.orientnew("A", "Axis", [q2, Y.x])
    D = A.orientnew("D", "Axis", [q3, A.y])
    w = D.ang_vel_in(N)
    kinematic = [me.dot(w - (s1 * A.x + s2 * A.y + s3 * A.z), e) for e in A]
    rates = sp.solve(kinematic, [q1.diff(), q2.diff(), q3.diff()], dict=True)[0]
    A.set_ang_vel(N, A.ang_vel_in(N).subs(rates).simplify())
    D.set_ang_vel(N, s1 * A.x + s2 * A.y + s3 * A.z)
    C = me.Point("C")
    C.set_vel(N, 0)
    Dmc = C.locatenew("Dmc", r * A.z)
    Dmc.v2pt_theory(C, N, D)
    k = m * r**2 / 4
    body = me.RigidBody("disk", Dmc, D, m, (me.inertia(A, k, 2 * k, k), Dmc))
    kane = me.KanesMethod(N, q_ind=[q1, q2, q3], u_ind=[s1, s2, s3], kd_eqs=kinematic)
    kane.kanes_equations([body], [(Dmc, -m * g * Y.z)])
    return from_kanes_method(kane)


@pytest.mark.parametrize("strategy", [pytest.param("held", marks=pytest.mark.slow), "recursive"])
def test_rolling_disk_by_elimination_is_the_same(strategy):
    """Five speeds, rolling as two constraints: ẋ and ẏ of the centre become dependent; E_i + Aᵀ E_d = 0."""
    S, q, D, _, rolling = disk("x", "y")
    v = [S.speed("vx"), S.speed("vy")]
    for coordinate, rate in zip(q[3:], v, strict=True):
        S.kinematic(coordinate, rate)
    r = S.expression("r")
    C = S.point("C", S.O, q[3] * S.N[1] + q[4] * S.N[2] + r * sp.cos(q[1]) * S.N[3])
    S.rigid_body("disk", D, C, "m", INERTIA)
    slip = C.velocity - rolling
    S.constraint(slip & S.N[1])
    S.constraint(slip & S.N[2])
    program = S.derive(strategy).program({f"s{i}": f"s{i}_dot" for i in (1, 2, 3)})
    oracle = kane_disk().program()
    chance = random.Random(4)
    values = {p.name: chance.uniform(0.3, 1.4) for p in {*program.parameters, *program.state}}
    z = sp.Float(0)
    at = {"q2": values["q2"], "q1": values["q1"], **{f"s{i}": values[f"s{i}"] for i in (1, 2, 3)}}
    # rolling velocities of the centre from the slip itself, so that the state fits the constraints
    rolling = sp.solve([transform(slip & S.N[i]) for i in (1, 2)], v, dict=True)[0]
    point = {q[0]: at["q1"], q[1]: at["q2"], r: values["r"], **{s: at[s.func.__name__] for s in S.speeds[:3]}}
    values |= {name: sp.N(rolling[u].xreplace({k: sp.Float(x, 60) for k, x in point.items()}), 50) + z
               for name, u in zip(("vx", "vy"), v, strict=True)}  # fmt: skip
    got = program.evaluate(values, 30)["outputs"]
    M, f = numbers(oracle, values)
    expected = M.LUsolve(f)
    for i, x in enumerate(expected, 1):
        assert abs(got[f"s{i}"] - x) < 1e-24 * max(abs(a) for a in expected)


# -- heavy top --------------------------------------------------------------------------------------------------


def heavy_top():
    S = MultibodySystem(gravity=("0", "0", "-g"))
    m, L, I1, I3 = S.parameters("m L I1 I3")
    q = [S.coordinate(f"q{i}", speed=f"s{i}") for i in (1, 2, 3)]
    A = S.frame("A", S.N, 3, q[0][0])
    B = S.frame("B", A, 1, q[1][0])
    C = S.frame("C", B, 3, q[2][0])
    S.rigid_body("top", C, at=S.point("G", S.O, L * B[3]), mass=m, inertia=(I1, I1, I3))
    return S


@cache
def kane_top():
    q = dynamicsymbols("q1:4", real=True)
    s = dynamicsymbols("s1:4", real=True)
    m, L, I1, I3, g = sp.symbols("m L I1 I3 g", real=True)
    N = me.ReferenceFrame("N")
    C = N.orientnew("C", "Body", q, "ZXZ")
    C.set_ang_vel(N, C.ang_vel_in(N).xreplace({a.diff(): b for a, b in zip(q, s, strict=True)}))
    O = me.Point("O")
    O.set_vel(N, 0)
    G = O.locatenew("G", L * C.z)
    G.v2pt_theory(O, N, C)
    body = me.RigidBody("top", G, C, m, (me.inertia(C, I1, I1, I3), G))
    kane = me.KanesMethod(N, q, s, [a.diff() - b for a, b in zip(q, s, strict=True)])
    kane.kanes_equations([body], [(G, -m * g * N.z)])
    return from_kanes_method(kane)


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize(
    ("ours", "theirs"),
    [(double_pendulum, kane_pendulum), (rolling_disk, kane_disk), (heavy_top, kane_top)],
    ids=["double pendulum", "rolling disk without multipliers", "heavy top"],
)
def test_systems(ours, theirs, strategy):
    assert_same(ours().derive(strategy), theirs())


# -- spatial chain ----------------------------------------------------------------------------------------------


def chain(n):
    S = MultibodySystem(gravity=("0", "0", "-g"))
    m, L, I1, I2 = S.parameters("m L I1 I2")
    frame, point = S.N, S.O
    for k in range(1, n + 1):
        a, _ = S.coordinate(f"a{k}", speed=f"u{k}")
        b, _ = S.coordinate(f"b{k}", speed=f"v{k}")
        half = S.frame(f"H{k}", frame, 3, a)
        frame = S.frame(f"B{k}", half, 2, b)
        S.rigid_body(f"link{k}", frame, at=S.point(f"G{k}", point, L / 2 * frame[1]), mass=m, inertia=(I1, I2, I2))
        point = S.point(f"P{k}", point, L * frame[1])
    return S


@cache
def kane_chain(n):
    m, L, I1, I2, g = sp.symbols("m L I1 I2 g", real=True)
    N, O = me.ReferenceFrame("N"), me.Point("O")
    O.set_vel(N, 0)
    frame, point, qs, us, kd, bodies, loads = N, O, [], [], [], [], []
    for k in range(1, n + 1):
        a, b, u, v = dynamicsymbols(f"a{k} b{k} u{k} v{k}", real=True)
        half = frame.orientnew(f"H{k}", "Axis", (a, frame.z))
        turned = half.orientnew(f"B{k}", "Axis", (b, half.y))
        half.set_ang_vel(frame, u * frame.z)
        turned.set_ang_vel(half, v * half.y)
        G, P = point.locatenew(f"G{k}", L / 2 * turned.x), point.locatenew(f"P{k}", L * turned.x)
        G.v2pt_theory(point, N, turned)
        P.v2pt_theory(point, N, turned)
        bodies.append(me.RigidBody(f"l{k}", G, turned, m, (me.inertia(turned, I1, I2, I2), G)))
        loads.append((G, -m * g * N.z))
        qs += [a, b]
        us += [u, v]
        kd += [a.diff() - u, b.diff() - v]
        frame, point = turned, P
    kane = me.KanesMethod(N, qs, us, kd)
    kane.kanes_equations(bodies, loads)
    return from_kanes_method(kane)


@pytest.mark.parametrize("strategy", [pytest.param("held", marks=pytest.mark.slow), "recursive"])
def test_spatial_chain_of_two_links(strategy):
    assert_same(chain(2).derive(strategy), kane_chain(2))


def test_recursion_is_the_leanest_program_of_a_chain():
    """Operations per step at n = 2 (reference 4.4): KanesMethod 391, held 545, recursive 286."""
    lean = chain(2).derive("recursive").program().counts()["step"]
    assert lean <= 286 * 1.1
    assert lean < kane_chain(2).program().counts()["step"]


@pytest.mark.parametrize("count", [4, pytest.param(8, marks=pytest.mark.slow)])
def test_rigid_links_held(count):
    """Derived in seconds. Both strategies give one acceleration, to 8 eps cond(M): below 1e4 for eight equal links."""
    values = {"L": 0.4, "m": 1.3, "J": 0.05, "g": 9.81}
    y = np.random.default_rng(8).uniform(-0.5, 0.5, 2 * count).tolist()
    a, b = (np.array(links(count)[0].derive(kind).program().function(values)(0.0, y)) for kind in STRATEGIES)
    assert np.max(abs(a - b)) < 8 * np.finfo(float).eps * 1e4 * np.max(abs(b))
