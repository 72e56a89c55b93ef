"""Motions at the extremes, each against the physical truth: many turns, mass ratios, short pulses, units, Radau."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import spacar
from spacar.deck import parse_deck
from spacar.errors import AnalysisError

# Crank 0.15 m, 0.2225 kg/m; rod 0.30 m, slider 0.033375 kg; no gravity, no torque: the crank angle obeys energy.
CRANK = """
PLBEAM 1 1 2 3 4   PLBEAM 2 3 5 6 7   X 3 0.15 0.   X 6 0.45 0.   FIX 1   FIX 6 2   DYNX 2 1
END HALT
EM 1 0.2225   EM 2 0.2225   XM 6 0.033375   STARTDX 2 1 0. 30.
TIMESTEP {duration!r} {steps}   INTEGRAT 853   ERROR {error} {error}   END END
"""


def reduced_inertia(phi):
    """J(phi) of T = J phi'^2 / 2 [kg m^2]: uniform rods of 0.15 m and 0.30 m with 0.2225 kg/m, slider."""
    r, length, m = 0.15, 0.30, 0.2225
    m1, m2, slider = m * r, m * length, 0.033375
    s, c = np.sin(phi), np.cos(phi)
    beta = np.arcsin(r * s / length)  # the rod goes down from the pin
    rate = r * c / (length * np.cos(beta))
    pin = np.array([-r * s, r * c])
    end = np.array([-r * s - length * np.sin(beta) * rate, np.zeros_like(phi)])
    square = (pin**2).sum(0) + (end**2).sum(0) + (pin * end).sum(0)  # of a uniform rod, times 3 / m
    return m1 * r**2 / 3.0 + m2 * square / 3.0 + slider * end[0] ** 2


def mean_inverse_speed():
    """Time of one turn [s]: the integral of sqrt(J(phi)/J(0))/30 over the turn; exact for the periodic integrand."""
    phi = np.arange(4096) * 2.0 * np.pi / 4096
    return float(np.sqrt(reduced_inertia(phi) / reduced_inertia(np.zeros(1))).mean() * 2.0 * np.pi / 30.0)


@pytest.mark.parametrize(("turns", "error"), [(20, 1e-8), pytest.param(10_000, 1e-9, marks=pytest.mark.slow)])
def test_the_phase_of_a_crank_after_many_turns(turns, error):
    """After so many times the time of one turn (a quadrature) the crank is back at 0, with the speed of the start."""
    period = mean_inverse_speed()
    result = spacar.run(1, parse_deck(CRANK.format(duration=turns * period, steps=10, error=error), mode=1))
    phase = result.node(2, 1)[-1] - 2.0 * np.pi * turns
    assert abs(phase) < 2.0 * np.pi * turns * 100.0 * error
    assert abs(phase) < 1e-3
    speed = 30.0 * float(np.sqrt(reduced_inertia(np.zeros(1)) / reduced_inertia(np.array([phase])))[0])  # energy
    assert result.node(2, 1, "xd")[-1] == pytest.approx(speed, rel=100.0 * error)


@pytest.mark.parametrize("ratio", [1e-12, 1e12])
def test_masses_in_a_ratio_of_1e12(ratio):
    """Two masses on a truss in free space: omega^2 = k (1/m1 + 1/m2), and the centre of gravity stays where it is."""
    m1, m2, k, a = 1.0, ratio, 100.0, 1e-3
    omega = np.sqrt(k * (1.0 / m1 + 1.0 / m2))
    period = float(2.0 * np.pi / omega)
    text = f"""
PLTRUSS 1 1 2   X 2 1. 0.   FIX 1 2   FIX 2 2   DYNX 1 1   DYNE 1 1   END HALT
XM 1 {m1!r}   XM 2 {m2!r}   ESTIFF 1 {k!r}
STARTDE 1 1 {a!r} 0.   STARTDX 1 1 0. 0.   TIMESTEP {period!r} 40   INTEGRAT 853   ERROR 1e-12 1e-12
END END
"""
    result = spacar.run(1, parse_deck(text, mode=1))
    stretch = result.element(1, 1)
    assert np.abs(stretch - a * np.cos(omega * result.t)).max() < 1e-9 * a
    centre = (m1 * result.node(1, 1) + m2 * result.node(2, 1)) / (m1 + m2)
    assert np.ptp(centre) < 1e-11


