"""Mode shapes and constraints: values of the theory reference, the core's own analysis, and closed forms."""

import numpy as np
import pytest
from spacar_drawing.mechanism_picture import Extras
from spacar_drawing.mode_picture import period, swing
from spacar_drawing.mode_shapes import (
    ModeShape,
    buckling_modes,
    dynamic_columns,
    redundancy,
    suitable_factor,
    vibration_modes,
)
from spacar_drawing.picture_source import source_of_result
from spacar_drawing.sections import inside, moments, rectangle_twist_stress
from spacar_drawing.settings import SectionShape
from spacar_drawing.stress_picture import stress_still
from spacar_drawing.stresses import GRID, Resultants, along, resultants, stress_field

import spacar
from spacar.deck import parse_deck
from tests.elements.spatial_truth import rotation
from tests.examples import DATA

from .models import result_source


class Matrices:
    """A `.sbm` file in memory."""

    path = "model.sbm"

    def __init__(self, result):
        self.frames = result.frames

    def has(self, name):
        return name in self.frames[0].matrices

    def get(self, name, step):
        return self.frames[step - 1].matrices[name]

    array = get


def modes_of(name, mode, kind):
    result = spacar.run(mode, DATA / f"{name}.dat")
    source = source_of_result(result)
    return source, (vibration_modes if kind == "vibration" else buckling_modes)(source, Matrices(result), 1)


def test_frequencies_of_the_cantilever_and_one_entry_per_pair():
    """theory-planar.md section 9: 0.3551305, 2.2265953, 6.2519760 rad/s (7 digits)."""
    _, modes = modes_of("plbeam5free", 7, "vibration")
    assert len(modes) == 10
    np.testing.assert_allclose([m.value.imag for m in modes[:3]], [0.3551305, 2.2265953, 6.2519760], rtol=2e-7)
    assert all(np.isclose(np.linalg.norm(m.vector), 1.0) for m in modes)
    assert not modes[0].is_complex
    assert "f = 0.056521 Hz" in modes[0].label


def test_motion_is_the_transfer_function_times_the_vector():
    """Moving the degrees of freedom by a small amount along the vector moves x by the same amount along the motion:
    checked by the orthogonality of the modes with respect to the mass, which only holds for the right columns."""
    source, modes = modes_of("shear2", 7, "vibration")
    dx = source.get("dx", 1)[:, dynamic_columns(source.header)]
    for m in modes:
        np.testing.assert_allclose(m.motion, dx @ m.vector, atol=1e-14)
    result = spacar.run(7, DATA / "shear2.dat")
    M = result.frames[0].matrices["m0"]
    gram = np.array([[abs(np.vdot(a.vector, M @ b.vector)) for b in modes] for a in modes])
    np.testing.assert_allclose(gram - np.diag(np.diag(gram)), 0, atol=1e-9)


def test_unstable_mode_comes_first():
    """finger.dat asks for VIBRATIONMODE 1, in the manual (bibliography.md) the unstable one: 2 pi 6.3191 1/s."""
    _, modes = modes_of("finger", 7, "vibration")
    assert [m.number for m in modes] == [1, 2]
    assert np.isclose(modes[0].value.real, 2 * np.pi * 6.3191, rtol=1e-5)
    assert not modes[0].oscillates
    assert "unstable" in modes[0].label
    assert modes[1].value == 0
    assert "frequency zero" in modes[1].label
    # the zero mode keeps the distal phalanx parallel: e1 of the hinge = -2.5 times the motor angle (theory-planar.md 9)
    ratio = modes[1].vector[1] / modes[1].vector[0]
    assert np.isclose(ratio.real, -2.5, atol=1e-6)


def test_wheels_have_configuration_modes():
    """trike3v: -30.91, -5.826 and zeros (theory-planar.md: the planar twin has the same)."""
    _, modes = modes_of("trike3v", 7, "vibration")
    decaying = sorted(m.value.real for m in modes if m.value.real < -1)
    np.testing.assert_allclose(decaying, [-30.9114, -5.8262], rtol=1e-5)


def test_modes_from_matrices_where_the_analysis_stores_none():
    """Mode 9 stores no eigenvalues: they follow from its matrices, as those of mode 7."""
    source, nine = modes_of("lever", 9, "vibration")
    result = spacar.run(7, DATA / "lever.dat")
    seven = vibration_modes(source_of_result(result), Matrices(result), 1)
    np.testing.assert_allclose([m.value for m in nine], [m.value for m in seven], rtol=1e-9)
    assert "damping ratio" in nine[0].label
    assert source.scene.mode == 9


