"""Loads, reactions, masses, gravity, axes and enlarged deflections of pictures."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spacar_drawing import draw
from spacar_drawing import symbols as marks
from spacar_drawing.bodies import beam_lines, rows_of
from spacar_drawing.drawn_shapes import Line, Mark
from spacar_drawing.element_pictures import element_shapes, span
from spacar_drawing.look import look_of
from spacar_drawing.mechanism_picture import Extras, draw_steps, series
from spacar_drawing.picture_source import source_of_result
from spacar_drawing.scene import Pose, positions, rotations
from spacar_drawing.supports import number_labels
from spacar_drawing.viewer_mesh import mesh_of

import spacar
from spacar.errors import UsageError

from .conftest import call
from .models import result_source


def total(source, kind, k):
    """Sum of forces and of moments about the origin."""
    f = marks.forces(source, kind, k)
    place = positions(source.scene, source.x(k))
    at = np.array([place[n - 1] for n in f.nodes])
    return f.force.sum(0), f.moment.sum(0) + np.cross(at, f.force).sum(0)


@pytest.mark.parametrize(("name", "mode"), [("plbeam5", 7), ("lateral4", 8), ("leafguide", 7)])
def test_loads_and_reactions_are_in_equilibrium(name, mode):
    """Statics: forces and moments about the origin vanish, in the plane and in space."""
    source = result_source(name, mode)
    k = source.steps
    sums = [total(source, kind, k) for kind in ("loads", "reactions")]
    size = max(float(np.abs(np.concatenate(s)).max()) for s in sums)
    assert size > 0.1
    np.testing.assert_allclose(sums[0][0] + sums[1][0], 0, atol=1e-6 * size)
    np.testing.assert_allclose(sums[0][1] + sums[1][1], 0, atol=1e-6 * size)


def test_moments_from_forces_on_euler_parameters():
    """f = 2 L^T M is what virtual power gives: f . dl = M . (turn), turn by the difference of two rotations."""
    rng = np.random.default_rng(7)
    lam, d = rng.normal(size=4), 1e-6 * rng.normal(size=4)
    lam /= np.linalg.norm(lam)
    d -= (d @ lam) * lam
    f = rng.normal(size=4)
    f -= (f @ lam) * lam
    turn = (Rotation.from_quat((lam + d)[[1, 2, 3, 0]]) * Rotation.from_quat(lam[[1, 2, 3, 0]]).inv()).as_rotvec()
    assert marks.moments(lam[None], f[None])[0] @ turn == pytest.approx(f @ d, rel=1e-5)


def shapes_of(name, mode, kinds, **changes):
    source = result_source(name, mode)
    source = replace(source, **changes) if changes else source
    x = source.x(source.steps)
    look = look_of(source.scene, x[None], source.settings)
    symbols = marks.Symbols.of(source, kinds, [source.steps])
    return source, look, symbols.shapes(source.steps, x, look), symbols


def test_the_load_of_the_cantilever():
    """14 N down at the end: an arrow of the full length, from the end downwards."""
    source, look, shapes, symbols = shapes_of("plbeam5", 7, ["loads"])
    (shaft,) = [s for s in shapes if isinstance(s, Line)]
    assert shaft.colour == marks.LOAD
    tip = source.x(source.steps)[source.scene.lnp[10, :2] - 1]
    np.testing.assert_allclose(shaft.points[0, :2], tip, atol=1e-12)
    head = shapes[1].corners.reshape(-1, 3)
    assert tip[1] - head[:, 1].min() == pytest.approx(marks.ARROW * look.size)
    assert symbols.legend == "loads: largest 14 N"


def test_reactions_point_at_the_support():
    _, _, shapes, symbols = shapes_of("plbeam5", 7, ["reactions"])
    assert {s.colour for s in shapes} == {marks.REACTION}
    assert symbols.legend == "reactions: largest 14 N, 51.53 N m"  # 14 N times 3.680791 m


def test_masses_are_balls_of_their_volume():
    deck = spacar.Deck.build(
        [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0, 0.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1)],
        [("EM", 1, 1.0), ("ESTIFF", 1, 1e4, 1e4), ("XM", 1, 1.0), ("XM", 3, 8.0), ("GRAVITY", 0.0, -9.81)],
    )
    source = source_of_result(spacar.run(7, deck))
    look = look_of(source.scene, source.x(), source.settings)
    symbols = marks.Symbols.of(source, ["masses", "gravity"], [1])
    shapes = symbols.shapes(1, source.x(1), look)
    sizes = [s.size for s in shapes if isinstance(s, Mark) and s.face == marks.MASS]
    np.testing.assert_allclose(sizes, [4 + 10 / 2, 4 + 10])
    (down,) = [s for s in shapes if isinstance(s, Line)]
    assert down.points[1, 1] < down.points[0, 1]
    assert symbols.legend == "masses: largest 8 kg   gravity 9.81 m/s\N{SUPERSCRIPT TWO}"


def test_local_axes_are_those_of_the_elements():
    source, look, shapes, _ = shapes_of("leafguide", 7, ["axes"])
    pose = Pose.of(source.scene, source.x(source.steps))
    shown = [e for e in source.scene.elements if source.scene.frame_p[e.number - 1].any() and e.p]
    frames = pose.frames(source.scene, rows_of(shown))
    for k, s in enumerate(shapes):
        assert s.colour == marks.AXES[k]
        axes = (s.points[:, 1] - s.points[:, 0]) / (2.2 * look.size)
        np.testing.assert_allclose(np.linalg.norm(axes, axis=1), 1.0, atol=1e-12)
        for e, axis, frame, at in zip(shown, axes, frames[:, k], s.points[:, 0], strict=True):
            if e.shape != "beam":
                np.testing.assert_allclose(axis, frame, atol=1e-12)
                continue
            line = beam_lines(source.scene, pose, [e], 1001)[0][0]  # the axes stand on it, x' along it
            np.testing.assert_allclose(at, line[300], atol=1e-9)
            tangent = (line[301] - line[299]) / np.linalg.norm(line[301] - line[299])
            if k == 0:
                np.testing.assert_allclose(axis, tangent, atol=0.01)
            else:
                assert abs(axis @ tangent) < 0.01


def test_results_of_an_earlier_version(results):
    """One sentence that says what to do, for every table that may be missing."""
    source = result_source("plbeam5", 7)
    for kinds, table in ((["masses"], "XM"), (["gravity"], "GRAV")):
        header = {k: v for k, v in source.header.items() if k != table}
        with pytest.raises(UsageError, match=f"does not hold .* \\({table.lower()}\\).*run the analysis again"):
            marks.Symbols.of(replace(source, header=header), kinds, [1])
    header = {k: v for k, v in source.header.items() if k != "X0"}
    with pytest.raises(UsageError, match="coordinates at the start"):
        marks.start_of(replace(source, header=header))


def test_unknown_kinds(results):
    wrong = call.refused("draw", results / "crank", "--symbols", "loads,forces")
    assert wrong.strip().endswith(f"--symbols forces: expected {', '.join(marks.KINDS)}, with commas between, or all")


def test_files_hold_what_symbols_need(results):
    call.done("draw", results / "plbeam5", "--symbols", "all", "--scale", 3, "-o", results / "all.png")
    call.done("draw", results / "crank", "--symbols", "reactions", "--frames", 3, "-o", results / "few.gif")


def test_deflections_are_enlarged_from_the_start():
    source = result_source("plbeam5", 7)
    x0, x = marks.start_of(source), source.x(source.steps)
    np.testing.assert_allclose(marks.magnified(source.scene, x0, x, 1.0), x, atol=1e-14)
    np.testing.assert_allclose(marks.magnified(source.scene, x0, x, 0.0), x0, atol=1e-14)
    np.testing.assert_allclose(marks.magnified(source.scene, x0, x, 3.0) - x0, 3 * (x - x0), atol=1e-13)


def test_rotations_are_enlarged_as_rotation_vectors():
    """Against SciPy's rotations, with the sign of the Euler parameters turned round as well."""
    source = result_source("leafguide", 7)
    scene, x0, x = source.scene, marks.start_of(source), source.x(source.steps)
    y = marks.magnified(scene, x0, x, 2.5)
    z = x.copy()
    rows = scene.lnp[scene.orientation_nodes - 1] - 1
    z[rows] *= -1
    np.testing.assert_allclose(rotations(scene, marks.magnified(scene, x0, z, 2.5)), rotations(scene, y), atol=1e-12)
    start, end, drawn = (rotations(scene, v)[scene.orientation_nodes - 1] for v in (x0, x, y))
    turn = (Rotation.from_matrix(end) * Rotation.from_matrix(start).inv()).as_rotvec()
    wanted = Rotation.from_rotvec(2.5 * turn) * Rotation.from_matrix(start)
    assert np.abs(turn).max() > 1e-3
    np.testing.assert_allclose(drawn, wanted.as_matrix(), atol=1e-12)


