"""PLPINBOD and PLRBEAM: derivatives; e from rotations as complex numbers; energy of the rigid rod."""

import numpy as np
import pytest

from spacar.elements.family import GeometryError
from spacar.elements.planar.plpinbod import PlanarPinbody
from spacar.elements.planar.pltor import PlanarHinge
from spacar.elements.planar.pltruss import PlanarTruss
from spacar.elements.spatial.truss import SpatialTruss

from .derivatives import check_gravity, check_inertia, check_stiffness, check_strain, close, evaluate, group, mass_of

N = 5
DIRECTIONS = (None, (1.0, 2.0), None, (1.0, 0.0, 1.0, 1.0), None)
PROJECTIONS = (None, None, (0.5,), None, (0.25, -0.5))


def start(seed: int = 21):
    rng = np.random.default_rng(seed)
    x0 = rng.normal(size=(5, N))
    x0[2] = 0.0
    return x0, x0 + rng.normal(size=x0.shape), rng


def complex_plane(x):
    return (x[3] - x[0]) + 1j * (x[4] - x[1])


@pytest.mark.parametrize("keyword", ["PLPINBOD", "PLRBEAM"])
def test_derivatives(keyword):
    x0, x, rng = start()
    em, estiff, edamp = (rng.uniform(0.5, 2.0, (N, 2)) for _ in range(3))
    values = {"em": em, "estiff": estiff, "edamp": edamp}
    family = PlanarPinbody(group(keyword, x0, directions=DIRECTIONS, projections=PROJECTIONS, **values))
    v, a = rng.normal(size=(2, 5, N))
    check_strain(family, x, v, rng.normal(size=(2, N)))
    check_inertia(family, x, v, a)
    check_stiffness(family)
    S, Sd = family.stiffness()
    close(np.stack((S[0, 0], S[1, 1], Sd[0, 0], Sd[1, 1])), np.vstack((estiff.T, edamp.T)), "S, S_d", 0.0)


@pytest.mark.parametrize("keyword", ["PLPINBOD", "PLRBEAM"])
def test_deformations_by_definition(keyword):
    """The vector p-q turned back by phi: its components minus those at the start."""
    x0, x, _ = start()
    family = PlanarPinbody(group(keyword, x0, directions=DIRECTIONS, projections=PROJECTIONS))
    z0, back = complex_plane(x0), complex_plane(x) * np.exp(-1j * x[2])
    axis = z0 / abs(z0) if keyword == "PLRBEAM" else np.ones(N, complex)
    axis[1] = (1 + 2j) / abs(1 + 2j)
    second = 1j * axis
    axis[3], second[3] = 1.0, 1 + 1j  # four numbers are taken as they are

    def components(z):
        return np.stack(((z * axis.conj()).real, (z * second.conj()).real))

    d = components(z0)
    d[0, 2], d[:, 4] = 0.5, (0.25, -0.5)
    e0 = evaluate(family, x0)[1]
    close(e0[:, [0, 1, 3]], np.zeros((2, 3)), "e at the start", 1e-15)
    close(evaluate(family, x)[1], components(back) - d, "e", 1e-14)


def test_mass_is_exact_for_a_rigid_rod():
    """A rod that rotates about its centre has the energy m l0^3/24 omega^2, plus J l0/2 omega^2."""
    x0, x, rng = start()
    em = rng.uniform(0.5, 2.0, (N, 2))
    family = PlanarPinbody(group("PLRBEAM", x0, em=em))
    z, omega = complex_plane(x0), rng.normal(size=N)
    v = np.zeros((5, N))
    v[3] = -0.5 * omega * z.imag
    v[4] = 0.5 * omega * z.real
    v[0:2], v[2] = -v[3:5], omega
    truth = (em[:, 0] * abs(z) ** 3 / 24 + em[:, 1] * abs(z) / 2) * omega**2
    close(0.5 * (v[:, None] * mass_of(family, x) * v).sum((0, 1)), truth, "kinetic energy", 1e-14)
    weight = check_gravity(family, x, [3.0, -9.81])
    close(weight[1] + weight[4], -9.81 * em[:, 0] * abs(z), "weight", 1e-14)
    assert not PlanarPinbody(group("PLRBEAM", x0)).has_mass


def test_impossible_geometry():
    x0 = np.zeros((5, 2))
    x0[3, 0] = 1.0
    PlanarPinbody(group("PLPINBOD", x0))  # q in p: the directions are the global axes
    PlanarPinbody(group("PLRBEAM", x0, directions=(None, (1.0, 0.0))))
    with pytest.raises(GeometryError, match="PLRBEAM has length 0 m") as error:
        PlanarPinbody(group("PLRBEAM", x0))
    assert error.value.index == 1
    with pytest.raises(GeometryError, match="length zero"):
        PlanarPinbody(group("PLPINBOD", x0, directions=((0.0, 0.0), None)))
    with pytest.raises(GeometryError, match="parallel"):
        PlanarPinbody(group("PLPINBOD", x0, directions=((1.0, 1.0, 2.0, 2.0), None)))


# PLTRUSS and TRUSS, and PLTOR: derivatives, and definitions coded once more.
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
