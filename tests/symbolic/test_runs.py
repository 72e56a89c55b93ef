"""Simulated motions against the reference numbers of symbolic.md, section 8.5, and the checks of section 8.4."""

import numpy as np
import pytest
import sympy as sp

from spacar.symbolic import TIME, MultibodySystem, beam_shapes

# t, q1, q4, u1(L), u2(L); computed with a collocation method of order 12 and DOP853 (reference, 8.5)
R0 = """0.05 -0.45876508254 0.41846053775 -5.1531542131e-03 -1.2641516391e-03
0.1 -0.40592745322 0.32293387286 -4.2058766686e-03 -1.0705386860e-03
0.2 -0.28323586712 0.18993503224 -2.5508178912e-03 -6.5972567190e-04
0.5 0.12042788611 0.05755248932 7.3462280003e-04 1.2905337553e-04
1 0.53062544792 0.06981209148 1.4118647492e-03 3.0746731132e-04
2 0.51011368299 0.00537340225 -2.0044531804e-04 -4.5128241641e-05
3 0.49489839551 -0.00205313014 1.0602065733e-05 2.3925476100e-06
5 0.49982301871 -0.00008814276 -1.6918577e-06 -3.7622749e-07
10 0.49999995362 -0.00000002323 -4.54e-10 -1.01e-10
20 0.5 0 0 0
40 0.5 0 0 0"""
R1 = """0.05 -0.46713113438 0.41944996678 -5.8590232830e-03 -1.2344449676e-03
0.1 -0.43622494787 0.31993377927 -5.8480974598e-03 -1.2259379860e-03
0.2 -0.38799736853 0.16473049292 -5.8759127556e-03 -1.1490831762e-03
0.5 -0.31000722743 -0.08606486002 -5.8977958449e-03 -1.0461903943e-03
1 -0.26445050190 -0.20486213597 -5.8055951959e-03 -9.7469598398e-04
2 -0.24725830478 -0.23065611332 -5.8111057539e-03 -9.6452019698e-04
3 -0.24800838748 -0.23225837765 -5.8133854236e-03 -9.6429142838e-04
5 -0.24780838885 -0.23222441118 -5.8129264616e-03 -9.6420735899e-04
10 -0.24780184406 -0.23222150979 -5.8128932147e-03 -9.6420133278e-04
20 -0.24780184509 -0.23222151035 -5.8128932289e-03 -9.6420133569e-04
40 -0.24780184509 -0.23222151035 -5.8128932289e-03 -9.6420133569e-04"""
E1 = """0.05 -0.47219219301 0.41647041312 -8.1330776018e-04 -1.6837454953e-04
0.2 -0.39058676690 0.16364402675 -8.2143841490e-04 -1.6076713342e-04
0.5 -0.30969884247 -0.08594191043 -8.2624435558e-04 -1.4670465325e-04
1 -0.26465554706 -0.20530232141 -8.1770404479e-04 -1.3766363387e-04
3 -0.24919861722 -0.23316477058 -8.1842064687e-04 -1.3609321425e-04
10 -0.24903760387 -0.23314625298 -8.1834626869e-04 -1.3607795204e-04
40 -0.24903760436 -0.23314625328 -8.1834627020e-04 -1.3607795236e-04"""
H0 = """0.1 -0.48659727215 0.47168106065 -3.6488445826e-03 1.9808898758e-03
0.5 -0.31529658967 0.04030517057 -5.8716929286e-03 -1.7523590389e-03
1 -0.10666417625 -0.35732900207 -5.0869110538e-03 -2.1616895204e-03
2 0.11006007232 -0.14738396002 -2.2235120690e-03 -1.9515231472e-04
5 0.96224782135 0.19479745978 4.3491151039e-03 9.4489696599e-04
10 0.31657468196 -0.08009142773 -2.1710366064e-03 -4.6720006549e-04
20 0.65337833271 0.06296568292 9.0787936326e-04 1.9716790451e-04
40 0.53955654157 0.01789086164 4.7212973687e-04 1.0497228405e-04"""
PL = """0.1 -0.4386007556 0.3188554309 -3.45159602e-03 -1.18755114e-03
0.5 -0.3034596259 -0.0972022063 -1.41419619e-02 2.30040711e-02
1 -0.2698626594 -0.2349856032 -3.18426848e-03 -4.28366661e-03"""

