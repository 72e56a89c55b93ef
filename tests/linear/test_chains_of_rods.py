"""Chains without any elasticity on the path of large systems: pendulums under gravity, and free of it."""

import numpy as np
import pytest
from models import pendulum
from scipy.special import jn_zeros

import spacar
from spacar.linear import form, linear_modes


def frequencies(text: str, mode: int = 7) -> np.ndarray:
    return np.sort(np.hypot(*spacar.run(mode, spacar.parse_deck(text, mode=mode))["eigval"][0].T))[::2]


def test_lowest_modes_of_a_hanging_chain_of_rods(monkeypatch):
    """The same as with dense matrices; the lowest ones are those of the hanging rope, j_0k sqrt(g/l)/2, to 1/n^2."""
    text, n = pendulum(40, 1.0, 10), 40
    dense = frequencies(text)
    monkeypatch.setattr(form, "LARGE", 5)
    sparse = frequencies(text, 10)
    assert len(sparse) == linear_modes.WANTED
    assert sparse == pytest.approx(dense[: len(sparse)], rel=1e-9)
    rope = jn_zeros(0, 3) / 2 * np.sqrt(9.81 / n)
    assert sparse[:3] == pytest.approx(rope, rel=20 / n**2)


def test_a_chain_without_gravity_has_no_frequency(monkeypatch):
    monkeypatch.setattr(form, "LARGE", 5)
    free = frequencies(pendulum(20, 1.0, 10).replace("GRAVITY 0. -9.81\n", ""))
    assert np.all(free < 1e-7)  # the shift is 1 rad/s, of whose square eps is 1.5e-8 rad/s


@pytest.mark.slow
def test_seven_hundred_rods():
    """17 s, most of it in the position of the straight chain."""
    rope = jn_zeros(0, 5) / 2 * np.sqrt(9.81 / 700)
    assert frequencies(pendulum(700, 1.0, 10))[:5] == pytest.approx(rope, rel=1e-4)
