"""PLTRUSS and PLTOR: derivatives, and definitions coded with complex numbers."""

from __future__ import annotations

import numpy as np
import pytest

from spacar.elements.family import GeometryError
from spacar.elements.planar.pltor import PlanarHinge
from spacar.elements.planar.pltruss import PlanarTruss
from tests.elements.derivatives import (
    check_gravity,
    check_inertia,
    check_stiffness,
    check_strain,
    close,
    evaluate,
    group,
    mass_of,
)

N = 5


def trusses():
    rng = np.random.default_rng(11)
    x0 = rng.normal(size=(4, N))
    em, estiff, edamp = (rng.uniform(0.5, 2.0, (N, 1)) for _ in range(3))
    family = PlanarTruss(group("PLTRUSS", x0, em=em, estiff=estiff, edamp=edamp))
    return family, x0, x0 + rng.normal(size=x0.shape), em[:, 0], estiff[:, 0], edamp[:, 0], rng


def test_truss_derivatives():
    family, _, x, *_, rng = trusses()
    v, a = rng.normal(size=(2, 4, N))
    check_strain(family, x, v, rng.normal(size=(1, N)))
    check_inertia(family, x, v, a)
    check_stiffness(family)


def test_truss_elongation_stiffness_mass():
    family, x0, x, m, EA, EdA, rng = trusses()
    l, l0 = (abs((y[2] - y[0]) + 1j * (y[3] - y[1])) for y in (x, x0))
    close(evaluate(family, x)[1][0], l - l0, "e1", 1e-15)
    S, Sd = family.stiffness()
    close(S[0, 0], EA / l0, "S", 1e-15)
    close(Sd[0, 0], EdA / l0, "S_d", 1e-15)
    # kinetic energy of a linear velocity field: Simpson's rule is exact for its square
    v = rng.normal(size=(4, N))
    p, q = v[0] + 1j * v[1], v[2] + 1j * v[3]
    truth = m * l0 / 12 * (abs(p) ** 2 + abs(p + q) ** 2 + abs(q) ** 2)
    close(0.5 * (v[:, None] * mass_of(family, x) * v).sum((0, 1)), truth, "kinetic energy", 1e-14)
    close(
        check_gravity(family, x, [0.0, -9.81])[[1, 3]], -9.81 / 2 * m * l0 * np.ones((2, 1)), "weight", 1e-14
    )


def test_truss_troubles_and_geometry():
    x0 = np.tile([[0.0], [0.0], [3.0], [4.0]], (1, 2))
    family = PlanarTruss(group("PLTRUSS", x0))
    assert not family.has_mass
    x = x0.copy()
    x[2:, 1] = 3e-6, 0.0
    c, e, _ = evaluate(family, x)
    (trouble,) = family.troubles(c, e, e)
    assert trouble.index == 1
    assert trouble.fatal
    x0[2:, 1] = 0.0
    with pytest.raises(GeometryError, match="PLTRUSS has length 0 m"):
        PlanarTruss(group("PLTRUSS", x0))


def test_hinge_counts_turns():
    rng = np.random.default_rng(12)
    family = PlanarHinge(group("PLTOR", np.zeros((2, N)), estiff=rng.uniform(size=(N, 1))))
    x = np.stack((np.arange(N) * 4.0, np.arange(N) * -9.0))
    check_strain(family, x, rng.normal(size=(2, N)), rng.normal(size=(1, N)))
    check_stiffness(family)
    close(evaluate(family, x)[1][0], np.arange(N) * -13.0, "e1", 0.0)
    assert not family.has_mass
