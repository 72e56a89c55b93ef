"""Rigid mechanisms over a long time against closed forms: no drift, whatever drives them."""

import numpy as np
import pytest

import spacar
from spacar.kinematics.constraint_matrices import ROUNDING
from spacar.kinematics.kinematics import Kinematics
from spacar.linear_systems.reciprocal_condition import smallest
from spacar.mechanism import build
from tests.examples import DATA

R, L = 0.15, 0.35  # crank, rod [m]

CRANK = [
    ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 3, 4, 5), ("X", 3, R, 0.0), ("X", 5, R + L, 0.0), ("FIX", 1), ("FIX", 5, 2),
]  # fmt: skip
MASSES = [("XM", 5, 0.5), ("XM", 2, 0.02), ("EM", 2, 0.3)]


def slider(phi: np.ndarray) -> np.ndarray:
    """Place of the slider."""
    return R * np.cos(phi) + np.sqrt(L**2 - (R * np.sin(phi)) ** 2)


def slider_rate(phi: np.ndarray) -> np.ndarray:
    """d(slider)/d(phi)."""
    return -R * np.sin(phi) - R**2 * np.sin(phi) * np.cos(phi) / np.sqrt(L**2 - (R * np.sin(phi)) ** 2)


def crank_inertia(phi: np.ndarray) -> np.ndarray:
    """Reduced inertia of the crank angle: kinetic energy = half of this times phidot^2 (slider, wheel, uniform rod)."""
    root = np.sqrt(L**2 - (R * np.sin(phi)) ** 2)
    rod_turn = -R * np.cos(phi) / root  # dpsi/dphi
    xs = slider_rate(phi)
    vx = 0.5 * (-R * np.sin(phi) + xs)
    vy = 0.5 * R * np.cos(phi)
    m = 0.3 * L
    return 0.02 + 0.5 * xs**2 + m * (vx**2 + vy**2) + m * L**2 / 12 * rod_turn**2


@pytest.mark.parametrize("turns", [50, pytest.param(1000, marks=pytest.mark.slow)])
def test_prescribed_crank_over_many_revolutions(turns: int) -> None:
    """Position error at the end below 1e-9 of the crank length, and no growth: the position is solved, not
    integrated.
    """
    per_turn = 12
    rate = 2 * np.pi
    deck = spacar.Deck.build(
        [*CRANK, ("INPUTX", 2)],
        [*MASSES, ("INPUTX", 2, 1, 0.0, rate, 0.0), ("TIMESTEP", float(turns), turns * per_turn)],
    )
    r = spacar.run(1, deck)
    phi = rate * r.t
    for x, exact in (
        (r.node(3, 1), R * np.cos(phi)),
        (r.node(3, 2), R * np.sin(phi)),
        (r.node(5, 1), slider(phi)),
    ):
        error = np.abs(x - exact)
        assert error[-per_turn:].max() < 1e-12 * R * turns  # phi itself has 1e-13 relative rounding of 6283 rad
        assert error.max() < 1e-9 * R
    assert np.abs(r.node(5, 1, "xd") - rate * slider_rate(phi)).max() < 1e-9 * R * rate
    # The driving moment is the time derivative of the kinetic energy divided by the rate; periodic, so the same in
    # the first and in the last revolution.
    moment = (r["fxtot"] - r["fx"] - r["fxgrav"])[:, r.lnp[1, 0] - 1]
    exact = 0.5 * rate**2 * crank_inertia(phi + 1e-30j).imag / 1e-30
    np.testing.assert_allclose(moment, exact, atol=1e-10 * np.abs(exact).max())
    np.testing.assert_allclose(moment[-per_turn - 1 : -1], moment[:per_turn], atol=1e-9 * np.abs(exact).max())


