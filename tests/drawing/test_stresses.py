"""Stress resultants and stresses against equilibrium and textbook formulas."""

import numpy as np
import pytest
from spacar_drawing.mechanism_picture import Extras
from spacar_drawing.picture_source import source_of_result
from spacar_drawing.sections import inside, moments, rectangle_twist_stress
from spacar_drawing.settings import SectionShape
from spacar_drawing.stress_picture import stress_still
from spacar_drawing.stresses import GRID, Resultants, along, resultants, stress_field

import spacar
from spacar.deck import parse_deck

from .models import result_source

ALL_SECTIONS = [
    SectionShape("RECT", (0.3, 0.2)), SectionShape("RECTHOL", (0.3, 0.2, 0.26, 0.16)), SectionShape("CIRC", (0.25,)),
    SectionShape("CIRCHOL", (0.25, 0.2)), SectionShape("I", (0.1, 0.2, 0.01, 0.02)),
]  # fmt: skip


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
    assert source.scene.elements[1].number not in source.scene.bars


@pytest.mark.parametrize("section", ALL_SECTIONS, ids=lambda s: s.shape)
def test_moments_of_sections_by_integration(section):
    """Sum over a fine grid of the points inside; tolerance: the width of a cell over the size."""
    m, size = moments(section), max(section.dims)
    line = ((np.arange(1200) + 0.5) / 1200 - 0.5) * size
    y, z = np.meshgrid(line, line)
    within = inside(section, y, z) * (size / 1200) ** 2
    np.testing.assert_allclose([m.A, m.Iy, m.Iz], [np.sum(f * within) for f in (1.0, z**2, y**2)], rtol=5e-3)


@pytest.mark.parametrize(("w", "h"), [(0.3, 0.2), (0.2, 0.3), (1.0, 0.1)])
def test_twist_stress_carries_the_torque(w, h):
    """Integral of y tau_xz - z tau_xy over the section is the torque 1: midpoint rule, 30 terms of the series."""
    n = 200
    y, z = np.meshgrid(((np.arange(n) + 0.5) / n - 0.5) * w, ((np.arange(n) + 0.5) / n - 0.5) * h)
    ty, tz = rectangle_twist_stress(w, h, y, z)
    assert abs(np.sum(y * tz - z * ty) * w * h / n**2 - 1) < 1e-3


@pytest.mark.parametrize("section", ALL_SECTIONS, ids=lambda s: s.shape)
def test_von_mises_of_simple_loads(section):
    m = moments(section)
    half_y, half_z = 0.5 * section.dims[0], 0.5 * section.dims[0 if section.shape.startswith("CIRC") else 1]
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
    assert not inside(SectionShape("LINE"), np.zeros(1), np.zeros(1)).any()


def bent_cantilever(kind, extra, n, load):
    """0.5 m along x of n elements, clamped; positions are nodes 1 + 3k, orientations 2 + 3k, warping 3 + 3k."""
    planar, warped = kind == "PLBEAM", kind == "BEAMW"
    lines = [f"X {1 + 3 * k} {0.5 * k / n!r} 0." + ("" if planar else " 0.") for k in range(n + 1)]
    for k in range(n):
        nodes = [1 + 3 * k, 2 + 3 * k, *[3 + 3 * k] * warped, 4 + 3 * k, 5 + 3 * k, *[6 + 3 * k] * warped]
        lines.append(f"{kind} {k + 1} {' '.join(map(str, nodes))}" + ("" if planar else " 0. 1. 0."))
    lines += ["FIX 1", "FIX 2", *["FIX 3"] * warped, *[f"DYNX {6 + 3 * k}" for k in range(n * warped)]]
    lines += [f"DYNE {k + 1} {m}" for k in range(n) for m in range(1, 4 if planar else 7)]
    lines += [f"{word} {k + 1}" for word in extra.split() for k in range(n)]
    stiffness = "1e5 8." if planar else "1e5 4. 6. 20. 0.002 0.001" + (" 0.01" if warped else "")
    lines += ["END", "HALT", *[f"ESTIFF {k + 1} {stiffness}" for k in range(n)], *[f"EM {k + 1} 1." for k in range(n)]]
    lines += [f"XF {1 + 3 * n} {' '.join(map(str, load[: 2 if planar else 3]))}"]
    lines += [f"XF {2 + 3 * n} " + ("0.5" if planar else "0.8 0.3 0.5"), "ITERSTEP 20 5 1e-10", "END", "END", ""]
    return "\n".join(lines)


