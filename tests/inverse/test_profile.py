"""Velocity profiles: theory-system.md (21) against quadrature of the acceleration, and the rules for what is not
given.
"""

from itertools import pairwise

import numpy as np
import pytest

from spacar.inverse.profile import IllegalProfile, make_profile

# rise, speed as in TRVMAX; expected rise, decline, speed for length 1.2 in 2 s
RULES = [
    ((0.3, 0.8), (0.3, 2 * (2 - 1.5) - 0.3, 0.8)), ((0.0, 0.8), (0.5, 0.5, 0.8)), ((-1.0, 0.8), (0.5, 0.5, 0.8)),
    ((0.3, None), (0.3, 1.7, 1.2)), ((None, None), (1.0, 1.0, 1.2)), ((0.0, None), (1.0, 1.0, 1.2)),
]  # fmt: skip


@pytest.mark.parametrize(("given", "expected"), RULES)
def test_what_is_not_given_follows(given, expected):
    p = make_profile(1.2, 2.0, *given)
    assert (p.rise, p.decline, p.speed) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("front", [0, 1, 2])
@pytest.mark.parametrize("given", [rule[0] for rule in RULES])
def test_position_and_velocity_are_the_integrals_of_the_acceleration(front, given):
    from scipy.integrate import quad

    p = make_profile(1.2, 2.0, *given, front)
    pieces = p.breaks

    def integral(k, t):
        ends = [*[b for b in pieces if b < t], t]
        return sum(quad(lambda s: p.at(s)[k], a + 1e-12, b - 1e-12, epsabs=1e-13)[0] for a, b in pairwise(ends))

    for t in (0.1, 0.3, 0.9, 1.5, 1.95, 2.0):
        value, rate, _ = p.at(t)
        # The quadrature leaves out 2e-12 s per piece, with accelerations of at most 6.
        assert integral(2, t) == pytest.approx(rate, abs=1e-10)
        assert integral(1, t) == pytest.approx(value, abs=1e-10)
    assert p.at(2.0)[0] == pytest.approx(1.2, abs=1e-15)
    assert p.at(2.0)[1] == pytest.approx(0.0, abs=1e-15)


def test_acceleration_at_the_joint_of_two_phases_is_that_of_the_later_one():
    p = make_profile(1.2, 2.0, 0.0, 0.8)
    assert p.at(0.0)[2] == pytest.approx(1.6)
    assert p.at(0.5)[2] == 0.0
    assert p.at(0.1 + 0.4)[2] == p.at(np.nextafter(0.5, 0))[2] == 0.0
    assert p.at(1.5)[2] == pytest.approx(-1.6)
    assert p.at(2.0)[2] == pytest.approx(-1.6)


def test_the_robot_of_the_figure_and_a_path_without_length():
    assert make_profile(float(np.hypot(0.536, 1.3)), 1.0, 0.2, 1.76).decline == pytest.approx(0.202087, abs=5e-7)
    assert make_profile(0.0, 2.0, 0.3, 1.0).at(1.0) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("rise", "speed", "why"),
    [
        (0.3, 0.5, "above 0.648648649 and at most 1.2"), (0.3, 1.3, "at most 1.2"), (0.0, 0.5, "above 0.6"),
        *((rise, speed, "shorter than the total time") for rise, speed in ((2.5, None), (2.0, None), (2.5, 1.0))),
    ],
)  # fmt: skip
def test_impossible_numbers_are_explained(rise, speed, why):
    with pytest.raises(IllegalProfile, match=r"illegal velocity profile: path length 1\.2, time 2 s") as error:
        make_profile(1.2, 2.0, rise, speed)
    assert why in str(error.value)
