"""Paths: end points, and rates against differences of the values."""

import numpy as np
import pytest

from spacar.inverse.paths import BadPath, arc, change, straight, turn

ROWS2, ROWS3 = np.arange(2), np.arange(3)


def paths():
    yield straight(ROWS2, np.array([1.0, 2.0]), np.array([-0.5, 3.0])), [-0.5, 3.0]
    yield change(np.array([0]), np.array([0.3]), -1.2), [-0.9]
    yield arc(ROWS2, np.array([2.0, 1.0]), np.array([1.0, 1.0]), np.array([1.0, 9.0])), [1.0, 2.0]
    yield arc(ROWS2, np.array([2.0, 1.0]), np.array([1.0, 1.0]), np.array([1.0, -9.0])), [1.0, 0.0]
    third = arc(ROWS3, np.array([0.0, 2.0, 0.0]), np.zeros(3), np.array([0.0, 0.0, 0.4]))
    yield third, [0.0, 0.0, 2.0]
    axis = np.array([1.0, 2.0, -0.5])
    start = np.array([np.cos(0.2), *(np.sin(0.2) * np.array([0.0, 0.6, 0.8]))])
    yield turn(ROWS3, np.array([1, 2, 3]), start, 1.1, axis), None


@pytest.mark.parametrize(("path", "end"), list(paths()))
def test_values_and_derivatives(path, end):
    if end is not None:
        assert path.at(path.length, 0.0, 0.0)[0] == pytest.approx(end, abs=1e-14)
    p, v, a, h = 0.4 * path.length, 0.7, -0.3, 1e-4

    def value(t):
        return path.at(p + v * t + 0.5 * a * t * t, 0.0, 0.0)[0]

    _, rate, acceleration = path.at(p, v, a)
    # central differences: error h^2 times the third derivative (about 1), and rounding 1e-16 / h^2
    assert (value(h) - value(-h)) / (2 * h) == pytest.approx(rate, abs=1e-7)
    assert (value(h) - 2 * value(0.0) + value(-h)) / h**2 == pytest.approx(acceleration, abs=1e-6)


def test_spatial_turn_is_a_global_rotation():
    """Rotation vectors compose: a turn from the reference orientation is (cos p/2, h sin p/2)."""
    h = np.array([0.6, 0.0, 0.8])
    path = turn(ROWS3, np.array([1, 2, 3]), np.array([1.0, 0, 0, 0]), -0.9, h)
    assert path.at(0.5, 1.0, 0.0)[0] == pytest.approx(-h * np.sin(0.25), abs=1e-15)
    two = turn(ROWS3, np.array([1, 2, 3]), np.array([np.cos(0.35), *(h * np.sin(0.35))]), 0.4, h)
    assert two.at(0.4, 1.0, 0.0)[0] == pytest.approx(h * np.sin(0.55), abs=1e-15)


@pytest.mark.parametrize("total", [3.2, -3.2, 7.0])
def test_half_a_turn_is_refused(total):
    with pytest.raises(BadPath, match="half a turn"):
        turn(ROWS3, np.array([1, 2, 3]), np.array([1.0, 0, 0, 0]), total, np.array([0.0, 0.0, 1.0]))


@pytest.mark.parametrize(
    ("start", "centre", "end", "why"),
    [
        ([1.0, 0.0], [1.0, 0.0], [2.0, 0.0], "radius is zero"),
        ([1.0, 0.0], [0.0, 0.0], [0.0, 0.0], "undefined"),
        ([1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-3.0, 0.0, 0.0], "plane of the arc"),
    ],
)
def test_bad_arcs_are_refused(start, centre, end, why):
    with pytest.raises(BadPath, match=why):
        arc(np.arange(len(start)), *(np.array(v) for v in (start, centre, end)))