def test_buckling_of_the_guided_column():
    """theory-planar.md: 9.94384680, 40.0, 128.722820."""
    _, modes = modes_of("column2", 8, "buckling")
    np.testing.assert_allclose([m.value.real for m in modes], [9.94384680, 40.0, 128.722820], rtol=1e-8)
    assert modes[0].label.endswith("load multiplier 9.94385")


@pytest.mark.parametrize(("mode", "find"), [(7, vibration_modes), (8, buckling_modes)])
def test_a_dead_point_has_no_modes_to_draw(mode, find, monkeypatch):
    """There the transfer functions of a result are nan: pictures of it and a report ended with an internal error."""
    result = spacar.run(mode, DATA / "plbeam5buck.dat")
    source = source_of_result(result)
    assert find(source, Matrices(result), 1)
    inner = type(source).get
    monkeypatch.setattr(type(source), "get", lambda *args: np.nan * inner(*args))
    assert not find(source, Matrices(result), 1)


def test_displacement_and_automatic_factor():
    source, modes = modes_of("plbeam5free", 7, "vibration")
    x, mode = source.x(1), modes[0]
    factor = suitable_factor(source.scene, mode.motion, 10.0)
    moved = swing(mode, x, factor, 0.0)
    tip = source.scene.lnp[10, 1] - 1
    assert np.isclose(abs(moved[tip] - x[tip]), 1.2)  # 12 % of 10 m, the tip moves most
    np.testing.assert_allclose(swing(mode, x, factor, np.pi) - x, x - moved, atol=1e-12)
    still = ModeShape(1, "vibration", 1.0 + 0j, mode.vector, mode.motion)
    ends = [swing(still, x, factor, p) for p in (0.0, np.pi)]
    np.testing.assert_allclose(ends, [x, moved], atol=1e-12)  # to one side and back
    assert period(mode, x, factor, 8).shape == (8, len(x))


@pytest.mark.parametrize("name", ["crank", "trike3v", "fourbar", "robotinv", "screw"])
def test_sound_examples_have_no_over_or_under_constraints(name):
    source = result_source(name, 0)
    found = redundancy(source.scene, source.get("bigd", 1), 1.0)
    assert len(found.over) == len(found.under) == 0


def test_constraints_agree_with_the_core():
    """A square with both diagonals is over-constrained once, all six bars take part; without two bars it can move."""
    corners = [("X", 2, 1.0, 0.0), ("X", 3, 1.0, 1.0), ("X", 4, 0.0, 1.0)]
    sides = [("PLTRUSS", i + 1, a, b) for i, (a, b) in enumerate(((1, 2), (2, 3), (3, 4), (4, 1), (1, 3), (2, 4)))]
    support = [("FIX", 1), ("FIX", 2, 2)]
    source = source_of_result(spacar.run(0, spacar.Deck.build([*sides, *corners, *support])))
    found = redundancy(source.scene, source.get("bigd", 1), 1.0)
    assert (len(found.over), len(found.under)) == (1, 0)
    # self stress of a square with diagonals: sides 1, diagonals -sqrt 2, so the squares are 1:2
    share = found.over[0]
    np.testing.assert_allclose(share, [0.125] * 4 + [0.25] * 2, atol=1e-12)

    loose = source_of_result(spacar.run(0, spacar.Deck.build([*sides[:4], *corners, *support])))
    found = redundancy(loose.scene, loose.get("bigd", 1), 1.0)
    assert (len(found.over), len(found.under)) == (0, 1)
    motion = found.under[0]
    x3, x4 = (motion[loose.scene.lnp[n - 1, :2] - 1] for n in (3, 4))
    np.testing.assert_allclose(abs(x3), abs(x4), atol=1e-12)  # the upper side moves as a whole, along x
    assert abs(x3[1]) < 1e-12


# Stress resultants and stresses against equilibrium and textbook formulas.
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
    for moment, pressed, pulled in (("Mz", (0, -1), (0, 0)), ("My", (0, 0), (-1, 0))):
        normal, _ = stress_field(SectionShape("RECT", (0.3, 0.2)), only(**{moment: 1.0}))
        corners = normal[0].reshape(GRID, GRID)  # rows z, columns y
        assert corners[pressed] < 0 < corners[pulled]


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
    return rotation([result.node(node, k)[-1] for k in range(1, 5)])


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
