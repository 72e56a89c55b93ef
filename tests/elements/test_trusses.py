"""PLTRUSS and TRUSS, and PLTOR: derivatives, and definitions coded once more."""

import numpy as np
import pytest

from spacar.elements.family import GeometryError
from spacar.elements.planar.pltor import PlanarHinge
from spacar.elements.planar.pltruss import PlanarTruss
from spacar.elements.spatial.truss import SpatialTruss

from .derivatives import check_gravity, check_inertia, check_stiffness, check_strain, close, evaluate, group, mass_of

N = 5


in_both = pytest.mark.parametrize(("kind", "word", "k"), [(PlanarTruss, "PLTRUSS", 2), (SpatialTruss, "TRUSS", 3)])


def trusses(kind, word, k):
    rng = np.random.default_rng(11)
    x0 = rng.normal(size=(2 * k, N))
    em, estiff, edamp = (rng.uniform(0.5, 2.0, (N, 1)) for _ in range(3))
    family = kind(group(word, x0, em=em, estiff=estiff, edamp=edamp))
    return family, x0, x0 + rng.normal(size=x0.shape), em[:, 0], estiff[:, 0], edamp[:, 0], rng


@in_both
def test_truss_derivatives(kind, word, k):
    family, _, x, *_, rng = trusses(kind, word, k)
    v, a = rng.normal(size=(2, 2 * k, N))
    check_strain(family, x, v, rng.normal(size=(1, N)))
    check_inertia(family, x, v, a)
    check_stiffness(family)


@in_both
def test_truss_elongation_stiffness_mass(kind, word, k):
    family, x0, x, m, EA, EdA, rng = trusses(kind, word, k)
    l, l0 = (np.linalg.norm(y[k:] - y[:k], axis=0) for y in (x, x0))
    close(evaluate(family, x)[1][0], l - l0, "e1", 1e-15)
    S, Sd = family.stiffness()
    close(S[0, 0], EA / l0, "S", 1e-15)
    close(Sd[0, 0], EdA / l0, "S_d", 1e-15)
    # kinetic energy of a linear velocity field: Simpson's rule is exact for its square
    v = rng.normal(size=(2 * k, N))
    p, q = v[:k], v[k:]
    truth = m * l0 / 12 * (p**2 + (p + q) ** 2 + q**2).sum(0)
    close(0.5 * (v[:, None] * mass_of(family, x) * v).sum((0, 1)), truth, "kinetic energy", 1e-14)
    g = np.array([0.0, -9.81, 3.0])[:k]
    close(check_gravity(family, x, g), np.tile(g, 2)[:, None] / 2 * m * l0, "weight", 1e-14)


@in_both
def test_truss_troubles_and_geometry(kind, word, k):
    x0 = np.zeros((2 * k, 2))
    x0[k : k + 2] = [[3.0], [4.0]]
    family = kind(group(word, x0))
    assert not family.has_mass
    x = x0.copy()
    x[k:, 1] = 0.0
    x[k, 1] = 3e-6
    c, e, _ = evaluate(family, x)
    (trouble,) = family.troubles(c, e, e)
    assert trouble.index == 1
    assert trouble.fatal
    x0[k:, 1] = 0.0
    with pytest.raises(GeometryError, match="length 0 m"):
        kind(group(word, x0))


def test_hinge_counts_turns():
    rng = np.random.default_rng(12)
    family = PlanarHinge(group("PLTOR", np.zeros((2, N)), estiff=rng.uniform(size=(N, 1))))
    x = np.stack((np.arange(N) * 4.0, np.arange(N) * -9.0))
    check_strain(family, x, rng.normal(size=(2, N)), rng.normal(size=(1, N)))
    check_stiffness(family)
    close(evaluate(family, x)[1][0], np.arange(N) * -13.0, "e1", 0.0)
    assert not family.has_mass