def test_the_title_says_the_scale(results):
    title = draw(results / "plbeam5", scale=50).axes[0].get_title(loc="left")
    assert title == "plbeam5   deflections \N{MULTIPLICATION SIGN} 50"
    moving = series(result_source("plbeam5", 7), Extras(title="its own", scale=50), [1], [], False)
    assert moving.pictures(0)[1] == "its own   deflections \N{MULTIPLICATION SIGN} 50"


def test_numbers_stand_at_what_is_drawn_of_their_element():
    """A bent beam and a belt: half-way along the line, not between the nodes."""
    source = result_source("finger", 7)
    pose = Pose.of(source.scene, source.x(1))
    look = look_of(source.scene, source.x(), source.settings)
    at = {s.text: s.at for s in number_labels(source.scene, pose, look, False, True)}
    for e in source.scene.elements:
        if e.shape == "belt":
            touching = span(source.scene, pose, e)[0]
            sides = np.stack((touching[1] - touching[0], at[str(e.number)] - touching[0]))[:, :2]
            assert abs(np.linalg.det(sides)) < 1e-12
    source = result_source("plbeam5", 7)
    pose = Pose.of(source.scene, source.x(source.steps))
    for label in number_labels(source.scene, pose, look_of(source.scene, source.x(), source.settings), False, True):
        e = source.scene.elements[int(label.text) - 1]
        line = beam_lines(source.scene, pose, [e], 101)[0][0]
        np.testing.assert_allclose(label.at, line[50], atol=1e-12)


