"""Geometry of the pictures against closed forms and against the theory reference."""

from dataclasses import replace

import numpy as np
import pytest
from spacar_drawing.bodies import beam_lines, chord_axes, elastic_line, section_axes
from spacar_drawing.element_pictures import span
from spacar_drawing.look import look_of, pin_joints, places_of_hinges
from spacar_drawing.mechanism_picture import Extras, draw_steps
from spacar_drawing.scene import Pose, positions, rotations
from spacar_drawing.stage import Camera, view_angles

from spacar.errors import UsageError
from tests.elements.spatial_truth import rotation

from .models import result_source

ROUNDING = 1e-13  # a handful of operations on numbers of size 1


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


@pytest.mark.parametrize("Phi", [0.0, 0.5, 12.0])
def test_cantilever_is_the_exact_timoshenko_line(Phi):
    """Tip force F on a cantilever: w = F(3 l x^2 - x^3)/(6 EI) + F x/GAk, end rotation F l^2/(2 EI) (textbook).

    Small deflections, because the tangent of the interpolation is a unit vector: error of the order of the square.
    """
    l, EI, F = 2.0, 3.0, 1e-6
    GAk = 12 * EI / (Phi * l**2) if Phi else np.inf
    tip, turn = F * l**3 / (3 * EI) + F * l / GAk, F * l**2 / (2 * EI)
    ends = np.array([[0, 0, 0], [l, tip, 0]])
    tangents = np.array([[1, 0, 0], [1, turn, 0]])
    y = np.array([0, 1.0, 0])
    points = elastic_line(ends, tangents, l, chord_axes(ends, y, y), np.array([Phi, 0.0]), 41)
    x = points[:, 0]
    exact = F * (3 * l * x**2 - x**3) / (6 * EI) + F * x / GAk
    np.testing.assert_allclose(points[:, 1], exact, atol=1e-5 * tip, rtol=0)


def test_shear_acts_in_its_own_direction_only():
    """Phi of bending along y' must not change the line along z', and the other way round."""
    ends = np.array([[0, 0, 0], [1.0, 0.01, 0.02]])
    tangents = np.array([[1.0, 0, 0], [1.0, 0.03, -0.01]])
    y = np.array([0, 1.0, 0])
    across = chord_axes(ends, y, y)
    lines = {
        key: elastic_line(ends, tangents, 1.0, across, np.array(key), 21)
        for key in ((0.0, 0.0), (3.0, 0.0), (0.0, 3.0))
    }
    for key, same, other in (((3.0, 0.0), 1, 0), ((0.0, 3.0), 0, 1)):
        change = lines[key] - lines[0.0, 0.0]
        assert np.max(np.abs(change @ across[same])) < ROUNDING
        assert np.max(np.abs(change @ across[other])) > 1e-4


def test_elastic_line_turns_and_moves_with_the_beam():
    rng = np.random.default_rng(3)
    ends, y = rng.normal(size=(2, 3)), np.array([0, 0, 1.0])
    tangents = rng.normal(size=(2, 3))
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    Phi, R, shift = np.array([0.7, 2.0]), np.linalg.qr(rng.normal(size=(3, 3)))[0], np.array([1.0, -2.0, 0.5])
    R *= np.linalg.det(R)
    line = elastic_line(ends, tangents, 1.3, chord_axes(ends, y, y), Phi, 17)
    moved = ends @ R.T + shift
    again = elastic_line(moved, tangents @ R.T, 1.3, chord_axes(moved, R @ y, R @ y), Phi, 17)
    np.testing.assert_allclose(again, line @ R.T + shift, atol=1e-12)
    across = section_axes(line, y, y)
    for axis in across:
        np.testing.assert_allclose(np.linalg.norm(axis, axis=1), 1.0, atol=ROUNDING)
    assert np.max(np.abs(np.sum(across[0] * across[1], axis=1))) < ROUNDING


def test_deflected_cantilever_ends_in_its_nodes_with_the_right_slopes():
    """plbeam5 under 14 N (theory-planar.md section 9): the drawn line passes the tip (3.680791, -8.489703)."""
    source = result_source("plbeam5", 7)
    pose = Pose.of(source.scene, source.x(1))
    first, last = source.scene.elements[0], source.scene.elements[-1]
    points = beam_lines(source.scene, pose, [last], 33)[0][0]
    np.testing.assert_allclose(points[-1, :2], [3.680791, -8.489703], atol=5e-7)  # half of the last printed digit
    points = beam_lines(source.scene, pose, [first], 2001)[0][0]
    slope = np.diff(points[:2], axis=0)[0]
    assert abs(slope[1] / slope[0]) < 2e-3  # clamped: horizontal; the chord of 1/2000 has a slope of its order