def test_free_crank_keeps_its_energy_and_follows_the_quadrature() -> None:
    """Started and left alone for 8 revolutions: kinetic energy constant, time from phi by quadrature.

    Tolerance: the energy error is the integrator's tolerance times the number of steps; measured 1e-9 for 1e-12.
    """
    rate, duration, n = 2 * np.pi, 8.0, 40
    deck = spacar.Deck.build(
        [*CRANK, ("DYNX", 2)],
        [*MASSES, ("STARTDX", 2, 1, 0.0, rate), ("TIMESTEP", duration, n), ("ERROR", 1e-12, 1e-12)],
    )
    r = spacar.run(1, deck)
    phi, phid = r.node(2, 1), r.node(2, 1, "xd")
    energy = 0.5 * crank_inertia(phi) * phid**2
    assert np.abs(energy / energy[0] - 1).max() < 1e-8
    np.testing.assert_allclose(r.node(5, 1), slider(phi), atol=1e-14)  # constraints never drift
    # t = integral sqrt(I(phi)/2E) dphi, by the trapezoidal rule over whole turns (exponentially accurate)
    grid = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    period = 2 * np.pi * np.mean(np.sqrt(crank_inertia(grid) / (2 * energy[0])))
    turns = np.floor(phi[-1] / (2 * np.pi))
    rest = np.linspace(0, phi[-1] - 2 * np.pi * turns, 4001)
    y = np.sqrt(crank_inertia(rest) / (2 * energy[0]))
    simpson = (rest[1] - rest[0]) / 3 * (y[0] + y[-1] + 4 * y[1:-1:2].sum() + 2 * y[2:-1:2].sum())
    assert turns * period + simpson == pytest.approx(duration, rel=1e-8)


def test_slider_example_passes_the_vertical() -> None:
    """data/slider: both sliders against x^2 + y^2 = 4, through y = 2 where the vertical slider turns round."""
    r = spacar.run(1, DATA / "slider.dat", n_steps=400)
    np.testing.assert_allclose(r.node(2, 2), np.sqrt(1.7321**2 + 1.0 - (1.7321 - r.t) ** 2), atol=1e-12)


def test_cardan_joint_over_several_turns() -> None:
    """data/cardansimp: tan e4 = -tan e1 / cos 45, velocities and accelerations, three turns and through all
    quadrants.
    """
    r = spacar.run(1, DATA / "cardansimp.dat", duration=3.0, n_steps=300)
    e1, e4 = r.element(1, 1), r.element(4, 1)
    c = np.cos(np.pi / 4)
    exact = -np.arctan2(np.sin(e1), c * np.cos(e1))
    exact = np.unwrap(exact)
    np.testing.assert_allclose(e4, exact, atol=1e-12)
    assert e4[-1] == pytest.approx(-6 * np.pi, abs=1e-6)  # the rate of the file has 8 digits
    w = r.element(1, 1, "ed")
    s2 = 1 - c**2
    rate = -w * c / (1 - s2 * np.cos(e1) ** 2)
    np.testing.assert_allclose(r.element(4, 1, "ed"), rate, rtol=1e-12)
    acceleration = w**2 * c * s2 * np.sin(2 * e1) / (1 - s2 * np.cos(e1) ** 2) ** 2
    np.testing.assert_allclose(r.element(4, 1, "edd"), acceleration, atol=1e-12 * np.abs(acceleration).max())


def test_cardan_chain_with_drawing_beams_agrees() -> None:
    a = spacar.run(1, DATA / "cardansimp.dat", duration=3.0, n_steps=60)
    b = spacar.run(1, DATA / "cardan.dat", duration=3.0, n_steps=60)
    for element in (2, 3, 4):
        np.testing.assert_allclose(b.element(element, 1), a.element(element, 1), atol=1e-12)


def test_a_chain_of_two_cardan_joints_is_homokinetic() -> None:
    """Two joints with equal angles and yokes in phase: the output turns exactly as the input (1e-12, five turns)."""
    a = 0.4
    middle, out = (np.cos(a), np.sin(a), 0.0), (np.cos(2 * a), np.sin(2 * a), 0.0)
    normal = (-np.sin(a), np.cos(a), 0.0)
    rows = [
        ("HINGE", 1, 1, 2, 1.0, 0.0, 0.0),
        ("HINGE", 2, 2, 3, 0.0, 0.0, 1.0), ("HINGE", 3, 3, 4, *normal),
        ("HINGE", 4, 4, 5, *normal), ("HINGE", 5, 5, 6, 0.0, 0.0, 1.0),
        ("HINGE", 6, 7, 6, *out), ("HINGE", 8, 8, 4, *middle),
        ("FIX", 1), ("FIX", 7), ("FIX", 8), ("INPUTE", 1, 1), *[("RLSE", k, 1) for k in (2, 3, 4, 5, 6, 8)],
    ]  # fmt: skip
    r = spacar.run(1, spacar.Deck.build(rows, [("INPUTE", 1, 1, 0.0, 2 * np.pi, 0.0), ("TIMESTEP", 5.0, 100)]))
    np.testing.assert_allclose(r.element(6, 1), r.element(1, 1), atol=1e-12)
    np.testing.assert_allclose(r.element(6, 1, "edd"), 0.0, atol=1e-9)
    # (accelerations are of size (2 pi)^2 = 39, and V belongs to an iterate that is at most 1e-11 away)
    exact = np.unwrap(np.arctan2(np.cos(a) * np.sin(r.element(1, 1)), np.cos(r.element(1, 1))))
    np.testing.assert_allclose(r.element(8, 1), exact, atol=1e-12)


