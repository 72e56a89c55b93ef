"""PLWHEEL: derivatives of the slips (H not symmetric), and a wheel that rolls along a circle."""

import numpy as np
import pytest

from spacar.elements.family import GeometryError
from spacar.elements.planar.plwheel import PlanarWheel

from .derivatives import check_stiffness, check_strain, close, evaluate, group, written

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


def test_H_is_not_symmetric():
    rng = np.random.default_rng(32)
    family, _, _ = wheels(rng)
    x, v = rng.normal(size=(2, 4, N))
    c = evaluate(family, x)[0]
    H1 = written(family.gradient_rate, (2, 4, N), float, c, v)
    H2 = written(family.gradient_transport, (2, 4, N), float, c, v)
    assert np.abs(H1[:, [0, 1, 3]]).max() == 0.0  # only the yaw turns the heading
    assert np.abs(H2[:, 2:]).max() == 0.0
    assert np.abs(H1 - H2).max() > 0.1
    close((H1 * v).sum(1), (H2 * v).sum(1), "both give H(v,v)", 1e-14)


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


def test_rolling_along_a_circle():
    """Radius R, yaw rate w, spin w R/r: no slip at any time, so V a + H(v,v) = 0 with a centripetal."""
    r, R, w = 0.3, 2.0, 1.7
    family = PlanarWheel(group("PLWHEEL", np.zeros((4, N)), geometry=[(r, 0.0, 1.0)] * N))
    phi = np.linspace(0.0, 5.0, N)
    c, s = np.cos(phi), np.sin(phi)
    x = np.stack((R * s, -R * c, phi, R / r * phi))
    v = np.stack((R * w * c, R * w * s, w + 0 * phi, w * R / r + 0 * phi))
    a = np.stack((-R * w * w * s, R * w * w * c, 0 * phi, 0 * phi))
    configuration, _, V = evaluate(family, x)
    close((V * v).sum(1), np.zeros((2, N)), "slip", 1e-15)
    H = written(family.convective_strain, (2, N), float, configuration, v)
    close((V * a).sum(1) + H, np.zeros((2, N)), "slip acceleration", 1e-14)


def test_axis_is_required():
    with pytest.raises(GeometryError, match="spin axis"):
        PlanarWheel(group("PLWHEEL", np.zeros((4, 1)), geometry=[(0.3, 0.0, 0.0)]))
    with pytest.raises(GeometryError, match="spin axis"):
        PlanarWheel(group("PLWHEEL", np.zeros((4, 1)), geometry=[(0.3,)]))
