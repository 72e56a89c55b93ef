"""PLBELT: derivatives, belt length from tangent points, gears over several turns, energy of the span."""

import numpy as np
import pytest
from scipy.optimize import brentq

from spacar.elements.family import GeometryError
from spacar.elements.planar.plbelt import PlanarBelt

from .derivatives import check_gravity, check_inertia, check_stiffness, check_strain, close, evaluate, group, mass_of

RADII = np.array([[0.5, 0.3], [0.3, 0.5], [-0.4, -0.2], [0.3, -0.4], [-0.2, 0.3], [0.25, 0.25]])
N = len(RADII)


def belts(seed: int = 41):
    rng = np.random.default_rng(seed)
    x0 = np.zeros((6, N))
    x0[[0, 1]] = rng.normal(size=(2, N))
    angle = rng.uniform(-3, 3, N)
    x0[3], x0[4] = x0[0] + 2 * np.cos(angle), x0[1] + 2 * np.sin(angle)
    em, estiff, edamp = rng.uniform(0.5, 2.0, (N, 3)), rng.uniform(size=(N, 1)), rng.uniform(size=(N, 1))
    family = PlanarBelt(group("PLBELT", x0, geometry=RADII, em=em, estiff=estiff, edamp=edamp))
    return family, x0, x0 + 0.3 * rng.normal(size=x0.shape), em, rng


@pytest.mark.parametrize("seed", range(3))
def test_derivatives(seed):
    family, _, x, _, rng = belts(seed)
    v, a = rng.normal(size=(2, 6, N))
    check_strain(family, x, v, rng.normal(size=(1, N)))
    check_inertia(family, x, v, a)
    check_stiffness(family)
    check_gravity(family, x, [1.0, -9.81])


def span(x, k):
    """Start, end and direction (complex) of the common tangent of both circles, found as a root."""
    p, q = x[0, k] + 1j * x[1, k], x[3, k] + 1j * x[4, k]
    r_p, r_q = RADII[k]
    base = np.angle(q - p)

    def slope(angle):  # the tangent points are r times the normal away from the centres
        normal = 1j * np.exp(1j * angle)
        return (((q + r_q * normal) - (p + r_p * normal)) * normal.conjugate()).real

    u = np.exp(1j * brentq(slope, base - 1.5, base + 1.5, xtol=1e-15))
    return p + 1j * r_p * u, q + 1j * r_q * u, u


def test_elongation_by_definition():
    """Longer span + belt wound off: the tangent point moves on the rim, the rim turns. brentq: 1e-15 rad."""
    family, x0, x, _, _ = belts()
    e = evaluate(family, x)[1][0]
    for k in range(N):
        (a0, b0, u0), (a, b, u) = span(x0, k), span(x, k)
        turn = np.angle(u / u0)
        wound_off = RADII[k, 0] * (x[2, k] - turn) - RADII[k, 1] * (x[5, k] - turn)
        close(e[k], abs(b - a) - abs(b0 - a0) + wound_off, f"e1 of belt {k}", 1e-14)


def test_planetary_gear_over_several_turns():
    """Sun fixed, carrier at beta: the planet turns by beta (1 - r_p/r_q); steps of 0.7 rad."""
    family, x0, _, _, _ = belts()
    d, rho = (x0[3] - x0[0]) + 1j * (x0[4] - x0[1]), RADII[:, 0] - RADII[:, 1]
    # a wound cable: only the carrier moves, the elongation accumulates
    for planet, elongation in ((1.0 - RADII[:, 0] / RADII[:, 1], 0.0 * rho), (0.0, -rho)):
        branch = np.zeros((1, N))
        for beta in np.arange(0.0, 20.0, 0.7):
            x, z = x0.copy(), d * np.exp(1j * beta)
            x[3], x[4], x[5] = x0[0] + z.real, x0[1] + z.imag, beta * planet
            e = evaluate(family, x, branch)[1]
            branch = family.branch(x, e)
            close(e[0], elongation * beta, f"e1 at {beta}", 5e-14)


def test_mass_is_kinetic_energy_of_the_span():
    """Velocity linear between the rims at the tangent points (Simpson is exact), and the wound parts."""
    family, x0, x, em, rng = belts()
    v = rng.normal(size=(6, N))
    energy = 0.5 * (v[:, None] * mass_of(family, x) * v).sum((0, 1))
    for k in range(N):
        a0, b0, _ = span(x0, k)
        a, b, _ = span(x, k)
        ends = []
        for place, node in ((a, 0), (b, 3)):
            centre = x[node, k] + 1j * x[node + 1, k]
            ends.append(v[node, k] + 1j * v[node + 1, k] + 1j * v[node + 2, k] * (place - centre))
        m = em[k, 0]
        p, q = ends
        truth = m * abs(b0 - a0) / 12 * (abs(p) ** 2 + abs(p + q) ** 2 + abs(q) ** 2)
        for node, r, wound in zip((0, 3), abs(RADII[k]), em[k, 1:3], strict=True):
            speed = v[node, k] ** 2 + v[node + 1, k] ** 2 + (r * v[node + 2, k]) ** 2
            truth += 0.5 * m * r * wound * speed
        close(energy[k], truth, f"kinetic energy of belt {k}", 1e-13)


def test_limits():
    x0 = np.zeros((6, 2))
    x0[3] = 1.0
    radii = [(0.3, -0.4)] * 2
    family = PlanarBelt(group("PLBELT", x0, geometry=radii))
    assert not family.has_mass
    x = x0.copy()
    x[3, 1] = 0.69
    with np.errstate(invalid="ignore"):
        c, e, _ = evaluate(family, x)
    (trouble,) = family.troubles(c, e, e)
    assert trouble.index == 1
    assert trouble.fatal
    assert "0.7 m" in trouble.text
    with pytest.raises(GeometryError, match=r"no straight span: .* 0.69 m"):
        PlanarBelt(group("PLBELT", x, geometry=radii))