# The two roots of a position near a dead point, and the badly conditioned positions that have one.
def slider_at(angle: float, size: float = 1.0) -> Kinematics:
    """Crank R, rod L, driven by the slider; the crank is at the angle from its dead centre, reference configuration."""
    x, y = R * np.cos(angle), R * np.sin(angle)
    rows = [
        ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 3, 4, 5), ("X", 3, x * size, y * size),
        ("X", 5, (x + np.sqrt(L**2 - y**2)) * size, 0.0), ("FIX", 1), ("FIX", 5, 2), ("INPUTX", 5, 1),
    ]  # fmt: skip
    k = Kinematics(build(spacar.Deck.build(rows, [])))
    k.move(k.mechanism.x0, np.zeros(k.numbering.ne))
    return k


def single(k: Kinematics, rounding: float) -> bool:
    D = k.sweep.gradient()[np.ix_(k.h, k.c)] * k.scale[k.c] / k.h_scale[:, None]
    assert k.norm(k.of_position) == pytest.approx(np.abs(D).sum(axis=0).max(), rel=1e-12)
    return k.is_single_root(k.of_position, rounding)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("angle", [1e-2, 1e-4])
def test_the_second_root_is_where_the_fold_says(angle: float, size: float) -> None:
    """Crank up and crank down have the same slider: the roots are 2 x angle apart, to angle^2."""
    k = slider_at(angle, size)
    s, u, w = smallest(k.position_system, 1.0 / k.h_scale, k.scale[k.c])
    v = np.zeros(k.numbering.nx)
    v[k.c] = w * k.scale[k.c]
    c = u @ (k.sweep.convective(v)[k.h] / k.h_scale)
    crank = k.numbering.x_index(2, 1)
    # the reference configuration is phi = 0 at the angle: down is -2 angle
    assert -2.0 * s / c * v[crank] == pytest.approx(-2.0 * angle, rel=3 * angle)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_roots_nearer_than_rounding_are_one(size: float) -> None:
    """The residual of the fold, angle^2 R (R + L)/(2 L) in model lengths: single when it exceeds rounding."""
    for angle in (1e-3, 1e-5, 1e-6):
        k = slider_at(angle, size)
        residual = angle**2 * R * (R + L) / (2 * L) / (R + L)
        assert single(k, 0.1 * residual)
        assert not single(k, 20.0 * residual)  # along u the residual is smaller than its largest component


@pytest.mark.parametrize("n", [10, 1000, pytest.param(10000, marks=pytest.mark.slow)])
def test_every_position_of_a_long_chain_is_single(n: int) -> None:
    """Smallest singular value about n^-2, down to 2.5e-9 of the norm."""
    rows: list[tuple] = [("PLBEAM", k + 1, 2 * k + 1, 2 * k + 2, 2 * k + 3, 2 * k + 4) for k in range(n)]
    rows += [("X", 2 * k + 1, k / n, 0.0) for k in range(1, n + 1)] + [("FIX", 1), ("INPUTX", 2, 1)]
    k = Kinematics(build(spacar.Deck.build(rows, [])))
    k.begin()
    s = smallest(k.position_system, 1.0 / k.h_scale, k.scale[k.c])[0]
    assert s < 1.0 / n**1.5
    assert k.is_single_root(k.of_position, ROUNDING)


def test_a_position_at_its_dead_centre_is_not_single() -> None:
    assert not single(slider_at(1e-9), ROUNDING)
    assert single(slider_at(1e-5), ROUNDING)