SLIDING = """PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   X 3 1. 0.   X 5 1.5 0.5
FIX 1   FIX 2   FIX 5 {held}   {drive} 1 1   RLSE 2 {released}   END HALT
{stiffness}   END END
"""


@pytest.mark.parametrize(
    ("drive", "released", "held", "stiffness", "shown"),
    [
        ("INPUTE", "1", "2", "EM 2 1.", {1: "#c0272d", 2: "#c2703d"}),  # driven, free
        ("DYNE", "1", "2", "ESTIFF 1 8.\nXM 3 1.", {2: "#c2703d"}),  # a spring, though rigid in bending
        ("DYNE", "1 2 3", "1 2\nFIX 6", "ESTIFF 1 8.\nXM 3 1.", {}),  # holds nothing at all
    ],
)
@pytest.mark.parametrize("mode", [0, 7])
def test_a_released_elongation_is_drawn_as_a_slider(mode, drive, released, held, stiffness, shown):
    """A sleeve half-way along the beam, parallel to it; in the plane and, with its corners, in the page that turns."""
    text = SLIDING.format(drive=drive, released=released, held=held, stiffness=stiffness)
    deck = spacar.parse_deck(text, mode=mode)
    source = source_of_result(spacar.run(mode, deck))
    scene, x = source.scene, source.x(1)
    look, pose = look_of(scene, x[None], source.settings), Pose.of(scene, x)
    found = [s for s in element_shapes(scene, pose, look) if isinstance(s, Line) and s.layer == 4]
    assert [s.colour for s in found] == list(shown.values())
    for number, s in zip(shown, found, strict=True):
        e = scene.elements[number - 1]
        ends = pose.place[[e.p - 1, e.q - 1]]
        np.testing.assert_allclose(s.points[:4].mean(0), ends.mean(0), atol=1e-12)
        assert np.linalg.norm(np.cross(s.points[1] - s.points[0], ends[1] - ends[0])) < 1e-12
    mesh = mesh_of(scene, x[None], look)
    sleeves = mesh.owner[sum(len(elements) * n for _, elements, n in mesh.lines) :]
    assert set(shown) <= set(sleeves.tolist())


def test_numbers_keep_clear_of_the_numbers_along_the_axes():
    """A spatial picture has its ticks inside the axes: no label lies on one, nor outside of the axes."""
    source = result_source("leafguide", 7)
    figure = draw_steps(source.scene, source.x(), source.settings, Extras(node_numbers=True, element_numbers=True))
    axes = figure.axes[0]
    boxes = [(t.get_zorder(), t.get_window_extent()) for t in axes.texts]
    labels, ticks = [b for z, b in boxes if z == 30], [b for z, b in boxes if z < 30]
    assert len(labels) > 10
    assert ticks
    assert not any(a.overlaps(b) for a in labels for b in ticks)
    assert all(axes.bbox.contains(*b.min) and axes.bbox.contains(*b.max) for b in labels)
