"""PLTUBE: derivatives, the beam as a special case, flow forces from an energy (unstable pipes: tests/dynamics)."""

import numpy as np
import pytest
import sympy

from spacar.elements.family import GeometryError
from spacar.elements.planar.plbeam import PlanarBeam
from spacar.elements.planar.pltube import PlanarTube

from .derivatives import check_inertia, check_stiffness, check_strain, close, evaluate, group, mass_of

N = 4


def tubes(seed: int = 51):
    rng = np.random.default_rng(seed)
    x0 = np.zeros((6, N))
    x0[[0, 1, 3, 4]] = rng.normal(size=(4, N))
    geometry = rng.uniform(-0.6, 0.6, (N, 2))
    em = rng.uniform(0.5, 2.0, (N, 6))
    em[:, 4] = 0, 1, 2, 3
    estiff, edamp = rng.uniform(0.1, 1.0, (N, 3)), rng.uniform(0.1, 1.0, (N, 2))
    values = {"em": em, "estiff": estiff, "edamp": edamp}
    family = PlanarTube(group("PLTUBE", x0, geometry=geometry, **values))
    return family, x0, x0 + 0.3 * rng.normal(size=x0.shape), geometry, values, rng


@pytest.mark.parametrize("seed", range(3))
def test_derivatives(seed):
    family, x0, x, _, _, rng = tubes(seed)
    v, a = rng.normal(size=(2, 6, N))
    check_strain(family, x, v, rng.normal(size=(3, N)))
    check_inertia(family, x, v, a, lagrange=False)
    check_inertia(family.with_flow(np.zeros(N)), x, v, a)
    check_stiffness(family)
    close(evaluate(family, x0)[1], np.zeros((3, N)), "e at the start", 1e-14)  # a few ulp of lengths up to 4


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
    v = rng.normal(size=(6, N))
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
    for k in range(N):
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
