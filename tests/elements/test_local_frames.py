"""Unit vectors of any length that a number can have, and which element a message is about."""

import numpy as np
import pytest

from spacar.elements.family import GeometryError
from spacar.elements.planar.chord import start_chord
from spacar.elements.rotations.local_frames import PARALLEL, rows, supplemented, unit

EPS = np.finfo(float).eps


@pytest.mark.parametrize("length", [1e-300, 1e-160, 1e-139, 1.0, 1e139, 1e160, 1e300])
def test_a_direction_may_have_any_length(length):
    """Squares of these numbers under- or overflow. 4 eps: five roundings in all, and half as many below the root."""
    found = unit(np.array([[3.0, 0.0], [0.0, 1.0], [4.0, 0.0]]) * length, 0, "axis")
    assert found == pytest.approx(np.array([[0.6, 0.0], [0.0, 1.0], [0.8, 0.0]]), rel=4 * EPS)


@pytest.mark.parametrize("bad", [0.0, np.inf, np.nan])
def test_a_vector_without_direction_is_named(bad):
    with pytest.raises(GeometryError, match="the axis is the zero vector") as told:
        unit(np.array([[1.0, bad], [0.0, 0.0], [0.0, 0.0]]), 5, "axis")
    assert told.value.index == 6


def test_the_first_of_the_elements_that_are_too_short_is_named():
    start = np.zeros((2, 4))
    end = np.array([[1.0, 1e-14, 0.0, 2.0], [0.0, 0.0, 0.0, 0.0]])
    with pytest.raises(GeometryError, match=r"PLBEAM has length 1e-14 m") as told:
        start_chord(start, end, "PLBEAM")
    assert told.value.index == 1


@pytest.mark.parametrize("length", [1e-300, 1e-160, 1.0, 1e139, 1e160, 1e300])
def test_a_frame_does_not_depend_on_the_length_of_its_direction(length):
    """Of two elements one direction is long, one short: also where neither decides about the other. x' = (0.6, 0.8, 0)
    and y' = (-0.8, 0.6, 0) by hand. 8 eps: of the components of order one, a sum, a product and a quotient each."""
    ex = np.array([[0.6, 0.6], [0.8, 0.8], [0.0, 0.0]])
    frames = supplemented(ex, np.array([[0.0, 0.0], [length, 1.0], [0.0, 0.0]]), 0, "direction")
    by_hand = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    assert np.abs(frames - by_hand[:, :, None]).max() < 8 * EPS
    assert rows(frames).reshape(2, 3, 3) == pytest.approx(np.stack((by_hand.T, by_hand.T)), abs=8 * EPS)


@pytest.mark.parametrize("sine", [0.9 * PARALLEL, 1.1 * PARALLEL])
def test_the_bound_of_parallel_directions_is_that_of_the_angle(sine):
    """Whatever the lengths: the second of three directions is at the given angle, the others are far from the bound."""
    ex = np.array([[1.0] * 3, [0.0] * 3, [0.0] * 3])
    g = np.array([[0.0, 5.0 * np.sqrt(1.0 - sine**2), 0.0], [7.0, 5.0 * sine, 1e-3], [0.0] * 3])
    if sine > PARALLEL:
        assert np.abs(supplemented(ex, g, 0, "direction") - np.eye(3)[:, :, None]).max() < 1e-9  # eps/sine
    else:
        with pytest.raises(GeometryError, match=r"parallel .*angle 0.000516 degrees") as told:
            supplemented(ex, g, 0, "direction")
        assert told.value.index == 1
