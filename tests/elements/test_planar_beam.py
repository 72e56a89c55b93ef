"""PLBEAM against its definition by integrals, complex steps, and printed digits of the manual (bibliography.md)."""

from functools import cache

import numpy as np
import pytest
import sympy

import spacar
from spacar.elements.family import GeometryError
from spacar.elements.planar.plbeam import PlanarBeam
from spacar.elements.planar.pltube import PlanarTube
from tests.examples import DATA

from .derivatives import check_gravity, check_inertia, check_stiffness, check_strain, close, evaluate, group, mass_of

N = 6
GAUSS, WEIGHTS = (np.polynomial.legendre.leggauss(5)[0] + 1) / 2, np.polynomial.legendre.leggauss(5)[1] / 2


def random_beams(seed: int, **values):
    rng = np.random.default_rng(seed)
    x0 = np.zeros((6, N))
    x0[[0, 1, 3, 4]] = rng.normal(size=(4, N))
    settings = {
        "em": rng.uniform(0.5, 2.0, (N, 2)),
        "estiff": rng.uniform(0.1, 2.0, (N, 3)),
        "edamp": rng.uniform(0.1, 2.0, (N, 2)),
        "nonlinear": [True, True, False, True, True, True],
        **values,
    }
    x = x0 + 0.4 * rng.normal(size=x0.shape)
    x[2::3] += 5.0  # far from zero: a rotation of everything
    c, s = np.cos(5.0), np.sin(5.0)
    for k in (0, 3):
        x[k], x[k + 1] = c * x[k] - s * x[k + 1], s * x[k] + c * x[k + 1]
    return PlanarBeam(group("PLBEAM", x0, **settings)), x0, x, rng


@pytest.mark.parametrize("seed", range(4))
def test_derivatives(seed):
    family, _, x, rng = random_beams(seed)
    v, a = rng.normal(size=(2, 6, N))
    check_strain(family, x, v, rng.normal(size=(3, N)))
    check_inertia(family, x, v, a)
    check_stiffness(family)
    check_gravity(family, x, np.array([1.0, -9.81]))


@cache
def shortening():
    """Q/l0 as a polynomial in the end slopes p, q of the line, with phi: Timoshenko beam between its ends, by SymPy.

    Rotation of the section theta quadratic, w' = theta + gamma, EI theta'' = -GAk gamma, w = 0 at both ends.
    """
    xi, a, b, c, gamma, phi, p, q = sympy.symbols("xi a b c gamma phi p q")
    theta = a + b * xi + c * xi**2
    slope = theta + gamma
    solution = sympy.solve(
        [
            theta.subs(xi, 0) - p,
            theta.subs(xi, 1) - q,
            sympy.integrate(slope, (xi, 0, 1)),
            sympy.diff(theta, xi, 2) * phi / 12 + gamma,
        ],
        [a, b, c, gamma],
        dict=True,
    )[0]
    Q = sympy.integrate(slope.subs(solution) ** 2, (xi, 0, 1)) / 2
    return sympy.lambdify((phi, p, q), sympy.factor(Q), "numpy")


def test_deformations_by_definition():
    """e from angles (arctan2) and the shortening from the differential equation of the beam."""
    shear = np.random.default_rng(7).uniform(0.1, 2.0, N)
    family, x0, x, _ = random_beams(7, estiff=np.outer(shear, [0, 0, 1]))
    _, e, _ = evaluate(family, x)
    d0, d = x0[3:5] - x0[0:2], x[3:5] - x[0:2]
    l0 = np.hypot(*d0)
    turned = np.arctan2(d[1], d[0]) - np.arctan2(d0[1], d0[0])
    p, q = np.sin(x[2] - turned), np.sin(x[5] - turned)
    Q = [l0[k] * shortening()(12 * shear[k] / l0[k] ** 2, p[k], q[k]) for k in range(N)]
    Q[2] = 0.0  # LDEFORM
    truth = np.stack((np.hypot(*d) - l0 + np.array(Q, float), l0 * p, -l0 * q))
    close(e, truth, "e", 1e-13)


