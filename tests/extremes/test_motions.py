"""Motions at the extremes, each against the physical truth: many turns, mass ratios, short pulses, units, Radau."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import spacar
from spacar.deck import parse_deck

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
