"""The start value of the next position: a polynomial through two states."""

import models
import numpy as np
from numpy.polynomial import Polynomial

import spacar
from spacar.dynamics.motion_equations import State, extrapolated
from spacar.kinematics.element_sweep import ElementSweep

SCALE = np.full(3, 10.0)


def states(rows: np.ndarray) -> list[Polynomial]:
    return [Polynomial(row) for row in rows]


def at(t: float, motion: list[Polynomial]) -> State:
    values = [np.array([p.deriv(k)(t) if k else p(t) for p in motion]) for k in range(3)]
    return t, *values


def test_a_quintic_motion_is_reproduced() -> None:
    """Six conditions determine the six coefficients; steps of different length. Tolerance: rounding, amplified 30."""
    motion = states(np.random.default_rng(1).normal(size=(3, 6)))
    found = extrapolated(0.25, at(0.15, motion), at(0.06, motion), SCALE)
    assert np.abs(found - at(0.25, motion)[1]).max() < 1e-13


def test_without_a_smooth_past_it_is_taylors_polynomial() -> None:
    motion = states(np.random.default_rng(2).normal(size=(3, 3)))  # for which Taylor's polynomial is exact
    last, before = at(0.15, motion), at(0.06, motion)
    jumped = (before[0], before[1] + 1e3, before[2], before[3])
    exact = at(0.25, motion)[1]
    for earlier in (None, jumped, at(0.15, motion), at(0.4, motion)):
        assert np.abs(extrapolated(0.25, last, earlier, SCALE) - exact).max() < 1e-13
    assert np.abs(extrapolated(0.15, last, before, SCALE) - last[1]).max() == 0.0


def test_a_prescribed_motion_needs_two_evaluations_per_position(monkeypatch) -> None:
    """crank.dat, 0.15 rad between outputs: the start value is off by 1e-7, so the second correction is rounding."""
    count = 0
    strain = ElementSweep.strain

    def counted(self: ElementSweep, x: np.ndarray) -> None:
        nonlocal count
        count += 1
        strain(self, x)

    monkeypatch.setattr(ElementSweep, "strain", counted)
    frames = list(spacar.frames(1, spacar.parse_deck(models.example("crank"), mode=1)))
    assert count <= 2 * len(frames) + 5
