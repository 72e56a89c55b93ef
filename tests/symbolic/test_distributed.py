"""Forces per length on beams: deflections of beam theory, gravity written as a load, quadrature, energy."""

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq
from scipy.special import iv, jv

from spacar.errors import InputError, UsageError
from spacar.symbolic import MultibodySystem, beam_shapes
from spacar.symbolic.beam_shapes import X
from spacar.symbolic.model_reader import read_model

STRATEGIES = ("held", "recursive")
VALUES = {"L": 1.3, "rho": 0.7, "EI": 12.0, "p": 3.0, "g": 9.81, "c": 0.4}


def cantilever(field, load, **options):
    S = MultibodySystem()
    beam = S.beam("beam", S.N, S.O, "L", "rho", EI="EI", field=field, foreshortening=False, **options)
    S.distributed(beam, S.vector(load, S.N))
    return S, beam


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize(
    ("field", "load", "factor"),
    [(3, "p", 1 / 8), (4, "p*x/L", 11 / 120), (4, "p*(1 - x/L)", 1 / 30)],  # exact: quartics and quintics
)
def test_deflection_of_a_cantilever(strategy, field, load, factor):
    S, beam = cantilever(field, (0, load, 0))
    program = S.derive(strategy).program({"tip": beam.tip.u})
    f = program.function(VALUES)
    zero = [0.0] * (2 * field)
    upper, force = f.accel(zero, f.inputs(0.0, zero))
    M = np.zeros((field, field))
    M[np.triu_indices(field)] = upper
    M += np.triu(M, 1).T
    K = -M @ np.array(f.jac(0.0, zero))[field:, :field]
    phi = np.linalg.solve(K, force)
    (tip,) = f.outputs(0.0, [*phi, *zero[field:]])
    exact = factor * VALUES["p"] * VALUES["L"] ** 4 / VALUES["EI"]
    assert tip == pytest.approx(exact, rel=1e-11)


def arm(load=None, gravity=True, **options):
    S = MultibodySystem(gravity=(0, "-g", 0) if gravity else (0, 0, 0))
    q, _ = S.coordinate("q", speed="s")
    B = S.frame("B", S.N, 3, q)
    beam = S.beam("beam", B, S.point("P", S.O, S.expression("c") * B[1]), "L", "rho", EI="EI", field=2, **options)
    if load:
        S.distributed(beam, load(S, B))
    return S, beam


@pytest.mark.parametrize("strategy", [pytest.param("held", marks=pytest.mark.slow), "recursive"])
def test_weight_written_as_a_load_is_gravity(strategy):
    first, _ = arm()
    second, _ = arm(lambda S, B: S.vector((0, "-rho*g", 0), S.N), gravity=False)
    y = [0.7, 0.02, -0.01, 1.2, 0.3, 0.1]
    a, b = (np.array(S.derive(strategy).program().function(VALUES)(0.0, y)) for S in (first, second))
    assert a == pytest.approx(b, rel=1e-12)


def test_both_strategies_against_quadrature_of_virtual_work():
    """∫ f·∂v/∂s dx with NumPy, positions by hand: x − w along b1, u along b2, w = ½∫u_x² (foreshortening)."""
    L, c, p = VALUES["L"], VALUES["c"], VALUES["p"]
    at, weight = np.polynomial.legendre.leggauss(12)
    x, w = L * (at + 1) / 2, L * weight / 2
    psi = [(x / L) ** 2, 6 * (x / L) ** 3 - 5 * (x / L) ** 2]
    slope = [2 * x / L**2, 18 * x**2 / L**3 - 10 * x / L**2]

    def drawn(i, j):  # ∫_0^x ψ_i' ψ_j' dξ, by quadrature from 0 to every station
        return np.array([np.sum(X / L * w * _slope(i, X * x / L, L) * _slope(j, X * x / L, L)) for X in x])

    y = np.array([0.7, 0.05, -0.02, 0.0, 0.0, 0.0])
    S, _ = arm(lambda S, B: S.vector((0, "-p*x/L", 0), S.N) + S.vector(("p", "2*p*x**2", 0), B), gravity=False)
    free, _ = arm(gravity=False)
    u = psi[0] * y[1] + psi[1] * y[2]
    S_ = [[drawn(i, j) for j in range(2)] for i in range(2)]
    short = sum(S_[i][j] * y[1 + i] * y[1 + j] for i in range(2) for j in range(2)) / 2
    b1, b2 = np.array([np.cos(y[0]), np.sin(y[0])]), np.array([-np.sin(y[0]), np.cos(y[0])])
    f = np.outer([0, -1], p * x / L) + np.outer(b1, p + 0 * x) + np.outer(b2, 2 * p * x**2)
    turn = np.outer(b2, c + x - short) - np.outer(b1, u)
    moves = [turn] + [np.outer(b2, psi[k]) - np.outer(b1, sum(S_[k][j] * y[1 + j] for j in range(2))) for k in range(2)]
    exact = [float(np.sum(w * np.sum(f * move, axis=0))) for move in moves]
    assert slope[0][0] == pytest.approx(_slope(0, x, L)[0])
    for strategy in STRATEGIES:
        with_load, without = (m.derive(strategy).program().function(VALUES).accel(y.tolist(), ())[1] for m in (S, free))
        assert np.subtract(with_load, without) == pytest.approx(exact, rel=1e-11)