PULSE = """
PLTRUSS 1 1 2   X 2 1. 0.   FIX 1   FIX 2 2   DYNE 1 1   END HALT
XM 2 2.   ESTIFF 1 200.   USERSIG pulse   TIMESTEP 1. 50   INTEGRAT {code}   ERROR 1e-9 1e-9
END END
"""
FORCE = """
breaks = (0.1003, 0.1003 + 1e-6)


def pulse(t, ne, le, e, ep, nx, lnp, x, xp):
    return t, [], [[2, 1, 2e3]] if breaks[0] <= t <= breaks[1] else []
"""


@pytest.mark.parametrize("code", [0, 155, 853, 595])
def test_a_load_of_one_microsecond(code, tmp_path):
    """2 kN during 1e-6 s on 2 kg: an impulse of 2e-3 N s. Exact: the step response from the start of the pulse less
    that from its end, x = F/k (cos w (t - t2) - cos w (t - t1)), w = 10 rad/s. `breaks` says where the force jumps."""
    (tmp_path / "hit.dat").write_text(PULSE.format(code=code))
    (tmp_path / "pulse.py").write_text(FORCE)
    result = spacar.run(1, tmp_path / "hit.dat")
    w, t1, t2 = 10.0, 0.1003, 0.1003 + 1e-6
    after = result.t > t2
    exact = np.where(after, 2e3 / 200.0 * (np.cos(w * (result.t - t2)) - np.cos(w * (result.t - t1))), 0.0)
    assert np.abs(exact).max() > 9e-5
    assert np.abs(result.element(1, 1) - exact).max() < 1e-6 * np.abs(exact).max()


def test_breaks_that_are_no_times_are_refused(tmp_path):
    from spacar.errors import InputError

    (tmp_path / "hit.dat").write_text(PULSE.format(code=0))
    (tmp_path / "pulse.py").write_text(FORCE.replace("(0.1003, 0.1003 + 1e-6)", "'soon'", 1))
    with pytest.raises(InputError, match=r"breaks of .* must be a list of times"):
        spacar.run(1, tmp_path / "hit.dat")


