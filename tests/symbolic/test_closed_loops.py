"""Closed loops of rigid bars: motion, reactions, linearization, start values; the constraint force of a stop."""

import random

import numpy as np
import pytest
import sympy as sp

from spacar.errors import AnalysisError, UsageError
from spacar.symbolic import MultibodySystem


def four_bar():
    S = MultibodySystem(gravity=(0, "-g", 0))
    B, tips = S.O, []
    at = S.O
    for k, length in enumerate(("a", "b", "c"), 1):
        q, _ = S.coordinate(f"q{k}", speed=f"w{k}")
        frame = S.frame(f"B{k}", S.N, 3, q)
        L = S.expression(length)
        S.rigid_body(
            f"bar{k}", frame, S.point(f"G{k}", at, L / 2 * frame[1]), f"m{k}",
            (0, 0, S.expression(f"m{k}*{length}**2/12")),
        )  # fmt: skip
        at = S.point(f"P{k}", at, L * frame[1])
        tips.append(at)
    ground = S.point("D", S.O, S.expression("d") * S.N[1])
    forces = S.close(at, ground)
    return S, tips, forces, B


BAR = {"g": 9.81, "a": 0.1, "b": 0.3, "c": 0.25, "d": 0.28, "m1": 1.0, "m2": 2.0, "m3": 1.5}


def test_four_bar_turns_through_every_choice_of_dependent_speeds():
    """Full turns of the crank: each of the three speeds passes through zero, so no fixed choice would do."""
    S, _, forces, _ = four_bar()
    assert len(forces) == 2  # the direction out of the plane is left out
    eq = S.derive("recursive")
    program = eq.program({"E": sum(eq.energy())})
    run = program.simulate(
        BAR, {"q1": 1.0, "w1": 12.0}, guess={"q2": 0.5, "q3": -1.0}, t_end=1.4, steps=100, integrator="dop853",
        rtol=1e-10,
    )  # fmt: skip
    assert run["q1"][-1] > 4 * np.pi
    assert np.min(np.abs(run["w3"])) < 0.3
    assert np.min(run["w3"]) < 0 < np.max(run["w3"])
    assert np.ptp(run["E"]) < 1e-8 * np.max(np.abs(run["E"]))
    # the loop closes: vector sum of the bars
    x = sum(BAR[k] * np.cos(run[f"q{i}"]) for i, k in enumerate("abc", 1))
    y = sum(BAR[k] * np.sin(run[f"q{i}"]) for i, k in enumerate("abc", 1))
    assert np.max(np.abs(x - BAR["d"])) < 1e-14
    assert np.max(np.abs(y)) < 1e-14


def test_reactions_and_accelerations_are_outputs():
    """Newton's law of the whole four-bar: force of the ground at D is what the bars' centres need less the crank's pin.

    Moments about O of all bars (own formula): Σ (r × m (a − g) + I α) = D × F.
    """
    S, _, forces, _ = four_bar()
    N = S.N
    eq = S.derive("held")
    outputs = {"fx": forces[0], "fy": forces[1]}
    for k, body in enumerate(S.bodies, 1):
        acceleration = S.ddt(N, body.point.velocity)
        outputs |= {f"ax{k}": acceleration & N[1], f"ay{k}": acceleration & N[2], f"al{k}": f"w{k}_dot"}
        outputs |= {f"x{k}": body.point.position & N[1], f"y{k}": body.point.position & N[2]}
    run = eq.program(outputs).simulate(
        BAR, {"q1": 1.0, "w1": 12.0}, guess={"q2": 0.5, "q3": -1.0}, t_end=0.1, steps=4, rtol=1e-9
    )
    moment = 0.0
    for k, length in enumerate("abc", 1):
        m = BAR[f"m{k}"]
        moment += m * (run[f"x{k}"] * (run[f"ay{k}"] + BAR["g"]) - run[f"y{k}"] * run[f"ax{k}"])
        moment += m * BAR[length] ** 2 / 12 * run[f"al{k}"]
    # the force acts on P3, which is at D = (d, 0)
    assert moment == pytest.approx(BAR["d"] * run["fy"], rel=1e-10)
    # rates of change of the angular speeds, by differences of the run itself
    fine = eq.program({"al": "w2_dot"}).simulate(
        BAR, {"q1": 1.0, "w1": 12.0}, guess={"q2": 0.5, "q3": -1.0}, t_end=2e-4, steps=2, rtol=1e-10
    )
    assert fine["al"][1] == pytest.approx((fine["w2"][2] - fine["w2"][0]) / 2e-4, rel=1e-5)


