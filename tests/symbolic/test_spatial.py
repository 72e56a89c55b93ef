"""Beams in space: two bending directions, torsion, stretch, foreshortening, sections with bodies, springs."""

import random

import numpy as np
import pytest
import sympy as sp

from spacar.symbolic import MultibodySystem


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