def test_the_reduced_crank_is_the_crank():
    """The truth of the phase itself: phi'' = -J' phi'^2 / (2 J) by a code that knows nothing of mechanisms."""

    def rate(_, y):
        d = 1e-6
        slope = (reduced_inertia(y[:1] + d) - reduced_inertia(y[:1] - d))[0] / (2.0 * d)
        return [y[1], -0.5 * slope * y[1] ** 2 / reduced_inertia(y[:1])[0]]

    period = mean_inverse_speed()
    found = solve_ivp(rate, (0.0, period), [0.0, 30.0], "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    assert found == pytest.approx([2.0 * np.pi, 30.0], rel=1e-7)


# Free bodies that tumble with Euler parameters as dynamic coordinates, through any attitude: Euler's equations.
J = np.array([0.02, 0.03, 0.05])
RATES = np.array([0.2, 10.0, 0.2])  # about the middle axis: the body flips over again and again
BODY = """
RBEAM 1 1 2 3   X 3 1. 0. 0.   DYNX 1   DYNX 2   END HALT
EM 1 0.   XM 1 2.   XM 2 0.02 0. 0. 0.03 0. 0.05
STARTDX 1 1 0. 1.   STARTDX 2 2 0. 0.1   STARTDX 2 3 0. 5.   STARTDX 2 4 0. 0.1
TIMESTEP 10. {steps}   ERROR 1e-10 1e-10   INTEGRAT 853   END END
"""


def euler(times):
    """lambda (4, times) of J w' = (J w) x w, lambda' = 1/2 lambda o w, with w in the body."""

    def rate(_, y):
        w, (l0, l1, l2, l3) = y[:3], y[3:]
        turn = 0.5 * np.array(
            [
                -l1 * w[0] - l2 * w[1] - l3 * w[2],
                l0 * w[0] - l3 * w[1] + l2 * w[2],
                l3 * w[0] + l0 * w[1] - l1 * w[2],
                -l2 * w[0] + l1 * w[1] + l0 * w[2],
            ]
        )
        return np.concatenate((np.cross(J * w, w) / J, turn))

    start = np.concatenate((RATES, [1.0, 0.0, 0.0, 0.0]))
    return solve_ivp(rate, (0.0, times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-13).y[3:]


def attitude(result, variable="x"):
    return np.array([result.node(2, k, variable) for k in (1, 2, 3, 4)])


@pytest.mark.parametrize("compiled", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_body_tumbles_through_any_attitude(compiled):
    """16 turns and several flips; all four parameters pass zero. The error is that of ERROR over 100 radians."""
    result = spacar.run(1, parse_deck(BODY.format(steps=200), mode=1), compiled=compiled)
    exact = euler(result.t)
    assert (attitude(result).min(axis=1) < -0.9).all()
    assert np.abs(attitude(result) - exact).max() < 1e-8
    assert np.abs(np.sum(attitude(result) ** 2, axis=0) - 1.0).max() < 1e-14
    np.testing.assert_allclose(result.node(1, 1), result.t, atol=1e-9)
    assert sum("comes near 180 degrees" in line for line in result.report) == 1


def test_rates_and_accelerations_go_on_through_the_changes():
    """Energy and angular momentum from lambda and its rate: 1e-9 over 16 turns; no jump of an acceleration."""
    result = spacar.run(1, parse_deck(BODY.format(steps=2000), mode=1))
    l0, l1, l2, l3 = attitude(result)
    v0, v1, v2, v3 = attitude(result, "xd")
    w = 2.0 * np.array(
        [
            l0 * v1 - l1 * v0 + l3 * v2 - l2 * v3,
            l0 * v2 - l2 * v0 - l3 * v1 + l1 * v3,
            l0 * v3 - l3 * v0 + l2 * v1 - l1 * v2,
        ]
    )
    energy, momentum = 0.5 * J @ w**2, np.linalg.norm(J[:, None] * w, axis=0)
    assert np.ptp(energy) < 1e-9 * energy[0]
    assert np.ptp(momentum) < 1e-9 * momentum[0]
    a = attitude(result, "xdd")
    assert np.abs(np.diff(a, 2)).max() < 5e-3 * np.abs(a).max()  # smooth: (omega dt)^2


def test_outputs_far_apart_are_the_same():
    """Many changes of the dependent parameter between two outputs."""
    fine, coarse = (spacar.run(1, parse_deck(BODY.format(steps=n), mode=1)) for n in (200, 2))
    assert np.abs(attitude(coarse) - attitude(fine)[:, ::100]).max() < 1e-8


def test_a_start_near_half_a_turn():
    """179.9 degrees about the z axis at the start: that chart would lose three digits."""
    half = np.radians(179.9) / 2
    text = BODY.format(steps=50).replace("STARTDX 2 4 0. 0.1", f"STARTDX 2 4 {float(np.sin(half))!r} 0.")
    text = text.replace("STARTDX 2 3 0. 5.", f"STARTDX 2 3 0. {float(5.0 * np.cos(half))!r}")
    text = text.replace("STARTDX 2 2 0. 0.1", "STARTDX 2 2 0. 5.")
    result = spacar.run(1, parse_deck(text.replace("TIMESTEP 10.", "TIMESTEP 1."), mode=1))
    assert np.abs(np.sum(attitude(result) ** 2, axis=0) - 1.0).max() < 1e-14
    assert result.t[-1] == 1.0


def test_two_bodies_change_each_at_its_time():
    """Independent bodies with other speeds: each moves as alone."""
    first = BODY.format(steps=20).replace("TIMESTEP 10.", "TIMESTEP 2.")
    rows = "RBEAM 2 4 5 6\nX 4 0. 5. 0.\nX 6 1. 5. 0.\nDYNX 4\nDYNX 5\nEND HALT"
    more = "EM 2 0.\nXM 4 1.\nXM 5 0.02 0. 0. 0.03 0. 0.05\nSTARTDX 5 2 0. 3.\nSTARTDX 5 4 0. 2.\nTIMESTEP"
    both = spacar.run(1, parse_deck(first.replace("END HALT", rows).replace("TIMESTEP", more), mode=1))
    alone = spacar.run(1, parse_deck(first, mode=1))
    assert np.abs(attitude(both) - attitude(alone)).max() < 1e-8


def test_linearized_motions_go_on_too():
    """Mode 4 linearizes in the degrees of freedom of the model wherever the body is. The same matrices as of a motion
    that starts there (lambda and -lambda are one attitude; with lambda0 > 0 as every start has it)."""
    moved = spacar.run(4, parse_deck(BODY.format(steps=20), mode=4))
    lam, rate = attitude(moved), attitude(moved, "xd")
    np.testing.assert_allclose(lam, attitude(spacar.run(1, parse_deck(BODY.format(steps=20), mode=1))), atol=1e-9)
    later = [k for k in range(1, 21) if 0.05 < abs(lam[0, k]) < 0.9 and moved.t[k] > 2.0]
    assert min(lam[0, later]) < 0.0
    for k in later[:4]:
        sign = np.sign(lam[0, k])
        text = BODY.format(steps=1)
        for c, place in ((2, "0. 0.1"), (3, "0. 5."), (4, "0. 0.1")):
            value = f"{float(sign * lam[c - 1, k])!r} {float(sign * rate[c - 1, k])!r}"
            text = text.replace(f"STARTDX 2 {c} {place}", f"STARTDX 2 {c} {value}")
        there = spacar.run(4, parse_deck(text.replace("TIMESTEP 10.", "TIMESTEP 1e-6"), mode=4))
        names = {"m0", "c0", "k0", "n0", "d0"} & set(there.frames[0].matrices)
        assert {"m0", "k0"} <= names
        for name in names:
            a, b = moved[name][k], there[name][0]
            np.testing.assert_allclose(a, b, atol=1e-6 * max(np.abs(b).max(), 1.0), err_msg=f"{name} at {k}")


def test_an_output_at_half_a_turn_has_no_such_coordinates():
    """180 degrees about z exactly at the first output: lambda3 = sin(5 t), t = pi/10."""
    text = BODY.format(steps=1).replace("STARTDX 2 2 0. 0.1   STARTDX 2 3 0. 5. ", "").replace("4 0. 0.1", "4 0. 5.")
    text = text.replace("TIMESTEP 10.", f"TIMESTEP {np.pi / 10!r}")
    assert spacar.run(1, parse_deck(text, mode=1)).node(2, 4)[-1] == pytest.approx(1.0)
    with pytest.raises(AnalysisError, match="180 degrees at this output"):
        spacar.run(4, parse_deck(text, mode=4))


def test_transfer_functions_beyond_half_a_turn():
    """OUTLEVEL 1 1 in mode 1: dx of the fourth parameter by the others is -lambda_i/lambda0, whatever the attitude."""
    deck = parse_deck(BODY.format(steps=20).replace("END HALT", "OUTLEVEL 1 1\nEND HALT"), mode=1)
    result = spacar.run(1, deck)
    lam = attitude(result)
    n = result.mechanism.numbering
    row = n.x_index(2, 1)
    columns = [n.x_index(2, c) - n.x_class["dynamic"].start for c in (2, 3, 4)]
    assert min(lam[0]) < -0.5
    for k, frame in enumerate(result.frames):
        if abs(lam[0, k]) > 1e-3:
            dx = np.asarray(result["dx"][k])[row, columns]
            np.testing.assert_allclose(dx, -lam[1:, k] / lam[0, k], rtol=1e-9, atol=1e-9)
            assert frame.t == result.t[k]


@pytest.mark.parametrize("compiled", [True, False])
def test_one_dynamic_parameter_ends_at_half_a_turn(compiled):
    """A hinge about z gives the other two; small steps stop there, and the message says what passes."""
    text = """
HINGE 1 1 2 0. 0. 1.   FIX 1   RLSE 1 1   DYNX 2 4   END HALT
XM 2 1. 0. 0. 1. 0. 1.   STARTDX 2 4 0. 0.5   TIMESTEP 4. 400   INTEGRAT 140 0.01   END END
"""
    with pytest.raises(AnalysisError, match=r"make all three dynamic \(DYNX 2\) if it turns freely, else .* HINGE"):
        spacar.run(1, parse_deck(text, mode=1), compiled=compiled)