def line(x, start, l0, xi):
    """Hermite interpolation of the elastic line from its end points and unit end tangents; (2, n) at xi."""
    t = [np.stack((np.cos(x[k] + start), np.sin(x[k] + start))) * l0 for k in (2, 5)]
    p, q = x[0:2], x[3:5]
    bulge = (t[0] - (q - p)) * (1 - xi) - (t[1] - (q - p)) * xi
    return p * (1 - xi) + q * xi + xi * (1 - xi) * bulge


def test_mass_is_kinetic_energy_of_the_line():
    """v.M.v/2 against Gauss quadrature (exact for the degree 6) of the velocity by complex steps."""
    m, J = np.random.default_rng(9).uniform(0.5, 2.0, (2, N))
    family, x0, x, rng = random_beams(3, em=np.stack((m, J), axis=1))
    d0 = x0[3:5] - x0[0:2]
    start, l0 = np.arctan2(d0[1], d0[0]), np.hypot(*d0)
    v = rng.normal(size=(6, N))
    rate = [line(x + 1e-30j * v, start, l0, xi).imag / 1e-30 for xi in GAUSS]
    truth = 0.5 * m * l0 * sum(w * (r * r).sum(0) for w, r in zip(WEIGHTS, rate, strict=True))
    truth += 0.25 * J * l0 * (v[2] ** 2 + v[5] ** 2)
    close(0.5 * (v[:, None] * mass_of(family, x) * v).sum((0, 1)), truth, "kinetic energy", 1e-13)


def test_what_is_massless_does_no_mass_work():
    assert not random_beams(0, em=None)[0].has_mass
    family, _, x, rng = random_beams(0, em=np.tile([0.0, 2.0], (N, 1)))
    assert family.has_mass
    assert family.constant_mass  # rotary inertia only
    check_inertia(family, x, *rng.normal(size=(2, 6, N)))


# -- printed digits -----------------------------------------------------------------------------------------
def test_printed_buckling_loads():
    """plbeam5: printed 2.516776, 22.715, 64.798 (theory: 8 digits); frequencies: tests/drawing/test_modes.py."""
    load = np.sort(np.abs(spacar.run(8, DATA / "plbeam5buck.dat").frames[-1].matrices["lmult"]))[:3]
    np.testing.assert_allclose(load, [2.5167765, 22.714503, 64.797525], rtol=3e-8)


def test_printed_large_deflection():
    """plbeam5 with 14 N at the tip: at 3.6808, -8.4897, compliances 0.4859, 0.0633; fixes (3), (4)."""
    result = spacar.run(8, DATA / "plbeam5.dat")
    np.testing.assert_allclose([result.node(11, k)[-1] for k in (1, 2)], [3.680791, -8.489703], atol=1e-6)
    compliance = [result.frames[-1].xcompl[result.mechanism.numbering.x_index(11, k)] for k in (1, 2)]
    np.testing.assert_allclose(compliance, [0.485931, 0.063311], atol=1e-6)


@pytest.mark.parametrize(
    ("shear", "J", "compliance", "omega"),
    [(0.2495, 0.083333333333, 3.9940, [0.795645, 2.54107]), (0.0, 0.0, 1.0, [1.6168])],
)
def test_printed_short_beam(shear, J, compliance, omega):
    """shear2: guided column l = 1, EI = 1/12, m = 1; printed 3.9940, 0.795645, 2.54107 and 1.0, 1.6168."""
    rows = [("PLBEAM", 1, 1, 2, 3, 4), ("PLBEAM", 2, 3, 4, 5, 6), ("X", 3, 0.5), ("X", 5, 1.0)]
    rows += [("FIX", 1), ("FIX", 2), ("FIX", 6), ("RLSE", 1, 2, 3), ("RLSE", 2, 2, 3), ("DYNX", 3, 2), ("DYNX", 4)]
    law = [row for k in (1, 2) for row in (("EM", k, 1.0, J), ("ESTIFF", k, 0.0, 1 / 12, shear))]
    deck = spacar.Deck.build([*rows, ("DYNX", 5, 2)], law)
    place = spacar.run(8, deck).mechanism.numbering.x_index(5, 2)
    assert spacar.run(8, deck).frames[-1].xcompl[place] == pytest.approx(compliance, rel=1e-10)
    found = np.sort(2 * np.pi * spacar.run(7, deck).frequencies[-1])[: len(omega)]
    np.testing.assert_allclose(found, omega, rtol=3e-5 if shear == 0.0 else 1e-6)


