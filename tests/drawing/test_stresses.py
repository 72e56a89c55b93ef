"""Stress resultants and stresses against equilibrium and textbook formulas."""

import numpy as np
import pytest
from spacar_drawing.sections import moments, rectangle_torsion, rectangle_twist_stress
from spacar_drawing.settings import SectionShape
from spacar_drawing.stresses import GRID, Resultants, along, resultants, stress_field

from .models import result_source

ALL_SECTIONS = [
    SectionShape("RECT", (0.3, 0.2)),
    SectionShape("RECTHOL", (0.3, 0.2, 0.26, 0.16)),
    SectionShape("CIRC", (0.25,)),
    SectionShape("CIRCHOL", (0.25, 0.2)),
]


def only(**values):
    return Resultants(**{k: np.array([values.get(k, 0.0)]) for k in ("N", "Qy", "Qz", "T", "My", "Mz")})


def test_moment_of_the_bent_cantilever_is_force_times_arm():
    """plbeam5: Mz at every node = -14 N times the horizontal distance to the tip; equilibrium of the deformed beam,
    exact in the theory, so to the tolerance of the static solution (5e-7 relative)."""
    source = result_source("plbeam5", 7)
    scene, x, sig, e = source.scene, source.x(1), source.get("sig", 1), source.get("e", 1)
    tip = x[scene.lnp[10, 0] - 1]
    for element in scene.elements:
        r = resultants(scene, element, sig, e, 2)
        arms = [tip - x[scene.lnp[n - 1, 0] - 1] for n in (element.p, element.q)]
        np.testing.assert_allclose(r.Mz, -14 * np.array(arms), atol=1e-4)


def test_spatial_cantilever_has_the_textbook_resultants():
    """lateral4: unit force along -z at the tip of 1 m: Qz = -1, My = 1 - x (My = -EIy w''), nothing else."""
    source = result_source("lateral4", 8)
    scene = source.scene
    for element in scene.elements:
        r = resultants(scene, element, source.get("sig", 1), source.get("e", 1), 2)
        arms = 1 - np.array([0.25 * (element.number - 1), 0.25 * element.number])
        np.testing.assert_allclose(r.My, arms, atol=1e-9)
        np.testing.assert_allclose(r.Qz, -1.0, atol=1e-9)
        for zero in (r.N, r.Qy, r.T, r.Mz):
            np.testing.assert_allclose(zero, 0.0, atol=1e-9)


def test_hinges_have_no_resultants():
    source = result_source("finger", 0)
    assert resultants(source.scene, source.scene.elements[1], np.zeros(20), np.zeros(20), 3) is None


@pytest.mark.parametrize("section", ALL_SECTIONS, ids=lambda s: s.shape)
def test_moments_of_sections_by_integration(section):
    """Sum over a fine grid of the points inside; tolerance: the width of a cell over the size."""
    m = moments(section)
    n = 1200
    size = max(section.dims)
    line = (np.arange(n) + 0.5) / n * size - size / 2
    y, z = np.meshgrid(line, line)
    d = section.dims
    if section.shape.startswith("RECT"):
        inside = (abs(y) < d[0] / 2) & (abs(z) < d[1] / 2)
        if section.shape == "RECTHOL":
            inside &= ~((abs(y) < d[2] / 2) & (abs(z) < d[3] / 2))
    else:
        inside = (np.hypot(y, z) < d[0] / 2) & (np.hypot(y, z) > (d[1] / 2 if len(d) > 1 else 0))
    cell = (size / n) ** 2
    np.testing.assert_allclose(
        [m.A, m.Iy, m.Iz], [inside.sum() * cell, (z**2 * inside).sum() * cell, (y**2 * inside).sum() * cell], rtol=5e-3
    )


def test_torsion_constant_of_rectangles():
    """Published values of beta in It = beta a b^3: 0.1406 for a square, 0.2287 for 2:1, 1/3 for thin strips."""
    assert abs(rectangle_torsion(1, 1) - 0.1406) < 5e-5
    assert abs(rectangle_torsion(2, 1) / 2 - 0.2287) < 5e-5
    assert abs(rectangle_torsion(0.01, 1.0) / 0.01**3 - 1 / 3) < 3e-3


@pytest.mark.parametrize(("w", "h"), [(0.3, 0.2), (0.2, 0.3), (1.0, 0.1)])
def test_twist_stress_carries_the_torque(w, h):
    """Integral of y tau_xz - z tau_xy over the section is the torque 1: midpoint rule, 30 terms of the series."""
    n = 200
    y, z = np.meshgrid(((np.arange(n) + 0.5) / n - 0.5) * w, ((np.arange(n) + 0.5) / n - 0.5) * h)
    ty, tz = rectangle_twist_stress(w, h, y, z)
    assert abs(np.sum(y * tz - z * ty) * w * h / n**2 - 1) < 1e-3


def test_largest_twist_stress_of_a_square():
    """Published: tau_max = T/(0.2082 a^3), in the middle of a side."""
    ty, tz = rectangle_twist_stress(1.0, 1.0, np.array([0.5, 0.0]), np.array([0.0, 0.5]))
    assert abs(abs(tz[0]) - 1 / 0.2082) < 0.05
    assert abs(abs(ty[1]) - 1 / 0.2082) < 0.05


@pytest.mark.parametrize("section", ALL_SECTIONS, ids=lambda s: s.shape)
def test_von_mises_of_simple_loads(section):
    m = moments(section)
    half_y, half_z = 0.5 * section.dims[0], 0.5 * section.dims[1 if section.shape.startswith("RECT") else 0]
    assert np.isclose(along("mises", only(N=5.0), section)[0], 5.0 / m.A)
    assert np.isclose(along("mises", only(Mz=2.0), section)[0], 2.0 * half_y / m.Iz)
    assert np.isclose(along("mises", only(My=2.0), section)[0], 2.0 * half_z / m.Iy)
    assert np.isclose(along("normal", only(N=-5.0), section)[0], -5.0 / m.A)
    mises = along("mises", only(T=1.0), section)[0]
    assert np.isclose(mises, np.sqrt(3) * along("shear", only(T=1.0), section)[0])


def test_signs_of_bending_stress():
    """Mz = EI w_y'' > 0 bends towards +y: +y is compressed; My = -EI w_z'' > 0: +z is stretched."""
    section = SectionShape("RECT", (0.3, 0.2))
    normal, _ = stress_field(section, only(Mz=1.0))
    corners = normal[0].reshape(GRID, GRID)  # rows z, columns y
    assert corners[0, -1] < 0 < corners[0, 0]
    normal, _ = stress_field(section, only(My=1.0))
    corners = normal[0].reshape(GRID, GRID)
    assert corners[0, 0] < 0 < corners[-1, 0]


def test_circle_under_shear_and_torque():
    """4/3 Q/A in the middle; 16 T/(pi d^3) at the rim."""
    section = SectionShape("CIRC", (0.2,))
    assert np.isclose(along("shear", only(Qy=1.0), section)[0], 4 / 3 / (np.pi * 0.01))
    assert np.isclose(along("shear", only(T=1.0), section)[0], 16 / (np.pi * 0.2**3))


def test_no_stress_without_a_section():
    assert along("mises", only(N=1.0), None) is None
    assert along("mises", only(N=1.0), SectionShape("LINE")) is None
    assert along("N", only(N=1.0), None)[0] == 1.0
