"""A cross hinge over its rotation: stiffness, pivot shift, pole, work of moments; a rigid body about a pin."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import spacar
from spacar.deck import parse_deck
from spacar.stroke.error_motions import relative_rotations
from tests.examples import DATA

from . import stroke_models as models
from .stroke_models import EI, LENGTH

SPATIAL = DATA / "crosshingew.dat"
LEAF = np.sqrt(2.0) * LENGTH


@pytest.fixture(scope="module")
def hinge():
    """Leaves that cross in their middles at right angles, turned by 0.12 rad to both sides."""
    return spacar.flexure(parse_deck(models.two_leaves(models.CROSS, 8)), move="6r=+-0.12", steps=4, beams="angle")


def test_the_rotational_stiffness(hinge):
    """Both leaves bend to circles at first: EI/L each."""
    assert hinge.errors.turning
    assert hinge.drive_stiffness[hinge.zero] == pytest.approx(2.0 * EI / LEAF, rel=1e-3)
    h = np.diff(hinge.stroke)[0]
    k, F = hinge.drive_stiffness, hinge.force
    assert h / 3.0 * (k[:-2:2] + 4.0 * k[1:-1:2] + k[2::2]) == pytest.approx(F[2::2] - F[:-2:2], rel=1e-6)


def test_the_pivot_shift(hinge):
    """Haringx: L theta^2/(12 cos a), a half the angle between the leaves, along its bisector to the body."""
    e = hinge.errors
    assert e.pivot == pytest.approx([0.05, 0.05, 0.0], abs=1e-4 * LEAF)
    small = np.abs(e.angle) < 0.07
    expected = LEAF * e.angle[small] ** 2 / (12.0 * np.cos(np.pi / 4.0))
    assert e.pivot_shift[small, 1] == pytest.approx(expected, rel=0.02)
    assert np.abs(e.pivot_shift[:, 0]).max() < 0.1 * e.pivot_shift[-1, 1]
    assert e.angle == pytest.approx(hinge.stroke, abs=1e-12)
    assert not e.tilt.any()


def test_the_pole_is_where_the_body_stands_still(hinge):
    """Velocity of node 5 by differences: the point of the body at the pole has none, to second order of the step."""
    e, k = hinge.errors, len(hinge) - 2
    step = hinge.stroke[k + 1] - hinge.stroke[k - 1]
    node = e.displacement + np.array(models.CROSS[1] + (0.0,))
    move = (node[k + 1] - node[k - 1]) / step
    arm = e.pole[k] - node[k]
    assert move + np.cross([0.0, 0.0, 1.0], arm) == pytest.approx(np.zeros(3), abs=2e-3 * np.linalg.norm(move))


def test_the_energy_of_the_hinge(hinge):
    assert np.abs(hinge.missing_energy).max() < 1e-7 * hinge.energy.max()


def test_the_ideal_pivot_may_be_given():
    deck = parse_deck(models.two_leaves(models.CROSS, 4))
    study = spacar.flexure(deck, move="6r=0.05", steps=1, pivot=(0.06, 0.05), node=5)
    assert study.errors.pivot == pytest.approx([0.06, 0.05, 0.0])
    arm = np.array([0.06, 0.05, 0.0]) - np.array([0.1, 0.1, 0.0])
    expected = study.errors.displacement[-1] + Rotation.from_rotvec([0.0, 0.0, 0.05]).apply(arm) - arm
    assert study.errors.pivot_shift[-1] == pytest.approx(expected, abs=1e-12)


@pytest.fixture(scope="module")
def spatial():
    """The published hinge with warping, its weight and a moment, turned by its Euler parameter."""
    return spacar.flexure(SPATIAL, move="8rz=+-0.2", steps=3)


def test_a_spatial_rotation_by_an_euler_parameter(spatial):
    """M dtheta is the work, together with weight, force and moment; dM/dtheta is the slope of M."""
    assert spatial.stroke[[0, -1]] == pytest.approx([-0.2, 0.2], abs=1e-12)
    assert spatial.errors.angle == pytest.approx(spatial.stroke, abs=1e-5)
    size = max(np.abs(spatial.work).max(), np.abs(spatial.load_work).max())
    assert np.abs(spatial.missing_energy).max() < 2e-6 * size
    from scipy.interpolate import CubicHermiteSpline

    inside = CubicHermiteSpline(spatial.stroke[::2], spatial.force[::2], spatial.drive_stiffness[::2])
    assert inside(spatial.stroke[1::2]) == pytest.approx(spatial.force[1::2], abs=2e-4 * np.ptp(spatial.force))


def test_a_moment_instead_of_the_rotation(spatial):
    """The same state by a moment. The force on the Euler parameter has small moments about the other axes too, as the
    body tilts by 0.004 rad."""
    moment = float(spatial.force[-1])
    pushed = spacar.flexure(SPATIAL, force=f"8rz={moment!r}", steps=4)
    assert pushed.stroke[-1] == pytest.approx(0.2, rel=1e-4)
    for name in ("f_1", "k_x", "k_rx", "energy", "margin"):
        assert pushed.table()[name][-1] == pytest.approx(spatial.table()[name][-1], rel=2e-4), name
    assert pushed.drive_stiffness[-1] == pytest.approx(spatial.drive_stiffness[-1], rel=0.05)
    size = max(np.abs(pushed.work).max(), np.abs(pushed.load_work).max())
    assert np.abs(pushed.missing_energy).max() < 1e-4 * size


def test_a_deformation_as_the_drive():
    """A torsion spring in a pin: the body turns about it exactly, the moment is S e."""
    text = """PLTOR 1 1 3   PLRBEAM 2 2 3 4   X 2 0. 0.   X 4 0.3 0.   FIX 1   FIX 2   DYNE 1 1   END HALT
ESTIFF 1 5.   XM 4 2.   END END
"""
    study = spacar.flexure(parse_deck(text), move="e[1,1]=+-0.5", steps=4, node=4, orientation=3)
    assert study.errors.turning
    assert study.errors.pole == pytest.approx(np.zeros((9, 3)), abs=1e-12)
    assert study.errors.pivot_shift == pytest.approx(np.zeros((9, 3)), abs=1e-12)
    assert study.errors.angle == pytest.approx(study.stroke, abs=1e-12)
    pushed = spacar.flexure(parse_deck(text), force="3r=2.5", steps=2, node=4, orientation=3)
    assert pushed.stroke == pytest.approx([0.0, 0.25, 0.5])
    assert pushed.drive_stiffness == pytest.approx(np.full(3, 5.0))
    assert pushed.energy == pytest.approx(2.5 * pushed.stroke**2)
    assert pushed.of("drive_hertz") == pytest.approx(np.sqrt(5.0 / (2.0 * 0.09)) / (2 * np.pi))


def test_rotation_vectors():
    """Of half turns and small ones, against the quaternion of the axis and angle."""
    rng = np.random.default_rng(3)
    for angle in (1e-12, 1e-4, 1.0, 3.0):
        axis = rng.standard_normal(3)
        axis /= np.linalg.norm(axis)
        turn = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])
        first = rng.standard_normal(4)
        first /= np.linalg.norm(first)
        w = turn[0] * first[0] - turn[1:] @ first[1:]
        v = turn[0] * first[1:] + first[0] * turn[1:] + np.cross(turn[1:], first[1:])
        for sign in (1.0, -1.0):
            found = relative_rotations(sign * np.array([w, *v]), first).as_rotvec()[0]
            assert found == pytest.approx(angle * axis, rel=1e-9, abs=1e-15 / angle if angle < 1e-9 else 1e-12)
