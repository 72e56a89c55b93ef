"""A parallel guide over its stroke against closed forms, and against finite differences and integrals of itself."""

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from tests.examples import DATA

from . import stroke_models as models
from .stroke_models import EA, EI, LENGTH

BEAMS = 8
PUBLISHED = DATA / "published" / "leafspring_guide.dat"


@pytest.fixture(scope="module")
def published():
    """SPACAR Light's guide, 0.5 mm, 20 mm to both sides as its file says."""
    return spacar.flexure(PUBLISHED, steps=5)


@pytest.fixture(scope="module")
def small():
    """Planar, 4 mm to both sides, where the closed forms hold; the coordinate was calculable in the file."""
    return spacar.flexure(parse_deck(models.two_leaves(models.GUIDE, BEAMS)), move="9x=+-0.004", steps=4)


def test_the_published_numbers(published):
    """99.06, 177.13, 258.32 Hz and 654 MPa at 20 mm, in the compressed leaf at its clamp; the file is its own drive.
    The published program leaves shear out of the second order terms, which is 0.3 % here; finer meshes tend to 75.7,
    158.8, 260.5 Hz in both measures."""
    assert published.stroke == pytest.approx(np.linspace(-0.02, 0.02, 11), abs=1e-15)
    assert published.frequencies[-1, :3] == pytest.approx([99.06, 177.13, 258.32], rel=3e-3)
    stress, element, place = published.largest_stress
    assert stress[-1] == pytest.approx(654e6, abs=0.5e6)
    assert (element[-1], place[-1]) == (1, 0.0)


def test_the_parasitic_motion(published):
    """-3 x^2/(5 L) to 1 % (up to 0.15 L)."""
    small = (np.abs(published.stroke) < 0.16 * LENGTH) & (published.stroke != 0.0)
    expected = -0.6 * published.stroke[small] ** 2 / LENGTH
    assert published.errors.line_error[small, 1] == pytest.approx(expected, rel=0.01)
    assert published.errors.line_error[:, [0, 2]] == pytest.approx(np.zeros((11, 2)), abs=1e-12)
    assert not published.errors.turning


def test_work_is_strain_energy(published, small):
    """Hermite's rule has an error of fourth order: 4 mm steps leave 2.4e-7, 1 mm steps 1/256 of it."""
    for study, limit in ((published, 1e-6), (small, 4e-9)):
        assert np.abs(study.missing_energy).max() < limit * study.energy.max()
        assert study.energy.max() > 0.0


def test_the_drive_stiffness_is_the_derivative_of_the_force(published, small):
    """Simpson's rule over two steps gives the difference of the forces; its error is of fifth order in the step."""
    for study in (published, small):
        h = np.diff(study.stroke)[0]
        k, F = study.drive_stiffness, study.force
        integral = h / 3.0 * (k[:-2:2] + 4.0 * k[1:-1:2] + k[2::2])
        assert integral == pytest.approx(F[2::2] - F[:-2:2], rel=2e-6)


def test_closed_forms_of_the_undeflected_guide(small):
    """Two leaves: 24 EI/L^3 along the drive, 2 EA/L across."""
    zero = small.zero
    assert small.drive_stiffness[zero] == pytest.approx(24.0 * EI / LENGTH**3, rel=1e-4)  # the body turns by 1e-5
    k = small.stiffness()[zero]
    assert k[1] == pytest.approx(2.0 * EA / LENGTH, rel=1e-6)
    assert k[0] == np.inf
    assert small.stiffness(locked=False)[zero, 0] == pytest.approx(24.0 * EI / LENGTH**3, rel=1e-4)
    assert small.support == [1, 2]


def test_the_support_stiffness_over_the_stroke(small):
    """Awtar: L/EA + L x^2/(700 EI) for a leaf, clamped and guided: half of the stiffness is left at 4 mm; four
    beams a leaf are 2 % off there, eight 0.1 %."""
    expected = 2.0 / (LENGTH / EA + LENGTH * small.stroke**2 / (700.0 * EI))
    assert small.stiffness()[:, 1] == pytest.approx(expected, rel=2e-3)
    assert small.remaining()[-1, 1] == pytest.approx(expected[-1] / expected[small.zero], rel=2e-3)
    assert small.remaining()[-1, 1] < 0.5


