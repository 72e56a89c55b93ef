"""Non-holonomic systems: the Chaplygin sleigh of symbolic.md, section 3.5, in closed form and with a flexible beam."""

import math

import numpy as np
import pytest
import sympy as sp
from spacar_cli.symbolic_plot import plot

from spacar.errors import UsageError
from spacar.symbolic import MultibodySystem, beam_shapes, set_omega
from spacar.symbolic.beam_shapes import X, integral
from spacar.symbolic.closure import Manifold
from spacar.symbolic.compiled_program import CompiledFunction, compiler
from spacar.symbolic.printing import text
from spacar.symbolic.simulated_motion import absolute_tolerance, make_function, simulate
from spacar.symbolic.unit_vectors import TIME

from .systems import pendulum

VALUES = {"m": 2.0, "J": 0.05, "a": 0.2, "rho": 0.5, "L": 0.8, "EI": 1.0}
START = {"v": 0.1, "w": 1.5}
# t, v, w, theta, tip deflection, x, y: two integrators, energy kept to 7e-15 J (reference, 3.5)
FLEXIBLE = """1 0.409127458976 0.705816546911 1.123758888536 6.19725536109e-3 0.206737596036 0.186994361823
2 0.455438632990 0.219823054981 1.549358650091 -5.4172671618e-4 0.289658542968 0.616312423656
5 0.460289863955 0.011719124896 1.730954179038 -2.1942242743e-4 0.132237682544 1.984536587182"""


def sleigh(flexible, route):
    """Knife edge at the origin of frame B; route: quasi-velocities, a given velocity, or a constraint."""
    S = MultibodySystem()
    m, J, a = S.parameters("m J a")
    x, y, theta = (S.coordinate(name) for name in ("x", "y", "theta"))
    if route == "constraint":
        vx, vy = S.speed("vx"), S.speed("vy")
        w = S.speed("w")
        S.kinematic(x, vx)
        S.kinematic(y, vy)
    else:
        v, w = S.speed("v"), S.speed("w")
        S.kinematic(x, v * sp.cos(theta))
        S.kinematic(y, v * sp.sin(theta))
    S.kinematic(theta, w)
    B = S.frame("B", S.N, 3, theta)
    velocity = v * B[1] if route == "given" else None
    P = S.point("P", S.O, x * S.N[1] + y * S.N[2], velocity=velocity)
    S.rigid_body("sleigh", B, at=S.point("G", P, a * B[1]), mass=m, inertia=(0, 0, J))
    if route == "constraint":
        S.constraint(P.velocity & B[2])
    beam = None
    if flexible:
        rho, L, EI = S.parameters("rho L EI")
        field = beam_shapes.monomial(2, 3, 4)
        beam = S.beam("beam", frame=B, root=P, length=L, mass=rho, EI=EI, field=field)
    return S, beam


@pytest.mark.parametrize("strategy", ["held", "recursive"])
@pytest.mark.parametrize("route", ["quasi", "given"])
def test_rigid_sleigh_in_closed_form(strategy, route):
    """v = V tanh kV(t + t0), k = m a/(J + m a²), V² = v0² + (J + m a²) w0²/m."""
    S, _ = sleigh(False, route)
    run = S.derive(strategy).program().simulate(VALUES, START, t_end=5.0, steps=50, rtol=1e-10)
    m, J, a = VALUES["m"], VALUES["J"], VALUES["a"]
    V, k = math.sqrt(0.1**2 + (J + m * a * a) * 1.5**2 / m), m * a / (J + m * a * a)
    t0 = math.atanh(0.1 / V) / (k * V)
    assert np.max(np.abs(run["v"] - V * np.tanh(k * V * (run.time + t0)))) < 1e-8
    assert run["v"][-1] == pytest.approx(0.395282246180, abs=1e-9)
    assert run["w"][-1] == pytest.approx(0.005471401402, abs=1e-9)


