"""The bound of the condition number that tells whether anything depends on the number."""

from __future__ import annotations

import numpy as np
import pytest

import spacar
from spacar.dynamics.array_evaluator import Dynamics
from spacar.kinematics.constraint_condition import Conditioning, condition_number
from spacar.mechanism.build import build


def cantilever(n: int) -> spacar.Deck:
    """n beams in a row, bending only."""
    kinematics = [("PLBEAM", k, 2 * k - 1, 2 * k, 2 * k + 1, 2 * k + 2) for k in range(1, n + 1)]
    kinematics += [("X", 2 * k + 1, k / n, 0.0) for k in range(n + 1)]
    kinematics += [("FIX", 1), ("FIX", 2), *(("DYNE", k, 2, 3) for k in range(1, n + 1))]
    dynamics = [("EM", k, 1.0) for k in range(1, n + 1)] + [("ESTIFF", k, 0.0, 1.0) for k in range(1, n + 1)]
    return spacar.Deck.build(kinematics, dynamics, mode=7)


@pytest.mark.parametrize("n", [1, 8, 30])
def test_is_above_the_number_and_near_it(n: int) -> None:
    """Dense and banded storage."""
    d = Dynamics(build(cantilever(n), 7))
    d.start()
    condition = Conditioning.of(d.kinematics)
    number = float(condition_number(d.kinematics))
    assert condition.number == number
    assert number * (1.0 - 1e-12) <= condition.at_most <= 3.0 * number


def test_is_infinite_where_there_is_no_inverse() -> None:
    d = Dynamics(build(cantilever(2), 7))
    d.start()
    d.kinematics.sweep.entries[:] = 0.0
    d.kinematics.velocity_system.factor(np.zeros(len(d.kinematics.velocity_take)))
    assert Conditioning.of(d.kinematics).at_most == np.inf


def test_of_the_first_step_whenever_it_is_asked_for() -> None:
    """The header holds that of the first stored configuration, and is the same in a run that looks at once."""
    result = spacar.run(7, cantilever(4))
    d = Dynamics(build(cantilever(4), 7))
    d.start()
    assert result.header["condition"] == pytest.approx(float(condition_number(d.kinematics)), rel=1e-9)
