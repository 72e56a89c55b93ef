"""The two-link manipulator: accelerations (the paper's (8)), equations derived without vectors, strategies, counts."""

import random

import mpmath as mp
import pytest
import sympy as sp
from sympy.core.function import AppliedUndef

from spacar.symbolic.beam_shapes import X
from spacar.symbolic.held import HeldDerivation
from spacar.symbolic.reference_frames import dvdt
from spacar.symbolic.unit_vectors import TIME, UnevaluatedDot

from .systems import gauss

VARIANTS = [{}, {"reaction": "root", "boundary": False}]


def _state(program):
    """Random values for parameters, states and inputs; deflections of a few percent."""
    chance = random.Random(3)
    return {s.name: chance.uniform(0.3, 1.3) for s in [*program.parameters, *program.state, *program.inputs]}


def oracle(values, boundary=True, root=False, digits=40):
    """I and f in complex numbers, r1 = e^{ia}(x + iu), r2 = e^{ia}(L + iU) + e^{ib}(x + iu), by Gauss quadrature.

    Lagrange's equations of the discretized system:
    I_ij = ∫ρ Re(∂_i r* ∂_j r), f_i = −∫ρ Re(∂_i r* r̈(q̇, q̇)) − ∂V/∂q_i + Q_i.
    Seven Gauss points integrate the polynomials (degree at most 8) exactly.
    """
    with mp.workdps(digits):
        v = {k: mp.mpf(x) for k, x in values.items()}
        L, rho, EI, gam, g = (v[k] for k in ("L", "rho", "EI", "gam", "g"))
        points = [(L * x, L * h) for x, h in gauss(7)]
        psi = [lambda x, n=n: x**n / L**4 for n in (2, 3, 4)]
        slope = [lambda x, n=n: n * x ** (n - 1) / L**4 for n in (2, 3, 4)]
        bend = [lambda x, n=n: n * (n - 1) * x ** (n - 2) / L**4 for n in (2, 3, 4)]
        q = [v["q1"], v["q4"], *(v[f"phi{i}_{k}"] for i in (1, 2) for k in (1, 2, 3))]
        s = [v["s1"], v["s4"], *(v[f"dphi{i}_{k}"] for i in (1, 2) for k in (1, 2, 3))]
        U, Ud = (sum(c * p(L) for c, p in zip(z[2:5], psi, strict=False)) for z in (q, s))
        S, Sd = (sum(c * p(L) for c, p in zip(z[2:5], slope, strict=False)) for z in (q, s))
        ea, eb = mp.expj(q[0]), mp.expj(q[0] + S + q[1])
        da, db = s[0], s[0] + Sd + s[1]
        I, f = mp.matrix(8, 8), mp.matrix(8, 1)
        for x, w in points:
            for link in (1, 2):
                own = slice(3 * link - 1, 3 * link + 2)
                u, ud = (sum(c * p(x) for c, p in zip(z[own], psi, strict=True)) for z in (q, s))
                A, Ad = (x + 1j * u, 1j * ud) if link == 1 else (L + 1j * U, 1j * Ud)
                D = [ea * 1j * A] + [0] * 7
                bias = ea * (-(da**2) * A + 2j * da * Ad)
                if link == 1:
                    D[2:5] = [ea * 1j * p(x) for p in psi]
                else:
                    C = x + 1j * u
                    D = [ea * 1j * A + eb * 1j * C, eb * 1j * C]
                    D += [ea * 1j * p(L) + eb * 1j * C * d(L) for p, d in zip(psi, slope, strict=False)]
                    D += [eb * 1j * p(x) for p in psi]
                    bias += eb * (-(db**2) * C + 2j * db * 1j * ud)
                for i in range(8):
                    f[i] -= w * rho * (mp.conj(D[i]) * (bias + 1j * g)).real
                    for j in range(8):
                        I[i, j] += w * rho * (mp.conj(D[i]) * D[j]).real
                for k in range(3):
                    i = 3 * link - 1 + k
                    f[i] -= w * EI * bend[k](x) * sum(c * b(x) for c, b in zip(q[own], bend, strict=True))
                    rates = s[i - k : i - k + 3]
                    if boundary:
                        f[i] -= w * 2 * gam * slope[k](x) * sum(c * d(x) for c, d in zip(rates, slope, strict=False))
                    else:
                        f[i] += w * 2 * gam * psi[k](x) * sum(c * b(x) for c, b in zip(rates, bend, strict=False))
        f[0] += v["Ta1"]
        f[1] += v["Ta2"]
        if root:  # the motor reacts on frame B1: its torque also works on u_xt(L)
            for k in range(3):
                f[2 + k] += v["Ta2"] * slope[k](L)
        return I, f


@pytest.mark.parametrize(
    ("strategy", "variant"),
    [
        *((strategy, VARIANTS[0]) for strategy in ("held", "recursive")),
        ("recursive", VARIANTS[1]),
        pytest.param("held", VARIANTS[1], marks=pytest.mark.slow),
    ],
)
def test_equations_equal_lagrange_in_complex_numbers(programs, strategy, variant):
    """All 64 + 8 entries at 30 digits: 40-digit arithmetic leaves 1e-33 of the largest entry."""
    program = programs(strategy, **variant)
    values = _state(program)
    numbers = program.evaluate(values, 40)
    I, f = oracle(values, variant.get("boundary", True), variant.get("reaction") == "root", 50)
    size = max(abs(x) for x in I), max(abs(x) for x in f)
    with mp.workdps(50):
        error = max(abs(mp.mpf(numbers["mass"][i, j]) - I[i, j]) for i in range(8) for j in range(8))
        assert error < size[0] * mp.mpf("1e-33")
        assert max(abs(mp.mpf(numbers["rhs"][i]) - f[i]) for i in range(8)) < size[1] * mp.mpf("1e-33")


