"""Non-holonomic systems: the Chaplygin sleigh of symbolic.md, section 3.5, in closed form and with a flexible beam."""

import math

import numpy as np
import pytest
import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic import MultibodySystem, beam_shapes

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