CASES = {
    "R0": (R0, {"g": 0.0}), "R1": (R1, {}), "E1": (E1, {"EI": 14568.099896}),
    "H0": (H0, {"g": 0.0, "rho": 2.612898 * 9.80665 / 0.3048}),
}  # fmt: skip
SCALE = {"q1": 1.0, "q4": 1.0} | {f"phi{i}_{k}": 1e-2 for i in (1, 2) for k in (1, 2, 3)}
SCALE |= {name.replace("q", "s").replace("phi", "dphi"): 10 * value for name, value in SCALE.items()}


def table(text):
    return np.array([[float(x) for x in line.split()] for line in text.splitlines()])


def compare(run, rows, q_error, u_error):
    got = np.column_stack([run[name][1:] for name in ("q1", "q4", "tip1", "tip2")])
    assert np.max(np.abs(got - rows[:, 1:])[:, :2]) < q_error
    assert np.max(np.abs(got - rows[:, 1:])[:, 2:]) < u_error


def simulate(program, values, rows, rtol, **options):
    times = np.concatenate(([0.0], rows[:, 0]))
    given = {"atol": {name: rtol * scale for name, scale in SCALE.items()}} | options
    if given["atol"] is None:  # that of the program
        del given["atol"]
    return program.simulate(values, {"q1": -0.5, "q4": 0.5}, t_end=times[-1], at=times, rtol=rtol, **given)