# -- limits -------------------------------------------------------------------------------------------------
def test_troubles():
    x0 = np.tile(np.array([0.0, 0, 0, 2, 0, 0])[:, None], (1, 5))
    family = PlanarBeam(group("PLBEAM", x0))
    x = x0.copy()
    x[2, 1], x[5, 2], x[2, 3] = np.radians([59.0, -61.0, 110.0])
    x[3, 4] = 1e-6
    c, e, _ = evaluate(family, x)
    found = {t.index: t for t in family.troubles(c, e, np.zeros_like(e))}
    assert sorted(found) == [2, 3, 4]
    assert not found[2].fatal
    assert "end q is rotated by 61.0 degrees" in found[2].text
    assert found[3].fatal
    assert "end p is rotated by 110.0" in found[3].text
    assert "use more elements" in found[3].text
    assert found[4].fatal
    assert "length 1e-06 m" in found[4].text


def test_coinciding_nodes():
    x0 = np.tile(np.array([1.0, 2, 0, 2, 0, 0])[:, None], (1, 3))
    x0[3:5, 1] = 1.0, 2.0
    with pytest.raises(GeometryError, match=r"PLBEAM has length 0 m: both .* at \(1, 2\)") as error:
        PlanarBeam(group("PLBEAM", x0))
    assert error.value.index == 1


# PLTUBE: derivatives, the beam as a special case, flow forces from an energy (unstable pipes: tests/dynamics).
TUBES = 4


def tubes(seed: int = 51):
    rng = np.random.default_rng(seed)
    x0 = np.zeros((6, TUBES))
    x0[[0, 1, 3, 4]] = rng.normal(size=(4, TUBES))
    geometry = rng.uniform(-0.6, 0.6, (TUBES, 2))
    em = rng.uniform(0.5, 2.0, (TUBES, 6))
    em[:, 4] = 0, 1, 2, 3
    estiff, edamp = rng.uniform(0.1, 1.0, (TUBES, 3)), rng.uniform(0.1, 1.0, (TUBES, 2))
    values = {"em": em, "estiff": estiff, "edamp": edamp}
    family = PlanarTube(group("PLTUBE", x0, geometry=geometry, **values))
    return family, x0, x0 + 0.3 * rng.normal(size=x0.shape), geometry, values, rng


@pytest.mark.parametrize("seed", range(3))
def test_derivatives_of_a_tube(seed):
    family, x0, x, _, _, rng = tubes(seed)
    v, a = rng.normal(size=(2, 6, TUBES))
    check_strain(family, x, v, rng.normal(size=(3, TUBES)))
    check_inertia(family, x, v, a, lagrange=False)
    check_inertia(family.with_flow(np.zeros(TUBES)), x, v, a)
    check_stiffness(family)
    close(evaluate(family, x0)[1], np.zeros((3, TUBES)), "e at the start", 1e-14)  # a few ulp of lengths up to 4


def test_straight_tube_without_flow_is_a_beam():
    _, x0, x, _, values, _ = tubes()
    em = values["em"].copy()
    em[:, 2] = 0.0
    tube = PlanarTube(group("PLTUBE", x0, **{**values, "em": em}))
    em_beam = np.column_stack((em[:, 0] + em[:, 1], em[:, 5]))
    beam = PlanarBeam(group("PLBEAM", x0, **{**values, "em": em_beam}))
    for tube_value, beam_value in zip(evaluate(tube, x)[1:], evaluate(beam, x)[1:], strict=True):
        close(tube_value, beam_value, "e, V", 1e-15)
    close(mass_of(tube, x), mass_of(beam, x), "M", 0.0)
    close(np.array(tube.stiffness()), np.array(beam.stiffness()), "S", 0.0)


