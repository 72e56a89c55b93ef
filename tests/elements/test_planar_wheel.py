"""PLWHEEL: derivatives of the slips (H not symmetric), and a wheel that rolls along a circle."""

import numpy as np
import pytest

from spacar.elements.family import GeometryError
from spacar.elements.planar.plwheel import PlanarWheel

from .derivatives import check_stiffness, check_strain, close, evaluate, group

N = 4


def wheels(rng):
    geometry = np.column_stack((rng.uniform(0.2, 0.5, N), rng.normal(size=(N, 2))))
    damping = rng.uniform(size=(N, 2))
    return (
        PlanarWheel(group("PLWHEEL", np.zeros((4, N)), geometry=geometry, edamp=damping)),
        geometry,
        damping,
    )


def test_derivatives():
    rng = np.random.default_rng(31)
    family, _, damping = wheels(rng)
    x, v = rng.normal(size=(2, 4, N))
    check_strain(family, x, v, rng.normal(size=(2, N)))
    check_stiffness(family)
    S, Sd = family.stiffness()
    assert not S.any()
    close(np.stack((Sd[0, 0], Sd[1, 1])), damping.T, "S_d", 0.0)


def test_slips_by_definition():
    """Complex velocity of the contact point relative to the heading (the axis turned by -90 degrees)."""
    rng = np.random.default_rng(33)
    family, geometry, _ = wheels(rng)
    x, v = rng.normal(size=(2, 4, N))
    axis = geometry[:, 1] + 1j * geometry[:, 2]
    heading = -1j * axis / abs(axis) * np.exp(1j * x[2])
    contact = (v[0] + 1j * v[1]) / heading - geometry[:, 0] * v[3]
    slip = (evaluate(family, x)[2] * v).sum(1)
    close(slip, np.stack((contact.real, contact.imag)), "slip velocities", 1e-14)


def test_axis_is_required():
    with pytest.raises(GeometryError, match="spin axis"):
        PlanarWheel(group("PLWHEEL", np.zeros((4, 1)), geometry=[(0.3, 0.0, 0.0)]))
    with pytest.raises(GeometryError, match="spin axis"):
        PlanarWheel(group("PLWHEEL", np.zeros((4, 1)), geometry=[(0.3,)]))