def test_first_unwanted_frequency_and_that_of_the_drive(small):
    """Locking one coordinate separates the frequencies (Cauchy); the drive has sqrt(24 EI/L^3/m), m with 26/35 of the
    leaves, so little that 1 % is enough."""
    locked, free = small.frequencies, small.free_frequencies
    known = np.isfinite(locked[0]) & np.isfinite(free[0])
    n = int(known.sum()) - 1
    assert (free[:, :n] <= locked[:, :n] * (1 + 1e-9)).all()
    assert (locked[:, :n] <= free[:, 1 : n + 1] * (1 + 1e-9)).all()
    leaves = 2 * models.RHO * models.WIDTH * models.THICKNESS * LENGTH
    expected = np.sqrt(24.0 * EI / LENGTH**3 / (models.BODY + 13 / 35 * leaves)) / (2 * np.pi)
    assert small.of("drive_hertz") == pytest.approx(expected, rel=0.01)
    assert small.of("unwanted_free") == pytest.approx(free[:, 1])


def test_a_drive_that_the_file_prescribes_gives_the_same(small):
    """Whether the coordinate was prescribed, dynamic or calculable in the file does not matter."""
    inputs = spacar.flexure(
        parse_deck(models.two_leaves(models.GUIDE, BEAMS, ("INPUTX 9 1",))), move="x[9,1]=-0.004:0.004", steps=4
    )
    ours, theirs = small.table(), inputs.table()
    names = ("force", "drive_stiffness", "energy", "line_y", "k_y", "k_r", "f_1", "ffree_1", "margin", "margin_free")
    for name in names:
        assert theirs[name] == pytest.approx(ours[name], rel=1e-6, abs=1e-9), name


def test_a_force_reaches_the_same_states(small):
    """A force instead of a displacement: the same stroke, stiffness, frequencies."""
    pushed = spacar.flexure(
        parse_deck(models.two_leaves(models.GUIDE, BEAMS)), force=f"9x={float(small.force[-1])!r}", steps=4
    )
    assert pushed.stroke[-1] == pytest.approx(0.004, rel=1e-6)
    assert pushed.force == pytest.approx(np.linspace(0.0, small.force[-1], 5))
    for name in ("drive_stiffness", "energy", "line_y", "k_y", "f_1", "margin", "work"):
        assert pushed.table()[name][-1] == pytest.approx(small.table()[name][-1], rel=1e-5), name


def test_the_buckling_margin_of_a_payload():
    """A load along the leaves: 4 pi^2 EI/L^2 a leaf with the drive locked, pi^2 EI/L^2 with it free."""
    load = 100.0
    deck = parse_deck(models.two_leaves(models.GUIDE, BEAMS))
    study = spacar.flexure(deck, move="9x=0.0001", steps=1, loads=[f"9y={-load}"], beams="angle")
    euler = 2.0 * np.pi**2 * EI / LENGTH**2 / load
    assert study.of("margin_free")[0] == pytest.approx(euler, rel=0.01)
    assert study.of("margin")[0] == pytest.approx(4.0 * euler, rel=0.02)


def test_a_payload_works_too():
    """The strain energy is the work of drive and payload."""
    deck = parse_deck(models.two_leaves(models.GUIDE, BEAMS))
    study = spacar.flexure(deck, move="9x=0.01", steps=4, loads=["9y=-20"])
    assert study.load_work[-1] == pytest.approx(20.0 * 0.6 * 0.01**2 / LENGTH, rel=0.02)
    assert np.abs(study.missing_energy).max() < 1e-6 * study.energy.max()


def test_another_node_and_axes_of_the_body(small):
    """Node 7 of the same body: the same frequencies, another support stiffness; body axes turn with the body."""
    other = spacar.flexure(
        parse_deck(models.two_leaves(models.GUIDE, BEAMS)), move="9x=0.004", steps=1, node=7, orientation=6
    )
    assert other.frequencies[-1] == pytest.approx(small.frequencies[-1], rel=1e-6)
    assert other.support == [0, 1, 2]
    trace = [np.trace(other.compliance(body=body)[-1][:2, :2]) for body in (False, True)]
    assert trace[0] == pytest.approx(trace[1], rel=1e-9)