@pytest.mark.parametrize("n", [4, 64])
def test_shear_forces_at_a_clamp_under_torque(n):
    """40 N along y and 4 N m about the beam: at the clamp Qy = 40, Qz = 0 however fine the mesh is."""
    text = f"""
X 1 0 0 0   X 3 0.2 0 0   FIX 1   FIX 2   BEAM 1 1 2 3 4 0 1 0   RLSE 1   DYNX 3   DYNX 4
SECTION s RECT .02 .002   MATERIAL m 2.1e11 0.3 7800   BEAMSEC 1 s m {n}   END HALT
XF 3 0 40 0   XF 4 4 0 0   XM 3 1.   XM 4 .1 0 0 .1 0 .1   ITERSTEP 20 6 1e-9   END END
"""
    result = spacar.run(7, parse_deck(text, mode=7))
    scene = source_of_result(result).scene
    r = resultants(scene, scene.elements[0], result["sig"][-1], result["e"][-1], 2)
    np.testing.assert_allclose([r.N[0], r.Qy[0], r.Qz[0]], [0.0, 40.0, 0.0], atol=0.01)


def orientation(result, node, planar):
    """Columns: the axes of a node."""
    if planar:
        c, s = np.cos(a := float(result.node(node, 1)[-1])), np.sin(a)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    a, *v = (float(result.node(node, k)[-1]) for k in range(1, 5))
    across = np.cross(np.eye(3), v)  # of v, as a matrix
    return np.eye(3) + 2 * a * across + 2 * (np.outer(v, v) - np.dot(v, v) * np.eye(3))


@pytest.mark.parametrize(
    ("kind", "extra"),
    [("BEAM", ""), ("BEAM", "ADEFORM"), ("BEAM", "LDEFORM"), ("BEAM", "ADEFORM LDEFORM"), ("BEAMW", ""), ("PLBEAM", ""),
     ("PLBEAM", "ADEFORM")],
)  # fmt: skip
def test_section_forces_are_those_of_equilibrium(kind, extra):
    """A cantilever under a dead force and a moment at its end: every section carries that force, along its own axes.
    The formulas are those of small rotations within an element: errors of order h at least."""
    load = np.array([3.0, 40.0, 2.0])
    worst = []
    for n in (4, 16):
        text = bent_cantilever(kind, extra, n, load)
        result = spacar.run(7, parse_deck(text, mode=7))
        source = source_of_result(result)
        error = 0.0
        for element in source.scene.elements:
            r = resultants(source.scene, element, result["sig"][-1], result["e"][-1], 2)
            for k, node in enumerate((element.p_turn, element.q_turn)):
                axes = orientation(result, node, kind == "PLBEAM")
                expected = axes.T @ (load * [1, 1, kind != "PLBEAM"])
                error = max(error, float(np.abs([r.N[k], r.Qy[k], r.Qz[k]] - expected).max()))
        worst.append(error)
    assert worst[1] < 0.06  # of 40 N, where the differences of the end moments are 4 N off
    assert worst[1] < 0.5 * worst[0]


def test_a_truss_is_coloured_with_its_own_section():
    """Two bars on one line: 0.06 m high as TRUSSVIS says, and not as the beams are (BEAMVIS) or a thin line."""
    deck = parse_deck("""PLTRUSS 1 1 2   PLTRUSS 2 2 3   X 1 0. 0.   X 2 1. 0.   X 3 2. 0.   FIX 1   FIX 3   FIX 2 2
        DYNE 1   RLSE 2   END HALT   ESTIFF 1 1e6   ESTIFF 2 1e6   EM 1 1.   EM 2 1.   XF 2 100. 0.   END END
VISUALIZATION
TRUSSVIS 0.06 0.04
BEAMVIS 0.02 0.02
""")
    source = source_of_result(spacar.run(7, deck))
    figure = stress_still(source, 1, Extras(), "N")
    heights = [np.ptp(path.vertices[:, 1]) for faces in figure.axes[0].collections for path in faces.get_paths()]
    assert np.isclose(heights, 0.06, rtol=1e-9).sum() >= 2 * 16  # pieces of a bar
    assert not np.isclose(heights, 0.02, rtol=1e-9).any()