def _slope(k, x, L):
    return 2 * x / L**2 if k == 0 else 18 * x**2 / L**3 - 10 * x / L**2


@pytest.mark.parametrize("strategy", [pytest.param("held", marks=pytest.mark.slow), "recursive"])
def test_power_of_a_load_that_follows_and_depends_on_speed(strategy):
    S, _ = arm(lambda S, B: S.vector(("p*x", "-c*s*x**2 + sin(t)", 0), B), bends=2)
    assert S.derive(strategy).check().error < 1e-25


TEXT = """
[parameters]
L = 1.0
rho = 1.0
EI = 1.0
p = 2.0
[[beam]]
name = "beam"
frame = "N"
root = "O"
length = "L"
mass = "rho"
EI = "EI"
field = 3
[[distributed]]
beam = "beam"
vector = [0, "-p*x*cos(t)", 0]
"""


def test_model_file(tmp_path):
    path = tmp_path / "beam.toml"
    path.write_text(TEXT)
    model = read_model(path)
    assert model.system.derive("recursive").check().error < 1e-25
    for old, new, text in (
        ('beam = "beam"\nvec', 'beam = "rod"\nvec', r"\[\[distributed\]\] 1: beam refers to \['rod'\]"),
        ("-p*x*cos(t)", "-p*sqrt(x)", "not a polynomial in x"),
        ("-p*x*cos(t)", "-p*y", "unknown name 'y'"),
    ):
        path.write_text(TEXT.replace(old, new, 1))
        with pytest.raises(InputError, match=text):
            read_model(path)
    with pytest.raises(UsageError, match="must be a vector"):
        cantilever(2, (0, 0, 0))[0].distributed(model.system.beams[0], 3)


# Beams whose mass and stiffness change along x. A wedge of constant width (ρ ∝ 1 − x/L, EI ∝ (1 − x/L)³), clamped at
# the thick end, has a closed form in Bessel functions (Kirchhoff 1882): J1(z) I2(z) + I1(z) J2(z) = 0 with z = 2 √ω
# in units L = ρ₀ = EI₀ = 1; the first frequency is ω₁ = 5.3151.
UNIT = {"L": 1.0, "rho": 1.0, "EI": 1.0}


def wedge_frequency() -> float:
    z = brentq(lambda z: jv(1, z) * iv(2, z) + iv(1, z) * jv(2, z), 4.0, 5.0, xtol=1e-14)
    return float((z / 2) ** 2)


@pytest.mark.parametrize("strategy", ["held", "recursive"])
def test_a_wedge_has_the_frequency_of_bessel_functions(strategy):
    S = MultibodySystem()
    beam = {"mass": "rho*(1 - x/L)", "EI": "EI*(1 - x/L)**3", "field": 6, "foreshortening": False}
    S.beam("wedge", S.N, S.O, "L", **beam)
    w = np.sort(np.abs(S.derive(strategy).linearize(UNIT).eigenvalues().imag))[0]
    exact = wedge_frequency()
    assert exact == pytest.approx(5.3151, abs=1e-4)  # published digits
    assert -1e-11 < w / exact - 1 < 1e-6  # from above; the error of Ritz with six polynomials


@pytest.mark.parametrize("strategy", [pytest.param("held", marks=pytest.mark.slow), "recursive"])
def test_a_swinging_tapered_beam_keeps_the_balance_of_energy(strategy):
    S = MultibodySystem(gravity=("0", "-g", "0"))
    q, _ = S.coordinate("q", speed="s")
    B = S.frame("B", S.N, 3, q)
    beam = S.beam(
        "beam", B, S.O, "L", "rho*(1 - x/(2*L))", EI="EI*(1 - tau*x/L)", bends=(2, 3), field=2, foreshortening=True,
        twist=1, GJ="GJ*(1 - x/(3*L))", polar="jp*(1 - x/(4*L))", stretch=1, EA="EA*(2 - x/L)",
    )  # fmt: skip
    S.particle("load", beam.tip, "m")
    checked = S.derive(strategy).check()
    assert checked.positive
    assert checked.error < 1e-28  # 30 digits