@pytest.mark.parametrize(("flexible", "strategy"), [
    (False, "held"), (False, "recursive"), pytest.param(True, "held", marks=pytest.mark.slow), (True, "recursive"),
])  # fmt: skip
def test_dependent_speeds_give_the_same_accelerations(strategy, flexible):
    """The constraint route against the quasi-velocities: same θ̈ and, projected, same v̇."""
    free, _ = sleigh(flexible, "quasi")
    tied, _ = sleigh(flexible, "constraint")
    p, c = free.derive(strategy).program(), tied.derive(strategy).program()
    rng = np.random.default_rng(5)
    theta, v = 0.7, 0.4
    state = {s.name: x for s, x in zip(p.state, rng.uniform(-0.1, 0.1, len(p.state)), strict=True)}
    state |= {"theta": theta, "v": v, "w": 1.3, "vx": v * math.cos(theta), "vy": v * math.sin(theta)}
    f, g = p.function(VALUES), c.function(VALUES)
    names_f, names_g = ([s.name for s in q.state] for q in (p, c))
    rates_f = dict(zip(names_f, f(0.0, [state[n] for n in names_f]), strict=True))
    rates_g = dict(zip(names_g, g(0.0, [state[n] for n in names_g]), strict=True))
    # the state holds both velocities of the edge: a = v̇ b1 + v w b2
    assert len(names_g) == len(names_f) + 1
    for kept, along, across in (("vx", math.cos(theta), -math.sin(theta)), ("vy", math.sin(theta), math.cos(theta))):
        assert rates_g[kept] == pytest.approx(rates_f["v"] * along + v * across * 1.3, rel=1e-11)
    for name in set(names_f) & set(names_g):
        assert rates_g[name] == pytest.approx(rates_f[name], rel=1e-10, abs=1e-12)


@pytest.mark.parametrize(("strategy", "t_end"), [
    ("recursive", 1.0), *(pytest.param(s, 5.0, marks=pytest.mark.slow) for s in ("held", "recursive")),
])  # fmt: skip
def test_flexible_sleigh(strategy, t_end):
    """All printed digits of the two-integrator reference are within 1e-9 at rtol 1e-11."""
    S, beam = sleigh(True, "quasi")
    eq = S.derive(strategy)
    program = eq.program({"tip": beam.tip.u, "E": sum(eq.energy())})
    rows = np.array([[float(x) for x in line.split()] for line in FLEXIBLE.splitlines()])
    rows = rows[rows[:, 0] <= t_end]
    run = program.simulate(
        VALUES, START, t_end=t_end, at=np.array([0.0, *rows[:, 0]]), rtol=1e-11, atol=1e-13, integrator="lsoda"
    )
    got = np.column_stack([run[name][1:] for name in ("v", "w", "theta", "tip", "x", "y")])
    assert np.max(np.abs(got - rows[:, 1:])) < 2e-9
    assert np.ptp(run["E"]) < 1e-9


@pytest.mark.parametrize("strategy", ["held", "recursive"])
def test_force_of_the_knife_edge(strategy):
    """The only force on the sleigh is that of the edge along b2: λ = m a_G·b2 = m (v w + a ẇ)."""
    tied, _ = sleigh(False, "constraint")
    eq = tied.derive(strategy)
    program = eq.program({"edge": "constraint1_force"})
    theta, v, w = 0.7, 0.4, 1.3
    state = {"theta": theta, "vx": v * math.cos(theta), "vy": v * math.sin(theta), "w": w}
    y = [state.get(s.name, 0.0) for s in program.state]
    rates = dict(zip([s.name for s in program.state], program.function(VALUES)(0.0, y), strict=True))
    expected = VALUES["m"] * (v * w + VALUES["a"] * rates["w"])
    assert program.function(VALUES).outputs(0.0, y) == pytest.approx([expected], rel=1e-12)


def test_wrong_constraints_say_what_and_why():
    S, _ = sleigh(False, "constraint")
    S.constraint("vx**2 - vy")
    with pytest.raises(UsageError, match=r"constraint2: .* = 0 is not linear in the speeds"):
        S.derive()
    S, _ = sleigh(False, "constraint")
    S.constraint(S.constraints[0].velocity * 2)
    with pytest.raises(UsageError, match="2 constraints have rank 1"):
        S.derive()


# The description of a system: strong forms, inputs, plots, wrong calls.
def test_strong_form_is_the_beam_equation_with_its_boundary_conditions(arm):
    """EI u'''' + ρ a·b2 − f·b2 − 2γ u_xxt = 0; the free end has no load, the end of beam 1 has E."""
    eq = arm().equations("held")
    last = eq.strong_form(arm().link2)
    u = arm().link2.fields[0].function
    EI, gam, rho, g = sp.symbols("EI gam rho g", real=True)
    for derivative, factor in ((u.diff(X, 4), EI), (u.diff(X, 2, TIME), -2 * gam), (u.diff(TIME, 2), rho)):
        assert last.equation.coeff(derivative) == factor
    B2, N = arm().link2.frame, arm().system.N
    assert last.equation.coeff(N[2] & B2[2]) == rho * g
    assert last.essential == (u, u.diff(X))
    assert last.natural == ((EI * u.diff(X, 2), 0), (-EI * u.diff(X, 3) + 2 * gam * u.diff(X, TIME), 0))
    first = eq.strong_form(arm().link1)
    assert first.natural[0][1].has(sp.Symbol("link1_uxt_dot", real=True))
    with pytest.raises(UsageError, match="no bending field 'w'"):
        eq.strong_form(arm().link1, "w")
    with pytest.raises(UsageError, match="vector notation"):
        arm().equations("recursive").strong_form(arm().link1)


