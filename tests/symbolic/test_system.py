"""The description of a system: strong forms, inputs, plots, wrong calls."""

import numpy as np
import pytest
import sympy as sp
from spacar_cli.symbolic_plot import plot

from spacar.errors import UsageError
from spacar.symbolic import MultibodySystem, beam_shapes
from spacar.symbolic.beam_shapes import X, integral
from spacar.symbolic.printing import text
from spacar.symbolic.unit_vectors import TIME


def pendulum():
    S = MultibodySystem(gravity=("0", "-g", "0"))
    q, s = S.coordinate("q", speed="s")
    m, L = S.parameters("m L")
    A = S.frame("A", S.N, 3, q)
    S.particle("bob", S.point("P", S.O, L * A[1]), m)
    return S, A, q, s


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
    ):
        with pytest.raises(UsageError, match=message):
            program.simulate(values, {"q": 0.1}, **options)
    with pytest.raises(UsageError, match="start: z is not a state"):
        program.simulate(values, {"z": 1.0}, t_end=1.0)


def test_text_of_equations_has_no_time_arguments():
    S, *_ = pendulum()
    assert text(S.derive().held[0]) == "-L*g*m*n2.a2 - L**2*m*s_dot" or "(t)" not in text(S.derive().held[0])