@pytest.mark.parametrize("t_end", [3.0, pytest.param(40.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("case", ["R0", "R1", *(pytest.param(c, marks=pytest.mark.slow) for c in ("E1", "H0"))])
def test_reference_motion(programs, arm, case, t_end):
    """8 digits of the largest values at all times; at rtol 1e-11 the error grows to 3e-9 over 40 s (H0 swings on)."""
    text, change = CASES[case]
    rows = table(text)
    rows = rows[rows[:, 0] <= t_end]
    run = simulate(programs("recursive"), arm().values | change, rows, 1e-11)
    compare(run, rows, 5e-9, 1e-10)


@pytest.mark.slow
def test_held_program_runs_the_same_motion(programs, arm):
    rows = table(R1)[:6]
    compare(simulate(programs("held"), arm().values, rows, 1e-10), rows, 2e-9, 2e-10)


@pytest.mark.parametrize("t_end", [2.0, pytest.param(40.0, marks=pytest.mark.slow)])
def test_default_tolerances_and_integrators(programs, arm, t_end):
    """Every integrator with the exact Jacobian: error of q below a hundred times the tolerance (reference 8.6)."""
    rows = table(R1)
    rows = rows[rows[:, 0] <= t_end]
    for integrator, rtol in (("lsoda", 1e-8), ("radau", 1e-5)):
        run = simulate(programs("recursive"), arm().values, rows, rtol, integrator=integrator, atol=None)
        assert np.max(np.abs(run["q1"][1:] - rows[:, 1])) < 300 * rtol
        assert run.statistics["integrator"] == integrator


@pytest.mark.slow
def test_printed_equations_shake(programs, arm):
    """PL: both slips of the printed example; 4.6e3 rad/s and 38 mm. 7 digits at t <= 1."""
    rows, program = table(PL), programs("recursive", reaction="root", boundary=False)
    compare(simulate(program, arm().values, rows, 1e-11, atol=1e-15, integrator="dop853"), rows, 5e-8, 5e-9)


def test_spectra_at_rest(arm):
    """R0: slowest pair −1.6465 ± 2.5i and massless hubs −6.41e4; printed equations: +31.9 ± 4684i (unstable)."""
    values = arm().values | {"g": 0.0}
    good = arm().equations("recursive").linearize(values, {"q1": 0.5})
    w = good.eigenvalues()
    assert w[0] == pytest.approx(-1.6465 - 2.5098j, abs=1e-3) or w[0] == pytest.approx(-1.6465 + 2.5098j, abs=1e-3)
    assert w[-1].real == pytest.approx(-6.41e4, rel=1e-3)
    assert np.max(w.real) < -1.6
    assert np.allclose(good.M0, good.M0.T, rtol=0, atol=0)
    bad = arm(reaction="root", boundary=False).equations("recursive").linearize(values, {"q1": 0.5})
    worst = bad.eigenvalues()[np.argmax(bad.eigenvalues().real)]
    assert worst.real == pytest.approx(31.9, abs=0.1)
    assert abs(worst.imag) == pytest.approx(4684, abs=1)


# -- one beam ----------------------------------------------------------------------------------------------------


def cantilever(field, rate=None, **options):
    """A beam whose root is fixed, or turns at a given constant rate (a parameter Omega)."""
    S = MultibodySystem()
    L, rho, EI = S.parameters("L rho EI")
    frame = S.N if rate is None else S.frame("B", S.N, 3, rate)
    S.beam("beam", frame=frame, root=S.O, length=L, mass=rho, EI=EI, field=field, **{"foreshortening": False} | options)
    return S


UNIT = {"L": 1.0, "rho": 1.0, "EI": 1.0}
FREQUENCIES = {
    2: (3.5327315427, 34.80689311), 3: (3.5170760638, 22.2333620625, 118.1444361253),
    4: (3.5160206804, 22.1578314075, 63.3465835416), 6: (3.5160152688, 22.0347977912, 61.7162928160),
}  # fmt: skip


@pytest.mark.parametrize("terms", [2, 3, 4, pytest.param(6, marks=pytest.mark.slow)])
@pytest.mark.parametrize("family", [lambda n: beam_shapes.monomial(*range(2, 2 + n)), lambda n: n])
def test_cantilever_frequencies(terms, family):
    """Polynomial spaces are equal, so monomials and orthogonal polynomials give one set of frequencies.

    Tolerance: the eight decimals that are given, and n eps cond(M) of the mass matrix in units in which its diagonal
    is one: what rounding its entries does to the eigenvalues (cond is 1 for orthogonal shapes, 1e9 for 6 monomials).
    """
    linear = cantilever(family(terms)).derive("recursive").linearize(UNIT)
    w = np.sort(np.abs(linear.eigenvalues().imag))[::2]
    size = 1 / np.sqrt(linear.M0.diagonal())
    rounding = terms * np.finfo(float).eps * np.linalg.cond(linear.M0 * np.outer(size, size))
    assert w[: len(FREQUENCIES[terms])] == pytest.approx(FREQUENCIES[terms], rel=2e-10 + rounding)


def test_cantilever_modes_as_shapes():
    """Quadrature of exact modes: the exact frequencies, 3.516015268, 22.03449156."""
    linear = cantilever(beam_shapes.cantilever(2)).derive("recursive").linearize(UNIT)
    w = np.sort(np.abs(linear.eigenvalues().imag))[::2]
    assert w == pytest.approx([3.5160152685, 22.0344915647], rel=1e-10)


def _rotating(field, foreshortening):
    """The lowest ω² as a function of Ω."""
    S = cantilever(field, rate=sp.Symbol("Omega", real=True) * TIME, foreshortening=foreshortening)
    eq = S.derive("recursive")

    def lowest(Omega):
        linear = eq.linearize(UNIT | {"Omega": Omega})
        return float(np.min(np.real(np.linalg.eigvals(np.linalg.solve(linear.M0, linear.K0)))))

    return lowest


@pytest.mark.slow
def test_rotating_beam_without_and_with_foreshortening():
    """ω² = ω1² − Ω² exactly for the paper's beam; with foreshortening (ω² − ω1²)/Ω² = +0.1930 … 0.180."""
    w1 = 3.5170760638**2
    plain, shortened = _rotating(beam_shapes.monomial(2, 3, 4), False), _rotating(4, True)
    for Omega in (0.5, 2.0, 3.6):
        assert plain(Omega) == pytest.approx(w1 - Omega**2, abs=2e-8)
    assert plain(3.6) < 0  # unstable above Ω = ω1
    for Omega, ratio in ((0.5, 0.1930), (3.6, 0.180)):
        gain = (shortened(Omega) - 3.5160152685**2) / Omega**2
        assert gain == pytest.approx(ratio, abs=1e-3)


@pytest.mark.slow
def test_stiff_limit(programs, arm):
    """E·10^k: q1(1) − rigid = 2.41e-4, 2.56e-5, 2.57e-6 for k = 0, 1, 2 (R1 data)."""
    start = {"q1": -0.5, "q4": 0.5}
    rigid = programs("recursive", number=0).simulate(arm().values, start, t_end=1.0, steps=1, rtol=1e-11)["q1"][-1]
    for k, expected in enumerate((2.41e-4, 2.56e-5, 2.57e-6)):
        values = arm().values | {"EI": arm().values["EI"] * 10**k}
        atol = {name: 1e-8 * scale / 10**k for name, scale in SCALE.items()}
        run = programs("recursive").simulate(
            values, start, t_end=1.0, steps=1, rtol=1e-8, atol=atol, integrator="radau"
        )
        assert run["q1"][-1] - rigid == pytest.approx(expected, rel=5e-3)