def test_inputs_without_law_are_fed_by_functions():
    """A pendulum without gravity under a torque cos 2t: q = (1 − cos 2t)/(4 m L²)."""
    S, A, *_ = pendulum()
    T = S.input("T")
    S.torque(A, T * A[3], reaction=S.N)
    program = S.derive("recursive").program()
    values = {"m": 2.0, "L": 0.5, "g": 0.0}
    with pytest.raises(UsageError, match="input T has no law"):
        program.simulate(values, {}, t_end=1.0)
    run = program.simulate(values, {}, t_end=1.0, steps=4, rtol=1e-10, feeds={"T": lambda t, y: np.cos(2 * t)})
    assert run["q"] == pytest.approx((1 - np.cos(2 * run.time)) / (4 * 2.0 * 0.25), abs=1e-8)
    assert run["T"] == pytest.approx(np.cos(2 * run.time))


def test_laws_may_depend_on_time():
    S, A, *_ = pendulum()
    T = S.input("T", sp.cos(2 * TIME))
    S.torque(A, T * A[3], reaction=S.N)
    run = S.derive("held").program().simulate({"m": 2.0, "L": 0.5, "g": 0.0}, {}, t_end=1.0, steps=4, rtol=1e-10)
    assert run["q"] == pytest.approx((1 - np.cos(2 * run.time)) / 2, abs=1e-8)


@pytest.mark.parametrize("strategy", ["held", "recursive"])
def test_prescribed_motion_enters_as_time(strategy):
    """A pendulum on a pivot that moves by A sin 3t: q̈ = −(g cos q + 9 A sin 3t sin q)/L for q from the horizontal."""
    S = MultibodySystem(gravity=("0", "-g", "0"))
    q, _s = S.coordinate("q", speed="s")
    m, L, A = S.parameters("m L A")
    pivot = S.point("pivot", S.O, A * sp.sin(3 * TIME) * S.N[1])
    B = S.frame("B", S.N, 3, q)
    S.particle("bob", S.point("P", pivot, L * B[1]), m)
    f = S.derive(strategy).program().function({"m": 2.0, "L": 0.5, "g": 9.81, "A": 0.1})
    t, angle = 0.7, 0.4
    expected = -(9.81 * np.cos(angle) + 9 * 0.1 * np.sin(3 * t) * np.sin(angle)) / 0.5
    assert f(t, [angle, 0.3])[1] == pytest.approx(expected, rel=1e-12)


def test_pendulum_linearized_and_plotted():
    S, *_ = pendulum()
    eq = S.derive()
    assert "(t)" not in text(eq.held[0])
    linear = eq.linearize({"m": 2.0, "L": 0.5, "g": 9.81}, {"q": -np.pi / 2})
    assert linear.K0[0, 0] / linear.M0[0, 0] == pytest.approx(9.81 / 0.5, rel=1e-12)
    assert linear.C0[0, 0] == 0
    run = eq.program().simulate({"m": 2.0, "L": 0.5, "g": 9.81}, {"q": 0.1}, t_end=0.1, steps=3)
    (figure,) = plot(run)
    assert figure.axes[0].get_ylabel() == "q"
    with pytest.raises(UsageError, match="no result named 'z'"):
        run["z"]


def test_general_shapes_are_integrated_to_rounding():
    """∫_0^L cosh²(x/L) dx = L (1/2 + sinh(2)/4); exact polynomials; a shape that knows L otherwise is refused."""
    L = sp.Symbol("L")
    value = integral(sp.cosh(X / L) ** 2, X, L)
    assert abs(value / L - (sp.Rational(1, 2) + sp.sinh(2) / 4)).evalf(30) < 1e-28
    assert integral(X**3 - X, X, L) == L**4 / 4 - L**2 / 2
    with pytest.raises(UsageError, match="more than x/L"):
        integral(sp.cosh(X), X, L)