def test_linearized_closed_loop_against_the_time_series():
    """A four-bar hung up as a pendulum: frequency of small swings from K0/M0 and from zero crossings of a run."""
    S, _, _, _ = four_bar()
    eq = S.derive("recursive")
    values = BAR | {"a": 0.2, "c": 0.2, "b": 0.28, "m2": 5.0}
    at = {"q1": -np.pi / 2, "q2": 0.0, "q3": np.pi / 2}
    lin = eq.linearize(values, at)
    # all centres move on circles of radius 0.2 (bar 2) and 0.1: closed form of the parallelogram
    m1, m2, m3 = values["m1"], values["m2"], values["m3"]
    inertia = (m1 + m3) * 0.2**2 / 3 + m2 * 0.2**2
    stiffness = 9.81 * ((m1 + m3) * 0.1 + m2 * 0.2)
    assert len(lin.names) == 1
    assert abs(lin.eigenvalues()[0]) == pytest.approx(np.sqrt(stiffness / inertia), rel=1e-12)
    with pytest.raises(UsageError, match="does not satisfy"):
        eq.linearize(values, at | {"q2": 0.3})


def test_position_constraint_in_words():
    """sin(a) − 1/2 = 0 holds the angle at 30 degrees: no motion, the force balances gravity."""
    S = MultibodySystem(gravity=(0, "-g", 0))
    a, _ = S.coordinate("a", speed="w")
    x, _ = S.coordinate("x", speed="v")
    A = S.frame("A", S.N, 3, a)
    S.particle("P", S.point("P", S.O, (1 + x) * A[1]), "m")
    S.constraint("sin(a) - 1/2", name="stop")
    program = S.derive().program({"F": "stop_force"})
    run = program.simulate({"g": 9.81, "m": 2.0}, {}, guess={"a": 0.4}, t_end=0.1, steps=2)
    assert run["a"] == pytest.approx(np.pi / 6, abs=1e-14)
    # generalized force about O: λ cos a = m g (1 + x) cos a + 2 m (1 + x) v · 0
    assert run["F"] == pytest.approx(2.0 * 9.81 * (1 + run["x"]), rel=1e-10)
    assert run["x"][-1] == pytest.approx(-9.81 * 0.5 * 0.1**2 / 2, rel=1e-6)


def test_open_loops_and_empty_constraints_are_refused():
    S, _, _, _ = four_bar()
    program = S.derive("recursive").program()
    with pytest.raises(UsageError, match=r"close1_1 is open by .* leave one of them out"):
        program.simulate(BAR, {"q1": 1.0, "q2": 0.5, "q3": -1.0}, t_end=1.0)
    with pytest.raises(UsageError, match="cannot be closed"):
        program.simulate(BAR | {"d": 1.0}, {"q1": 1.0}, t_end=1.0)
    with pytest.raises(UsageError, match="violated at a rate"):
        program.simulate(BAR, {"q1": 1.0, "w1": 1.0, "w2": 1.0, "w3": 0.0}, guess={"q2": 0.5, "q3": -1.0}, t_end=1.0)
    with pytest.raises(UsageError, match="constrains nothing"):
        S.constraint("a - b")
    with pytest.raises(UsageError, match="coincide in every configuration"):
        S.close(S.O, S.O)
    with pytest.raises(UsageError, match="take the component"):
        S.constraint(S.N[1])


def test_rounded_start_values_are_moved_with_a_warning():
    S, _, _, _ = four_bar()
    program = S.derive("recursive").program()
    exact = program.simulate(BAR, {"q1": 1.0}, guess={"q2": 0.5, "q3": -1.0}, t_end=0.01, steps=1)
    start = {name: round(float(exact[name][0]), 6) for name in ("q1", "q2", "q3")}
    run = program.simulate(BAR, start, t_end=0.01, steps=1)
    assert any(note.startswith("warning") for note in run.notes)
    assert run["q2"][0] == pytest.approx(exact["q2"][0], abs=2e-6)


# Beams in space: two bending directions, torsion, stretch, foreshortening, sections with bodies, springs.
def spatial_beam(**options):
    """A beam on a universal joint with a rigid body at its tip."""
    S = MultibodySystem(gravity=("0", "0", "-g"))
    L, rho, EI, GJ, polar, EA, m, I1, I2 = S.parameters("L rho EI GJ polar EA m I1 I2")
    a, _ = S.coordinate("a", speed="u")
    b, _ = S.coordinate("b", speed="v")
    A = S.frame("A", S.N, 3, a)
    B = S.frame("B", A, 2, b)
    keys = {"GJ": GJ, "polar": polar} if "twist" in options else {}
    keys |= {"EA": EA} if "stretch" in options else {}
    beam = S.beam("beam", frame=B, root=S.O, length=L, mass=rho, EI=EI, **keys, **options)
    S.rigid_body("tip", beam.tip, at=beam.tip, mass=m, inertia=(I1, I2, I2))
    return S, beam


CASES = {
    "out of plane": {"bends": 3, "field": 1}, "two directions": {"bends": (2, 3), "field": 1, "foreshortening": False},
    "with torsion": {"bends": (2, 3), "field": (1, 1), "twist": 1, "foreshortening": False},
    "stretch": {"bends": 2, "field": 1, "stretch": 1, "foreshortening": False},
    "everything": {"bends": (2, 3), "field": (1, 1), "twist": 1, "stretch": 1, "foreshortening": True},
}  # fmt: skip


def largest(matrix):
    return max(abs(x) for x in matrix)