def test_rotation_matrices_follow_the_theory():
    """R = Lambda-bar Lambda^T (theory-spatial.md section 1), for a random state of a spatial model."""
    source = result_source("trike3v", 0)
    scene = source.scene
    x = np.array(source.x(1))
    rng = np.random.default_rng(1)
    node = int(scene.orientation_nodes[2])
    lam = rng.normal(size=4)
    lam /= np.linalg.norm(lam)
    x[scene.lnp[node - 1] - 1] = lam
    np.testing.assert_allclose(rotations(scene, x)[node - 1], rotation(lam), atol=ROUNDING)


def test_planar_rotation_and_place():
    source = result_source("crank", 1, 0.035, 14)
    scene, x = source.scene, source.x(8)
    phi = x[scene.lnp[1, 0] - 1]
    np.testing.assert_allclose(rotations(scene, x)[1], turned(phi), atol=ROUNDING)
    # the crank pin is at 0.15 m times the direction of the crank
    np.testing.assert_allclose(positions(scene, x)[2], 0.15 * np.array([np.cos(phi), np.sin(phi), 0]), atol=1e-12)


def test_belt_touches_both_pulleys():
    """The straight span is tangent to both circles, and as long as l_t = sqrt(d^2 - (r_p - r_q)^2)."""
    source = result_source("fingersim", 1, 0.1, 10)
    scene = source.scene
    pose = Pose.of(scene, source.x(11))
    belts = [e for e in scene.elements if e.keyword == "PLBELT"]
    assert [scene.data[e.number - 1, :2].tolist() for e in belts] == [[-0.015, -0.015], [-0.015, -0.009]]
    for e in belts:
        tangent, radii = span(scene, pose, e)
        u = (tangent[1] - tangent[0]) / np.linalg.norm(tangent[1] - tangent[0])
        n = np.cross([0.0, 0.0, 1.0], u)
        centres = pose.place[[e.p - 1, e.q - 1]]
        for point, centre, r in zip(tangent, centres, radii, strict=True):
            assert abs((point - centre) @ u) < ROUNDING
            assert abs(np.linalg.norm(point - centre) - abs(r)) < ROUNDING
            assert (point - centre) @ n * r > 0  # positive radius: the belt is on the left
        d = np.linalg.norm(centres[1] - centres[0])
        assert abs(np.linalg.norm(tangent[1] - tangent[0]) - np.sqrt(d**2 - (radii[0] - radii[1]) ** 2)) < ROUNDING


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("robotinv", {1: (4,), 2: (4,), 3: (5,)}),  # base, shoulder, elbow
        ("trike3v", {2: (3,), 5: (6,), 8: (9,), 10: (11,), 12: (1,)}),  # wheel axles and steering head
        ("finger", {2: (3,)}),
        ("cardansimp", {1: (), 2: (), 3: (), 4: ()}),  # no positions at all: at the origin
        ("screw", {2: (3,)}),
    ],
)
def test_hinges_are_drawn_where_their_parts_meet(name, expected):
    source = result_source(name, 0)
    assert places_of_hinges(source.scene, positions(source.scene, source.x(1))) == expected


def test_pin_joints_of_planar_mechanisms():
    assert pin_joints(result_source("crank", 1, 0.035, 14).scene) == (1, 3)
    assert pin_joints(result_source("fourbar", 1).scene) == (1, 2, 3, 4)
    assert pin_joints(result_source("plbeam5", 7).scene) == ()


def test_camera_keeps_lengths_and_angles():
    """Orthographic: the axes of the picture are orthonormal, so both directions have the same scale."""
    for azimuth, elevation in ((-55, 24), (10, 80), (200, -30)):
        camera = Camera.towards(azimuth, elevation)
        axes = np.stack((camera.right, camera.up, camera.near))
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=ROUNDING)
        assert np.linalg.det(axes) > 0
    assert view_angles("xz") == (-90.0, 0.0)
    np.testing.assert_allclose(
        Camera.towards(*view_angles("xz")).project(np.array([1.0, 5.0, 2.0])), [1, 2], atol=ROUNDING
    )
    for wrong in ("front", "1", "1,2,3", "0,91"):
        with pytest.raises(UsageError):
            view_angles(wrong)


@pytest.mark.parametrize("name", ["crank", "trike3v"])
def test_axes_have_equal_scales(name):
    source = result_source(name, 0)
    axes = draw_steps(source.scene, source.x(), source.settings, Extras()).axes[0]
    box = axes.get_window_extent()
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    assert abs((x1 - x0) / box.width / ((y1 - y0) / box.height) - 1) < 1e-9


def test_steps_on_the_line_follow_the_setting():
    source = result_source("lateral4", 0)
    assert look_of(source.scene, source.x(), source.settings).points == 101  # STEPLINE 0.01
    assert look_of(source.scene, source.x(), replace(source.settings, step_line=None)).points == 25