def test_orthogonal_shapes():
    """∫ψ_k ψ_l = 0 exactly, ψ(L) = 1, clamped."""
    L = sp.Symbol("L")
    psi = beam_shapes.orthogonal(4)(X, L)
    for i, a in enumerate(psi):
        assert a.subs(X, L) == 1
        assert a.subs(X, 0) == 0 == a.diff(X).subs(X, 0)
        for b in psi[:i]:
            assert sp.simplify(integral(a * b, X, L)) == 0


def test_wrong_calls_say_what_is_wrong():
    S, A, *_ = pendulum()
    with pytest.raises(UsageError, match="already that of coordinate q"):
        S.coordinate("Q")
    with pytest.raises(UsageError, match="axis must be 1, 2 or 3"):
        S.frame("B", A, 4, 0)
    with pytest.raises(UsageError, match="unknown strategy 'lagrange'"):
        S.derive("lagrange")
    with pytest.raises(UsageError, match="bending needs EI"):
        S.beam("b", A, S.O, 1, 1)
    with pytest.raises(UsageError, match=r"does not satisfy u\(0\) = 0"):
        S.beam("c", A, S.O, 1, 1, field=(), twist=["1 - x"], GJ=1)
    with pytest.raises(UsageError, match="bends must be"):
        S.beam("d", A, S.O, 1, 1, EI=1, bends=1)
    S.coordinate("x")
    with pytest.raises(UsageError, match="coordinate x has no kinematic equation"):
        S.derive()


def test_wrong_simulations_say_what_is_wrong():
    S, *_ = pendulum()
    program = S.derive("recursive").program()
    values = {"m": 1.0, "L": 1.0, "g": 9.81}
    for options, message in (
        ({"t_end": 1.0, "rtol": 0.1}, "rtol = 0.1 must be positive and at most 0.01"),
        ({"t_end": -1.0}, "both must be positive"),
        ({"t_end": 1.0, "integrator": "euler"}, "unknown integrator 'euler'"),
        ({"t_end": 1.0, "atol": {"z": 1.0}}, "z is not a state"),
        ({"t_end": 1.0, "guess": ["z"]}, "guess: z is not a state"),
    ):
        with pytest.raises(UsageError, match=message):
            program.simulate(values, {"q": 0.1}, **options)
    with pytest.raises(UsageError, match="start: z is not a state"):
        program.simulate(values, {"z": 1.0}, t_end=1.0)


def geared_wheels() -> MultibodySystem:
    """Two wheels without angles of their own, inertias 1 and 2, w = 2 v, a torque 3 on the first."""
    system = MultibodySystem()
    w, v = system.speed("w"), system.speed("v")
    for name, speed, inertia in (("a", w, 1), ("b", v, 2)):
        frame = system.frame(name.upper(), system.N, 3, 0)
        set_omega(system.N, frame, speed * system.N[3])
        system.rigid_body(name, frame, system.O, 1, (1, 1, inertia))
        if name == "a":
            system.torque(frame, 3 * system.N[3])
    system.constraint(w - 2 * v)
    return system


def test_speeds_alone_are_brought_onto_their_constraint() -> None:
    """The nearest speeds in the metric of the masses, 1 and 2."""
    program = geared_wheels().derive(strategy="held").program()
    found = Manifold(program, make_function(program, {})).project(0.0, np.array([2.0, 1.5]))
    # minimum of (w - 2)^2 + 2 (v - 1.5)^2 on w = 2 v
    np.testing.assert_allclose(found, [7.0 / 3.0, 7.0 / 6.0], rtol=1e-14)


@pytest.mark.parametrize("compiled", [False, True] if compiler() else [False])
def test_speeds_alone_are_simulated(compiled: bool) -> None:
    """(1 + 2/4) w' = 3 from w = 2 v = 1. A speed is not the scale of another."""
    program = geared_wheels().derive(strategy="held").program()
    function = CompiledFunction(program, {}) if compiled else make_function(program, {})
    motion = simulate(program, {}, {"w": 1.0}, t_end=2.0, steps=4, function=function)
    np.testing.assert_allclose(motion["w"], 1.0 + 2.0 * motion.time, rtol=1e-7)
    np.testing.assert_allclose(motion["v"], motion["w"] / 2.0, rtol=1e-14)
    tolerances = absolute_tolerance(program, np.array([2e6, 10.0]), function, 1e-8, None)
    np.testing.assert_allclose(tolerances, [2e-2, 1e-7])