@pytest.mark.parametrize("case", [pytest.param(c, marks=[pytest.mark.slow] * (c != "out of plane")) for c in CASES])
def test_both_strategies_agree_and_keep_the_balance_of_energy(case):
    """30-digit arithmetic: 1e-25 is rounding. The energy check is independent of both derivations."""
    S, _ = spatial_beam(**CASES[case])
    held, lean = S.derive("held"), S.derive("recursive")
    p, q = held.program(), lean.program()
    chance = random.Random(2)
    values = {s.name: chance.uniform(0.3, 1.2) for s in [*p.parameters, *p.state, *q.parameters]}
    one, two = p.evaluate(values, 30), q.evaluate(values, 30)
    assert largest(one["mass"] - two["mass"]) < 1e-25 * largest(one["mass"])
    assert largest(one["rhs"] - two["rhs"]) < 1e-25 * largest(one["rhs"])
    assert lean.check().energy_error < 1e-25


def test_spatial_beam_with_tip_body_keeps_its_energy():
    """Two seconds; the reference found 1.5e-13 J, DOP853 at rtol 1e-11 leaves 1e-9 of some joules."""
    S, beam = spatial_beam(bends=2, field=2, foreshortening=False)
    eq = S.derive("recursive")
    kinetic, potential = eq.energy()
    program = eq.program({"E": kinetic + potential, "T": kinetic, "tip": beam.tip.u})
    values = {"L": 1.0, "rho": 1.0, "EI": 20.0, "m": 0.5, "I1": 0.01, "I2": 0.02, "g": 9.81}
    run = program.simulate(values, {"a": 0.2, "b": 0.3, "u": 1.0}, t_end=2.0, steps=40, rtol=1e-11, integrator="dop853")
    assert np.max(run["T"]) > 1.0
    assert np.ptp(run["E"]) < 1e-8
    assert np.max(np.abs(run["tip"])) > 1e-3


def test_mass_at_a_section_is_a_point_mass_on_the_shape():
    """A particle at x = L/2 adds m ψ_k(L/2) ψ_l(L/2) to the mass matrix of a cantilever."""
    from spacar.symbolic import beam_shapes

    S = MultibodySystem()
    L, rho, EI, m = S.parameters("L rho EI m")
    beam = S.beam("beam", S.N, S.O, L, rho, EI=EI, field=beam_shapes.monomial(2, 3), foreshortening=False)
    S.particle("bob", S.section(beam, L / 2), m)
    psi = [L**2 / 4 / L**3, L**3 / 8 / L**3]
    power = (2, 3)
    for strategy in ("held", "recursive"):
        M, _ = S.derive(strategy).explicit()
        for i in range(2):
            for j in range(2):
                uniform = rho * L ** (power[i] + power[j] + 1) / (power[i] + power[j] + 1) / L**6
                assert sp.simplify(M[i, j] - uniform - m * psi[i] * psi[j]) == 0


def test_spring_between_two_points():
    """Two masses on a line joined by a spring with damper: the textbook equations."""
    S = MultibodySystem()
    m, k, c, l = S.parameters("m k c l")
    x, _ = S.coordinate("x", speed="u")
    y, _ = S.coordinate("y", speed="v")
    P, Q = S.point("P", S.O, x * S.N[1]), S.point("Q", S.O, (l + y) * S.N[1])
    S.particle("p", P, m)
    S.particle("q", Q, m)
    S.spring(P, Q, k, length=l, damping=c)
    values = {"m": 2.0, "k": 5.0, "c": 0.3, "l": 1.0, "x": 0.1, "y": 0.4, "u": 1.5, "v": -0.5}
    for strategy in ("held", "recursive"):
        eq = S.derive(strategy)
        f = eq.program().evaluate(values)["rhs"]
        tension = 5.0 * 0.3 + 0.3 * -2.0
        assert [float(e) for e in f] == pytest.approx([tension, -tension], rel=1e-13)
        assert eq.check().energy_error < 1e-25


def test_message_names_the_constraints_of_a_parallelogram_with_a_bar_too_many():
    """Three equal parallel bars under one plate; that of a fourth, single bar is not named."""
    S = MultibodySystem()
    at = {}
    for name in ("a", "b", "c", "d", "plate"):
        q, _ = S.coordinate(f"q_{name}", speed=f"w_{name}")
        at[name] = S.frame(f"F_{name}", S.N, 3, q)
    L = S.expression("L")
    tip = S.point("Pa", S.O, L * at["a"][1])
    S.particle("m", tip, "m")
    S.constraint(S.speeds[3], name="free")
    for k, name in enumerate("bc", 1):
        ground = S.point(f"G{name}", S.O, k * L * S.N[1])
        end = S.point(f"P{name}", ground, L * at[name][1])
        S.close(end, S.point(f"Q{name}", tip, k * L * at["plate"][1]), name=name)
    program = S.derive().program()
    start = {f"q_{name}": 0.5 for name in "abc"}
    with pytest.raises(AnalysisError, match=r"constraints b_1, b_2, c_1, c_2 depend .* near t = 0 s: leave out one"):
        program.simulate({"L": 1.0, "m": 1.0}, start, t_end=1.0, steps=10)