def test_curved_tube_is_a_beam_with_turned_ends():
    """Start tangents alpha: e of a beam whose ends are turned by alpha, minus its start value."""
    tube, x0, x, geometry, values, _ = tubes()
    beam = PlanarBeam(group("PLBEAM", x0, **{**values, "em": None}))
    turned = [y.copy() for y in (x, x0)]
    for y in turned:
        y[2::3] += geometry.T
    e, e0 = (evaluate(beam, y)[1] for y in turned)
    close(evaluate(tube, x)[1], e - e0, "e", 1e-14)


def test_flow_forces_from_the_kinetic_energy():
    """h of Lagrange's equations with T = integral of m r'^2/2 + mu (r' + U r_s)^2/2 (kappa on U^2), and jets.

    r is built by SymPy from the end points and tangents; four Gauss points integrate the degree 6 exactly.
    """
    family, x0, x, geometry, values, rng = tubes()
    v = rng.normal(size=(6, TUBES))
    h = family.inertia_force(evaluate(family, x)[0], v, None)
    points, weights = np.polynomial.legendre.leggauss(4)
    X, R = sympy.symbols("x0:6"), sympy.symbols("v0:6")
    known = m, mu, flow, kappa, l0, beta, *turned = sympy.symbols("m mu phi kappa l0 beta g0 g1")
    xi, U = sympy.Symbol("xi"), flow / mu
    tangents = [
        sympy.Matrix([sympy.cos(angle), sympy.sin(angle)])
        for angle in (X[2] + beta + turned[0], X[5] + beta + turned[1])
    ]
    p, q = sympy.Matrix(X[0:2]), sympy.Matrix(X[3:5])
    bulge = (l0 * tangents[0] - (q - p)) * (1 - xi) - (l0 * tangents[1] - (q - p)) * xi
    r = p * (1 - xi) + q * xi + xi * (1 - xi) * bulge
    rate, slope = r.jacobian(X) * sympy.Matrix(R), r.diff(xi) / l0
    energy = (m + mu) * rate.dot(rate) / 2 + mu * U * rate.dot(slope) + mu * kappa * U**2 / 2 * slope.dot(slope)
    momentum = sympy.Matrix([energy]).jacobian(R)
    force = l0 * (momentum.jacobian(X) * sympy.Matrix(R) - sympy.Matrix([energy]).jacobian(X).T)  # per xi
    jets = [flow * (sympy.Matrix(R[3 * k : 3 * k + 2]) + kappa * U * tangents[k]) for k in (0, 1)]
    truth = sympy.lambdify((xi, X, R, known), (force, *jets), cse=True)
    for k in range(TUBES):
        *given, condition, _ = values["em"][k]
        d = x0[3:5, k] - x0[0:2, k]
        numbers = (*given, np.hypot(*d), np.arctan2(d[1], d[0]), *geometry[k])
        sums = [truth(0.5 + 0.5 * point, x[:, k], v[:, k], numbers) for point in points]
        entering, leaving = (np.array(jet)[:, 0] for jet in sums[0][1:])
        expected = sum(weight / 2 * np.array(f)[:, 0] for weight, (f, *_) in zip(weights, sums, strict=True))
        if condition in (1, 3):
            expected[0:2] -= entering
        if condition in (2, 3):
            expected[3:5] += leaving
        close(h[:, k], expected, f"h of tube {k}", 1e-12)


def test_wrong_input():
    x0 = np.array([[0.0], [0.0], [0.0], [1.0], [0.0], [0.0]])
    with pytest.raises(GeometryError, match="without fluid mass"):
        PlanarTube(group("PLTUBE", x0, em=[[1.0, 0.0, 0.3, 1.0]]))
    with pytest.raises(GeometryError, match="end condition 5"):
        PlanarTube(group("PLTUBE", x0, em=[[1.0, 1.0, 0.3, 1.0, 5.0]]))
    tube = PlanarTube(group("PLTUBE", x0, em=[[1.0, 0.0, 0.0, 1.0]]))
    with pytest.raises(GeometryError, match="without fluid mass"):
        tube.with_flow([0.1])