def test_accelerations_of_the_mass_points_are_equation_8(arm):
    """Term by term: coefficients of b11, b12, b21, b22 of the acceleration of a mass point of beam 2."""
    system, link1, link2 = arm().system, arm().link1, arm().link2
    N, rates = system.N, system.rates
    velocity = link2.root.velocity + dvdt(N, link2.offset).xreplace(rates)
    a = dvdt(N, velocity).xreplace(rates)
    name = {str(s.func): s for s in [*system.speeds, *(p.speed for p in system.pseudo)]}
    acc = {k: system.accelerations[s] for k, s in name.items()}
    s1, s2p, s3p, s4 = (name[k] for k in ("s1", "link1_uxt", "link1_ut", "s4"))
    d1, d2p, d3p, d4 = (acc[k] for k in ("s1", "link1_uxt", "link1_ut", "s4"))
    q3, L, u, w, wd = link1.tip.u, link1.length, link2.fields[0].function, s1 + s2p + s4, d1 + d2p + d4
    B1, B2 = link1.frame, link2.frame
    expected = {
        B1[1]: -(2 * s1 * s3p + d1 * q3 + L * s1**2),
        B1[2]: d3p + L * d1 - q3 * s1**2,
        B2[1]: -(2 * w * u.diff(TIME) + wd * u + X * w**2),
        B2[2]: u.diff(TIME, 2) + X * wd - u * w**2,
    }
    for unit, value in expected.items():
        assert sp.expand(a.coefficient(unit) - value) == 0
    assert len(a.terms) == 4


def test_first_equation_is_held_in_six_dots(arm):
    """n2·b1i, n2·b2i and b1i·b2j; the transformed equation has none and three joint angles."""
    eq = arm().equations("held")
    dots = {str(d) for d in eq.held[0].atoms(UnevaluatedDot)}
    assert dots == {"n2.b11", "n2.b12", "n2.b21", "n2.b22", *(f"b1{i}.b2{j}" for i in (1, 2) for j in (1, 2))}
    after = eq.transform()[0]
    assert not after.atoms(UnevaluatedDot)
    assert len({f.args[0] for f in after.atoms(sp.sin, sp.cos)}) == 3  # q1, u_x(L) + q4 and their sum


def test_mass_matrix_is_symmetric_before_it_is_assumed(arm):
    """The held equations give both triangles: −∂E_i/∂ṡ_j = −∂E_j/∂ṡ_i for ordinary and pseudo-speeds."""
    system = arm().system
    steps = HeldDerivation(system)
    wrenches = steps.wrenches()
    speeds = [system.speeds[0], system.speeds[1], *(p.speed for p in system.pseudo[:2])]
    E = {s: steps.table.expand(steps.ordinary(wrenches, s)) for s in speeds}
    from spacar.symbolic.transform import transform

    for i, s in enumerate(speeds):
        for r in speeds[:i]:
            difference = E[s].diff(system.accelerations[r]) - E[r].diff(system.accelerations[s])
            plain = transform(difference)
            atoms = {*plain.free_symbols, *plain.atoms(AppliedUndef)} - {TIME}
            values = {a: sp.Float(random.Random(str(a)).uniform(0.3, 1), 40) for a in atoms}
            assert abs(sp.N(plain.xreplace(values), 40)) < 1e-35


def test_deriving_twice_gives_the_same_text(arm):
    texts = [arm().program("recursive").text("c") for _ in range(2)]
    assert texts[0] == texts[1]


def test_energy_balance_and_positive_mass(arm):
    """dE/dt by the chain rule equals the power of torques and damping to the 30 digits computed."""
    for strategy in ("held", "recursive"):
        check = arm().equations(strategy).check()
        assert check.positive
        assert check.energy_error < 1e-27


@pytest.mark.slow
def test_printed_model_violates_no_balance_but_the_boundary(arm):
    """Damping without its boundary term is still a power in the balance: the check holds, the sign is the slip."""
    assert arm(reaction="root", boundary=False).equations("recursive").check().energy_error < 1e-27


def test_operation_counts(programs, arm):
    """Not above the counts of the reference by more than 10 percent (symbolic.md 4.4): 915 held, 402 recursive."""
    held, lean = programs("held").counts(), programs("recursive").counts()
    assert held["step"] <= 915 * 1.1
    assert lean["step"] <= 402 * 1.1
    assert lean["step"] < held["step"]


def test_rigid_limit_is_the_double_pendulum(arm):
    """No field: the textbook double pendulum of two uniform rods, as a symbolic identity."""
    system = arm(number=0).system
    q1, q4 = system.coordinates
    s1, s4 = system.speeds
    L, rho, g, T1, T2 = sp.symbols("L rho g Ta1 Ta2", real=True)
    m = rho * L
    c = sp.cos(q4)
    I = sp.Matrix([[m * L**2 * (sp.Rational(5, 3) + c), 0], [0, m * L**2 / 3]])
    I[0, 1] = I[1, 0] = m * L**2 * (sp.Rational(1, 3) + c / 2)
    h = m * L**2 * sp.sin(q4) / 2
    f = sp.Matrix([
        h * (2 * s1 * s4 + s4**2) - m * g * L * (sp.Rational(3, 2) * sp.cos(q1) + sp.cos(q1 + q4) / 2) + T1,
        -h * s1**2 - m * g * L * sp.cos(q1 + q4) / 2 + T2,
    ])  # fmt: skip
    for strategy in ("held", "recursive"):
        M, rhs = system.derive(strategy).explicit()
        assert all(sp.simplify(sp.expand_trig(e)) == 0 for e in M - I)
        assert all(sp.simplify(sp.expand_trig(e)) == 0 for e in rhs - f)
