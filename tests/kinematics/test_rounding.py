"""Convergence of the position where rounding is not small: far from the origin, and with an ill-conditioned matrix.

The truth of a displaced model is the same model at the origin, or the closed form. Its error may be what the
coordinates can hold: a coordinate at a distance d is stored to eps d/2, so a difference of two of them is known to
eps d; the bounds below are that times the condition of the position.
"""

import numpy as np
import pytest

import spacar
from spacar.errors import AnalysisError
from spacar.kinematics.kinematics import Kinematics

EPS = float(np.finfo(float).eps)
R, L = 0.2, 0.4  # crank, rod [m]: 0.6 m together
OFFSETS = (0.0, 1.0, 1e2, 1e4, 3e4, 1e5, 3e5, 1e6)
DIRECTIONS = ((1.0, 0.0), (-1.0, 1.0), (0.3, -2.0))


def crank(offset: float, direction: tuple[float, float], degree: str = "INPUTX") -> list[tuple]:
    x, y = offset * direction[0], offset * direction[1]
    return [
        ("PLBEAM", 1, 1, 2, 3, 4), ("PLBEAM", 2, 3, 5, 6, 7), ("X", 1, x, y), ("X", 3, x + R, y),
        ("X", 6, x + R + L, y), ("FIX", 1), ("FIX", 6, 2), (degree, 2, 1),
    ]  # fmt: skip


def slider(phi: np.ndarray) -> np.ndarray:
    return R * np.cos(phi) + np.sqrt(L**2 - (R * np.sin(phi)) ** 2)


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("offset", OFFSETS)
def test_a_slider_crank_far_from_the_origin(offset: float, direction: tuple[float, float], compiled: bool) -> None:
    """Two turns of the driven crank. 1/cos of the largest rod angle (30 degrees) is 1.15; R, L as the file's numbers at
    that place hold them are off by another eps d each."""
    dynamics = [("XM", 6, 0.5), ("EM", 2, 0.3), ("INPUTX", 2, 1, 0.0, 2 * np.pi, 0.0), ("TIMESTEP", 2.0, 100)]
    r = spacar.run(1, spacar.Deck.build(crank(offset, direction), dynamics), compiled=compiled)
    far = offset * max(abs(c) for c in direction)
    x = r.node(6, 1) - offset * direction[0]
    assert np.abs(x - slider(r.node(2, 1))).max() <= 4 * EPS * far + 1e-14
    # velocities: V has the relative error eps d / R of its lengths
    rate = np.imag(slider(r.node(2, 1) + 1e-30j)) / 1e-30 * 2 * np.pi
    assert np.abs(r.node(6, 1, "xd") - rate).max() <= 2 * np.pi * L * (16 * EPS * far / R + 1e-10)


@pytest.mark.parametrize("compiled", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_free_slider_crank_far_from_the_origin(compiled: bool) -> None:
    """Integrated: the crank angle at 1e6 m is that at the origin within the accuracy asked for."""
    dynamics = [
        ("XM", 6, 0.5), ("XM", 2, 0.02), ("EM", 2, 0.3), ("STARTDX", 2, 1, 0.0, 5.0), ("TIMESTEP", 1.0, 20),
        ("ERROR", 1e-7, 1e-7),
    ]  # fmt: skip
    near, far = (
        spacar.run(1, spacar.Deck.build(crank(offset, (1.0, 1.0), "DYNX"), dynamics), compiled=compiled)
        for offset in (0.0, 1e6)
    )
    np.testing.assert_allclose(far.node(2, 1), near.node(2, 1), atol=1e-6)


def ill_conditioned(gap: float) -> spacar.Deck:
    """A bar carried by two parallel links that are `gap` apart, driven: the smallest singular value is about gap."""
    rows = [
        ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 1, 2, 4), ("PLTRUSS", 3, 1, 5), ("PLTRUSS", 4, 3, 6),
        ("PLTRUSS", 5, 1, 7),
        ("X", 1, 0.0, 0.0), ("X", 3, gap, 0.0), ("X", 4, 1.0, 0.0), ("X", 5, 0.0, -1.0), ("X", 6, gap, -1.0),
        ("X", 7, -1.0, 0.0), ("FIX", 5), ("FIX", 6), ("FIX", 7), ("INPUTE", 5, 1),
    ]  # fmt: skip
    return spacar.Deck.build(rows, [("INPUTE", 5, 1, 0.0, 0.01, 0.0), ("TIMESTEP", 1.0, 20)])


@pytest.mark.parametrize("gap", [1e-1, 1e-3, 1e-4, 1e-5, 1e-6])
def test_a_position_that_is_hard_to_determine_is_known_to_its_condition(gap: float) -> None:
    """Both links turn together, the bar stays level: x_1 = e_5 (link 5 lies along x, its end moves on the circle).

    The angle of the bar is known to a few eps/gap.
    """
    r = spacar.run(1, ill_conditioned(gap))
    assert np.abs(r.node(2, 1)).max() <= 100 * EPS / gap


def test_rounding_grows_with_the_numbers_that_enter() -> None:
    """64 eps at the origin, in proportion to the distance far away, whatever the unit of length."""
    from spacar.mechanism import build

    for unit in (1.0, 1e-6, 1e3):
        for offset, expected in ((0.0, 1.0), (1e5, 1e5 / 0.6)):
            rows = [
                (*row[:2], *(c * unit for c in row[2:])) if row[0] == "X" else row for row in crank(offset, (1.0, 0.0))
            ]
            m = build(spacar.Deck.build(rows, []))
            k = Kinematics(m)
            assert k.rounding(m.x0, np.zeros(len(k.h))) == pytest.approx(64 * EPS * max(1.0, expected), rel=1e-4)


@pytest.mark.parametrize("offset", [0.0, 1.0, 1e3, 1e5, 1e6])
def test_a_dead_point_far_from_the_origin_is_still_one(offset: float) -> None:
    """A parallelogram at its dead point at an output: whatever comes out for rod and follower is undetermined."""
    rows = [
        ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 4, 5, 6), ("PLRBEAM", 3, 3, 7, 6), ("X", 1, offset, -offset),
        ("X", 3, offset, 1.0 - offset), ("X", 4, offset + 2.0, -offset), ("X", 6, offset + 2.0, 1.0 - offset),
        ("FIX", 1), ("FIX", 4), ("INPUTX", 2),
    ]  # fmt: skip
    dynamics = [("INPUTX", 2, 1, 0.0, np.pi / 2, 0.0), ("TIMESTEP", 4.0, 40)]
    count = 0
    with pytest.raises(AnalysisError) as caught:  # noqa: PT012
        for _ in spacar.frames(1, spacar.Deck.build(rows, dynamics)):
            count += 1
    assert caught.value.code == "position.singular"
    assert count == 10
    for words in ("t = 1:", "node 5 phi", "node 7 phi", "dead point", "other degrees of freedom"):
        assert words in str(caught.value)