def test_total_mass_and_strong_form():
    S = MultibodySystem()
    L, rho, EI = S.parameters("L rho EI")
    beam = S.beam("beam", S.N, S.O, L, "rho*(1 - x/(2*L))", EI="EI*(1 - x/L)", field=2)
    assert beam.total_mass.equals(3 * rho * L / 4)
    strong = S.derive("held").strong_form(beam)
    # EI u_xx = EI0 (1 − x/L) u_xx: at the tip the moment vanishes with the stiffness, the shear force is EI0/L u_xx
    u = beam.fields[0].function
    (moment, _), (shear, _) = strong.natural
    tip = {X: L}
    assert moment.coeff(u.diff(X, 2)).subs(tip) == 0
    assert shear.expand().coeff(u.diff(X, 2)).equals(EI / L)
    assert strong.equation.doit().expand().coeff(u.diff(X, 3)).equals(-2 * EI / L)


# Frequencies of one beam by the families of shapes, against roots of the closed frequency equations. Bending of a
# uniform beam, ω = k² √(EI/ρ)/L²: free-free and clamped-clamped cos k cosh k = 1; clamped with a guided end tan k +
# tanh k = 0; hinged at both ends k = nπ. Ritz frequencies lie above the exact ones and converge to them.
def free_root(n: int) -> float:
    at = (n + 0.5) * np.pi
    return float(brentq(lambda k: np.cos(k) - 1 / np.cosh(k), at - 0.5, at + 0.5, xtol=1e-14))


def guided_root(n: int) -> float:
    at = (n - 0.25) * np.pi
    return float(brentq(lambda k: np.tan(k) + np.tanh(k), at - 0.5, at + 0.5, xtol=1e-14))


EXACT = {
    "pinned": [(n * np.pi) ** 2 for n in (1, 2)],
    "guided": [guided_root(n) ** 2 for n in (1, 2)],
    "free": [free_root(n) ** 2 for n in (1, 2)],
}
ERROR = {3: 1e-2, 5: 1e-5}  # of the first: Ritz with two and three even shapes; far above rounding
ESSENTIAL = {"pinned": ((0, 0), (0, 1)), "guided": ((0, 0), (1, 0), (1, 1)), "free": ()}  # (derivative, place)


def ritz(family: str, number: int) -> np.ndarray:
    """Frequencies in the space of polynomials that a family spans, by numbers: Legendre basis, null space, Gauss."""
    at, weight = legendre.leggauss(number + 4)
    n = number + {"pinned": 2, "guided": 3, "free": 2}[family]
    basis = [legendre.Legendre.basis(k, domain=(0, 1)) for k in range(n)]
    rows = [[p.deriv(d)(x) if d else p(x) for p in basis] for d, x in ESSENTIAL[family]]
    if family == "free":
        rows = list(np.eye(n)[:2])  # orthogonal to 1 and x
    T = null_space(np.array(rows))
    x, w = (at + 1) / 2, weight / 2
    P, Q = (np.array([p.deriv(d)(x) if d else p(x) for p in basis]) for d in (0, 2))
    K, M = (T.T @ (A * w @ A.T) @ T for A in (Q, P))
    return np.sqrt(eigh(K, M, eigvals_only=True))


@pytest.mark.parametrize(("number", "family", "strategy"), [
    pytest.param(number, family, strategy, marks=[pytest.mark.slow] * (number == 5 and strategy == "held"))
    for number in (3, 5) for family in ("pinned", "guided", "free") for strategy in ("held", "recursive")
])  # fmt: skip
def test_frequencies_of_a_family(family, strategy, number):
    S = MultibodySystem()
    L, rho, EI = S.parameters("L rho EI")
    S.beam("beam", S.N, S.O, L, rho, EI=EI, field=getattr(beam_shapes, family)(number), foreshortening=False)
    w = np.sort(np.abs(S.derive(strategy).linearize(UNIT).eigenvalues().imag))[::2]
    # rounding of stiffnesses moves the lowest by eps (highest / lowest)²; both sides, and a factor for n terms
    rounding = 10 * number * np.finfo(float).eps * (w[-1] / w[0]) ** 2
    assert w == pytest.approx(ritz(family, number), rel=rounding)
    excess = w[:2] / EXACT[family] - 1
    assert np.all(excess > -rounding)  # Ritz: from above
    assert excess[0] < ERROR[number]
