"""Mode 2: nominal inputs against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

import spacar
from spacar.errors import AnalysisError, InputError, UsageError
from spacar.inverse.profile import make_profile

from . import arm

END = np.array([-0.1, 0.75])
LENGTH = float(np.linalg.norm(END - arm.START))
UNIT = (END - arm.START) / LENGTH


def line(front, steps=40):
    return [
        ("TRAJECT", 1), ("TRANS", 7, *map(float, END)), ("TRVMAX", 7, 0.3, 1.3), ("TRFRONT", 7, front),
        ("TRTIME", 1.0, steps), *arm.MOTORS, *arm.REFERENCES,
    ]  # fmt: skip


def closed_form(profile, t):
    p, rate, acceleration = profile.at(t)
    return arm.joints(arm.START + p * UNIT, rate * UNIT, acceleration * UNIT)


@pytest.mark.parametrize("front", [0, 1, 2])
def test_torques_on_a_straight_line_equal_the_closed_form(front):
    """1e-10 of the largest torque: rounding of two position iterations and one linear system."""
    result = spacar.run(2, arm.deck(arm.END_POINT, line(front)))
    profile = make_profile(LENGTH, 1.0, 0.3, 1.3, front)
    expected = np.array([arm.torques(*closed_form(profile, t)) for t in result.t])
    assert result["u0"] == pytest.approx(expected, abs=1e-10 * np.max(np.abs(expected)))
    # the stress of an actuated joint is minus the driving moment; the end point is not held any more
    assert result.element(1, 1, "sig") == pytest.approx(-expected[:, 0], abs=1e-9)
    assert result.node(7, 1, "fxtot") == pytest.approx(0.0, abs=1e-8)
    y0 = np.column_stack((result.element(1, 1), result.element(2, 1), result.node(7, 1), result.node(7, 1, "xd")))
    assert np.array_equal(result["y0"], y0)
    assert len(result.t) == 41


@pytest.mark.parametrize("front", [0, 1, 2])
def test_prescribed_joints_need_the_same_torques(front):
    """The multiplier of a prescribed joint (TRE), and theory-system.md (23) for a prescribed end point, agree."""
    by_joints = [
        ("TRAJECT", 1), ("TRE", 1, 0.5), ("TRE", 2, -0.8), ("TREPMAX", 2, 0.3, 1.0), ("TRFRONT", 1, front),
        ("TRTIME", 1.0, 10), *arm.MOTORS,
    ]  # fmt: skip
    result = spacar.run(2, arm.deck(arm.PRESCRIBED_JOINTS, by_joints))
    first, second = make_profile(0.5, 1.0, None, None, front), make_profile(0.8, 1.0, 0.3, 1.0)
    for t, u0 in zip(result.t, result["u0"], strict=True):
        a, b = np.array(first.at(t)), -np.array(second.at(t))
        q, qd, qdd = (np.array([a[k], b[k]]) for k in range(3))
        assert u0 == pytest.approx(arm.torques(arm.Q0 + q, qd, qdd), rel=1e-10)
    assert result.element(1, 1, "sig") == pytest.approx(-result["u0"][:, 0], rel=1e-12)


def test_spring_and_damper_of_an_actuated_joint_are_passive():
    """u0 is what the motor adds: its torque grows by the torque of the spring and the damper beside it."""
    third = [("TRAJECT", 1), ("TRE", 1, 0.5), ("TRE", 2, -0.8), ("TRTIME", 1.0, 10), *arm.MOTORS]
    plain = spacar.run(2, arm.deck(arm.PRESCRIBED_JOINTS, third))
    elastic = [*arm.DYNAMICS, ("ESTIFF", 1, 20.0), ("EDAMP", 1, 3.0)]
    result = spacar.run(2, arm.deck(arm.PRESCRIBED_JOINTS, third, dynamics=elastic))
    extra = 20.0 * result.element(1, 1) + 3.0 * result.element(1, 1, "ed")
    assert result["u0"][:, 0] == pytest.approx(plain["u0"][:, 0] + extra, rel=1e-12)
    assert result["u0"][:, 1] == pytest.approx(plain["u0"][:, 1], rel=1e-12)


def pendulum(third):
    """Mass 2 kg at 0.6 m on a prescribed joint."""
    kinematics = [("PLTOR", 1, 1, 2), ("PLBEAM", 2, 3, 2, 4, 5), ("X", 3, 0.0, 0.0), ("X", 4, 0.6, 0.0)]
    kinematics += [("FIX", 1), ("FIX", 3), ("INPUTE", 1, 1)]
    dynamics = [("XM", 4, 2.0), ("GRAVITY", 0.0, -10.0)]
    return spacar.Deck.build(kinematics, dynamics, third, mode=2, source="pendulum.dat")


def test_trajectories_follow_each_other_and_extra_loads_act_during_theirs():
    third = [
        ("TRAJECT", 1), ("TRE", 1, 0.4), ("TRTIME", 0.5, 5),
        ("TRAJECT", 2), ("TRE", 1, 0.0), ("TRTIME", 0.25, 5, 2), ("NOMS", 1, 1, 1),
    ]  # fmt: skip
    result = spacar.run(2, pendulum(third))
    assert result.t == pytest.approx(np.concatenate((np.linspace(0, 0.5, 6), 0.5 + np.linspace(0, 0.25, 11)[1:])))
    assert result.element(1, 1)[5:] == pytest.approx(0.4, abs=1e-14)
    weight = 2.0 * 10.0 * 0.6 * np.cos(0.4)
    assert result["u0"][6:, 0] == pytest.approx(weight, rel=1e-12)


def test_extra_mass_and_force():
    def torque(statement):
        stay = ("TRANS", 7, *map(float, arm.START))
        third = [("TRAJECT", 1), stay, ("TRTIME", 0.1, 1)]
        third += [("TRAJECT", 3), stay, statement, ("TRTIME", 0.1, 2), *arm.MOTORS]
        return spacar.run(2, arm.deck(arm.END_POINT, third))["u0"]

    rest = arm.torques(arm.Q0, np.zeros(2), np.zeros(2))
    arms = np.array([arm.START[0], arm.START[0] - arm.elbow_and_tip(arm.Q0)[0][0]])  # of a vertical force at the tip
    loaded = torque(("TRM", 7, 1.5))
    assert loaded[:2] == pytest.approx(np.array([rest, rest]), rel=1e-12)
    assert loaded[2:] == pytest.approx(np.array(2 * [rest + 1.5 * arm.G * arms]), rel=1e-12)
    pulled = torque(("TRF", 7, 0.0, 8.0))
    assert pulled[2:] == pytest.approx(np.array(2 * [rest - 8.0 * arms]), rel=1e-12)


def test_extra_inertia_of_an_orientation_node():
    """Accelerating the elbow joint needs J times the acceleration more."""
    # TRM goes with the path of a node: prescribe the orientation of the arm instead of the joint
    kinematics = [("PLBEAM", 2, 3, 2, 4, 5), ("X", 3, 0.0, 0.0), ("X", 4, 0.6, 0.0), ("FIX", 3), ("INPUTX", 2, 1)]
    third = [("TRAJECT", 1), ("TROT", 2, 0.4), ("TRM", 2, 0.3), ("TRTIME", 0.5, 2)]
    third += [("NOMF", 1, 2, 1), ("REFX", 1, 2, 1)]
    result = spacar.run(2, spacar.Deck.build(kinematics, [("XM", 4, 2.0)], third, mode=2))
    acceleration = 2 * 0.4 / 0.5 / 0.25
    assert result["u0"][0, 0] == pytest.approx((2.0 * 0.6**2 + 0.3) * acceleration, rel=1e-12)
    assert result["y0"][:, 0] == pytest.approx([0.0, 0.2, 0.4], abs=1e-14)


def test_force_input_is_the_reaction_of_a_prescribed_coordinate():
    third = [*line(2)[:5], ("NOMF", 1, 7, 1), ("NOMF", 2, 7, 2)]
    result = spacar.run(2, arm.deck(arm.END_POINT, third))
    profile = make_profile(LENGTH, 1.0, 0.3, 1.3, 2)
    for t, u0 in zip(result.t, result["u0"], strict=True):
        q, qd, qdd = closed_form(profile, t)
        a, b = q[0], q[0] + q[1]
        J = np.array([[-arm.L1 * np.sin(a) - arm.L2 * np.sin(b), -arm.L2 * np.sin(b)],
                      [arm.L1 * np.cos(a) + arm.L2 * np.cos(b), arm.L2 * np.cos(b)]])  # fmt: skip
        assert u0 == pytest.approx(np.linalg.solve(J.T, arm.torques(q, qd, qdd)), rel=1e-9)
    assert result.node(7, 1, "fxtot") == pytest.approx(result["u0"][:, 0], rel=1e-9)


def test_too_few_and_too_many_inputs():
    few = spacar.run(2, arm.deck(arm.END_POINT, [*line(2)[:5], ("NOMS", 1, 1, 1)]))
    assert any("fewer than the degrees of freedom" in line for line in few.report)
    many = spacar.run(2, arm.deck(arm.END_POINT, [*line(2)[:5], *arm.MOTORS, ("NOMF", 3, 7, 1)]))
    assert any("3 nominal inputs for 2" in line for line in many.report)
    twice = arm.deck(arm.END_POINT, [*line(2)[:5], ("NOMS", 1, 1, 1), ("NOMS", 2, 1, 1)])
    with pytest.raises(AnalysisError, match="control only 1 of 2 degrees of freedom at t = 0"):
        spacar.run(2, twice)


def test_user_trajectory(tmp_path):
    (tmp_path / "mytraj.py").write_text(
        "import math\ndef mytraj(t, step):\n"
        "    return t, [(1, 1, 0.1 * math.sin(t), 0.1 * math.cos(t), -0.1 * math.sin(t))], []\n"
    )
    third = [("TRAJECT", 1), ("USERTRAJ", "mytraj"), ("TRTIME", 2.0, 8), ("NOMS", 1, 1, 1)]
    result = spacar.run(2, replace(pendulum(third), path=tmp_path / "pendulum.dat"))
    q, qdd = 0.1 * np.sin(result.t), -0.1 * np.sin(result.t)
    expected = 2.0 * 0.36 * qdd + 2.0 * 10.0 * 0.6 * np.cos(q)
    # the position iteration ends below 1e-11, and V is that of its last but one iterate
    assert result["u0"][:, 0] == pytest.approx(expected, rel=1e-11)


def test_circle_in_the_plane():
    """The distance to the centre stays; the velocity is that of the profile."""
    centre = arm.START + np.array([-0.1, 0.0])
    ends = map(float, (*centre, *(centre + np.array([0.0, 0.2]))))
    third = [("TRAJECT", 1), ("TRCIRL", 7, *ends), ("TRTIME", 1.0, 10)]
    result = spacar.run(2, arm.deck(arm.END_POINT, third))
    tip = np.column_stack((result.node(7, 1), result.node(7, 2)))
    assert np.linalg.norm(tip - centre, axis=1) == pytest.approx(0.1, abs=1e-13)
    assert tip[-1] == pytest.approx(centre + np.array([0.0, 0.1]), abs=1e-13)
    speed = np.hypot(result.node(7, 1, "xd"), result.node(7, 2, "xd"))
    profile = make_profile(0.1 * np.pi / 2, 1.0)
    assert speed == pytest.approx([profile.at(t)[1] for t in result.t], abs=1e-12)


# -- errors ---------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("driven", "path", "kind", "why"),
    [
        (arm.PRESCRIBED_JOINTS, ("TRANS", 7, 0.1, 0.2), InputError,
         "TRANS moves all its coordinates and needs INPUTX 7 1 2"),
        (arm.END_POINT, ("TRE", 1, 0.2), InputError, "TRE needs INPUTE 1 1"),
        (arm.END_POINT, ("TRCIRL", 7, *map(float, arm.START), 0.3, 0.3), InputError, "radius is zero"),
        ([("INPUTE", 1, 1), ("DYNE", 2, 1)], ("TRE", 1, 0.2), UsageError,
         r"element 2 \(PLTOR\) e1 .* is dynamic; use INPUTX or INPUTE"),
        (arm.END_POINT, ("TRANS", 7, 2.0, 0.0), AnalysisError, r"t = 0\.\d+"),  # an end that cannot be reached
    ],
)  # fmt: skip
def test_path_that_does_not_match_the_degrees_of_freedom(driven, path, kind, why):
    with pytest.raises(kind, match=why):
        spacar.run(2, arm.deck(driven, [("TRAJECT", 1), path, ("TRTIME", 1.0, 4)]))


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (("TRVMAX", 7, 0.3, 5.0),
         "TRVMAX 7: illegal velocity profile: path length .*time 1 s, rise time 0.3 s, speed 5"),
        (("TRVMAX", 7, 0.3, 0.2), "the speed must be above"),
        (("TRVMAX", 7, 1.2), "shorter than the total time"),
    ],
)  # fmt: skip
def test_wrong_profile(change, why):
    third = [change if s[0] == "TRVMAX" else s for s in line(0)]
    with pytest.raises(InputError, match=why):
        spacar.run(2, arm.deck(arm.END_POINT, third))


def test_speed_for_a_path_of_no_length_is_mentioned():
    third = [("TRAJECT", 1), ("TRE", 1, 0.0), ("TREPMAX", 1, 0.1, 1.0), ("TRTIME", 1.0, 2)]
    report = spacar.run(2, pendulum(third)).report
    assert any("TRE 1 does not move, so TREPMAX 1 is not used" in line for line in report)
