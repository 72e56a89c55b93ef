"""Time-varying linear systems: exact propagation, measured order, modal reduction, folded gains."""

from dataclasses import replace

import numpy as np
import pytest

from spacar import simulation as sim
from spacar.errors import AnalysisError, UsageError
from tests.examples import DATA


def oscillator(times, stiffness, force=1.0):
    """q'' + 0.2 q' + k(t) q = u, output q."""
    steps = len(times)
    k = np.array([stiffness(t) for t in times])
    A = np.zeros((steps, 2, 2))
    A[:, 0, 1], A[:, 1, 0], A[:, 1, 1] = 1.0, -k, -0.2
    eye = np.ones((steps, 1, 1))
    return sim.TimeVarying(
        "oscillator", times, A=A, B=np.tile([[0.0], [1.0]], (steps, 1, 1)), C=np.tile([[1.0, 0.0]], (steps, 1, 1)),
        m0=eye, c0b=0.2 * eye, k0b=k[:, None, None], sigma0=np.full((steps, 1), force), x0=np.array([1.0, 0.0]),
    )  # fmt: skip


def closed_form(t, k, force):
    """Free oscillation about force/k from rest at 1."""
    d = 0.1
    w = np.sqrt(k - d * d)
    return force / k + (1 - force / k) * np.exp(-d * t) * (np.cos(w * t) + d / w * np.sin(w * t))


@pytest.mark.parametrize("interpolation", ["linear", "step"])
def test_constant_system_is_exact_for_any_step(interpolation):
    times = np.array([0.0, 0.7, 2.0, 5.0])
    data = oscillator(times, lambda t: 9.0, 2.0)
    assert sim.simulate_ltv(data, interpolation=interpolation).y[:, 0] == pytest.approx(
        closed_form(times, 9.0, 2.0), abs=1e-13
    )


def test_linear_input_is_exact():
    """q'' + 0.2 q' + 9 q = 9 t + 0.2 has the solution t (start rate 1)."""
    times = np.array([0.0, 1.3, 4.0])
    data = replace(oscillator(times, lambda t: 9.0), x0=np.array([0.0, 1.0]))
    assert sim.simulate_ltv(data, (9.0 * times + 0.2)[:, None]).y[:, 0] == pytest.approx(times, abs=1e-13)


def test_order_of_the_linear_interpolation_is_four():
    times = np.linspace(0.0, 4.0, 3)
    data = oscillator(times, lambda t: 5.0 + 4.0 * t)
    exact = sim.simulate_ltv(data, substeps=512).y[-1, 0]
    errors = [abs(sim.simulate_ltv(data, substeps=n).y[-1, 0] - exact) for n in (16, 32, 64)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([4.0, 4.0], abs=0.2)


def test_stepwise_changes_half_way():
    times = np.array([0.0, 1.0])
    data = oscillator(times, lambda t: 4.0 if t < 0.5 else 16.0, 0.0)
    half = sim.simulate_ltv(oscillator(np.array([0.0, 0.5]), lambda t: 4.0, 0.0)).z[-1]
    end = sim.simulate_ltv(replace(oscillator(np.array([0.0, 0.5]), lambda t: 16.0, 0.0), x0=half)).z[-1]
    assert sim.simulate_ltv(data, interpolation="step").z[-1] == pytest.approx(end, abs=1e-14)


def test_block_and_propagation_agree():
    """The block Ltv in the engine and `simulate_ltv` solve the same problem (tolerance of the integration)."""
    data = oscillator(np.linspace(0.0, 3.0, 7), lambda t: 5.0 + np.sin(t))
    diagram = sim.Diagram().add(sim.Ltv(data), sim.Function("f", lambda t: 1.0, 0, 1)).connect("f", "ltv")
    r = sim.simulate(diagram, data.t, rtol=1e-10, atol=1e-12)
    assert r["ltv"] == pytest.approx(sim.simulate_ltv(data, substeps=40).y, abs=1e-7)


def test_system_that_overflows_is_a_failure():
    data = oscillator(np.linspace(0.0, 100.0, 11), lambda t: -1e4)
    with pytest.raises(AnalysisError, match="unstable: its states overflow at t ="):
        sim.simulate_ltv(data)


def test_wrong_inputs_are_refused():
    data = oscillator(np.linspace(0.0, 1.0, 3), lambda t: 1.0)
    with pytest.raises(UsageError, match=r"shape \(2, 1\), expected \(3, 1\)"):
        sim.simulate_ltv(data, np.zeros((2, 1)))
    with pytest.raises(UsageError, match=r"empty.ltv has no u0; it comes from"):
        sim.TimeVarying("empty.ltv", np.arange(2.0)).need("u0")


# -- reduction ------------------------------------------------------------------------------------------------------
def chain(n=5, steps=30):
    """Masses on springs whose stiffness changes smoothly; symmetric matrices."""
    times = np.linspace(0.0, 3.0, steps)
    M = np.diag(np.linspace(1.0, 2.0, n))
    K0 = 400.0 * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    K = np.array([K0 * (1 + 0.1 * np.sin(t)) + np.diag(np.linspace(0, 30 * np.cos(t), n)) for t in times])
    C = 0.01 * K
    mass = np.tile(M, (steps, 1, 1))
    A = np.zeros((steps, 2 * n, 2 * n))
    A[:, :n, n:] = np.eye(n)
    A[:, n:, :n], A[:, n:, n:] = -np.linalg.solve(mass, K), -np.linalg.solve(mass, C)
    force = np.zeros(n)
    force[2] = 1.0
    B = np.concatenate((np.zeros(n), np.linalg.solve(M, force)))[:, None]
    out = np.hstack((np.eye(n), np.zeros((n, n))))
    return sim.TimeVarying(
        "chain", times, A=A, B=np.tile(B, (steps, 1, 1)), C=np.tile(out, (steps, 1, 1)), m0=mass, c0b=C, k0b=K,
        sigma0=(1 - np.cos(times))[:, None] ** 2,
    )  # fmt: skip


def test_all_modes_kept_is_the_same_system():
    """With a constant mass matrix the followed basis is constant, so nothing is lost."""
    data = chain()
    full, reduced = sim.simulate_ltv(data), sim.simulate_ltv(sim.reduce_modes(data, 5).system)
    assert reduced.y == pytest.approx(full.y, abs=1e-12 * np.abs(full.y).max())


def test_error_falls_with_the_number_of_modes_and_with_the_quasi_static_answer():
    data = chain()
    full = sim.simulate_ltv(data).y
    size = np.abs(full).max()

    def error(*groups):
        return np.abs(sim.simulate_ltv(sim.reduce_modes(data, *groups).system).y - full).max() / size

    assert error(3) < error(2) < error(1) < 0.05
    assert error(2) < 0.1 * error(2, 0)


def test_groups_are_reported():
    r = sim.reduce_modes(chain(), 2, 1)
    assert (r.kept, r.static, r.dropped) == ((0, 1), (2,), (3, 4))
    assert r.report[0].startswith("kept: modes 1 (")
    assert r.report[2].startswith("dropped: modes 4 (")
    assert np.all(np.diff(r.rates[0]) > 0)
    with pytest.raises(UsageError, match="cannot be chosen from 5"):
        sim.reduce_modes(chain(), 3, 3)
    with pytest.raises(UsageError, match="reduced system"):
        sim.reduce_modes(r.system, 1)


def test_mode_without_stiffness_cannot_answer_statically():
    data = chain()
    flat = replace(data, k0b=data.k0b - 5000.0 * np.eye(5))
    with pytest.raises(AnalysisError, match="keep more modes, or fold a proportional gain"):
        sim.reduce_modes(flat, 1)


def test_crossing_modes_are_followed():
    """Two uncoupled oscillators whose frequencies cross: each keeps its number."""
    times = np.linspace(0.0, 1.0, 21)
    k = np.array([np.diag([1.0 + 3.0 * t, 3.0]) for t in times])
    eye = np.tile(np.eye(2), (21, 1, 1))
    from spacar.simulation.reduction import tracked_modes

    values, modes, overlap = tracked_modes(times, eye, k)
    assert values[:, 0] == pytest.approx(1.0 + 3.0 * times)
    assert np.abs(modes[:, 0, 0]) == pytest.approx(1.0)
    assert overlap == pytest.approx(1.0)


# -- gains ----------------------------------------------------------------------------------------------------------
def test_folded_gain_equals_feedback_around_the_system(robot):
    """with_gain against the closed loop du = -K_P de - K_D ded written with the rows of the state."""
    _, linear = robot
    kp, kd = np.diag([300.0, 200.0, 100.0]), np.diag([30.0, 20.0, 10.0])
    closed = sim.with_gain(linear, kp, kd)
    feedback = np.hstack((kp, kd))  # the joints are the degrees of freedom
    assert pytest.approx(linear.A - linear.B @ feedback, abs=1e-9) == closed.A
    assert closed.k0b - linear.k0b == pytest.approx(np.tile(kp, (len(linear.t), 1, 1)), abs=1e-9)
    assert np.array_equal(closed.B, linear.B)


def test_tracking_gains_give_the_wanted_poles(robot):
    """Without gravity and motion terms all eigenvalues would be those of s^2 + 2 beta w s + w^2."""
    _, linear = robot
    kp, kd = sim.tracking_gains(linear, 28.0, 0.85)
    assert kp == pytest.approx(28.0**2 * linear.m0, abs=1e-9)
    closed = sim.with_gain(linear, kp, kd)
    rest = closed.A[0].copy()
    rest[3:, :3] += np.linalg.solve(linear.m0[0], linear.k0b[0])
    expected = np.roots([1.0, 2 * 0.85 * 28.0, 28.0**2])
    found = np.linalg.eigvals(rest)
    assert np.sort(found.real) == pytest.approx(np.full(6, expected[0].real), rel=1e-6)


def test_wrong_gains_are_refused(robot):
    nominal, linear = robot
    for system, gain, said in (
        (linear, np.eye(2), r"K_P has the shape \(2, 2\); expected \(3, 3\)"),
        (linear, np.full((3, 3), np.nan), "not finite"), (nominal, np.eye(3), "has no A"),
    ):  # fmt: skip
        with pytest.raises(UsageError, match=said):
            sim.with_gain(system, gain)


# -- the perturbation method ----------------------------------------------------------------------------------------
def test_perturbation_method_against_the_nonlinear_simulation(flexible):
    """First 0.12 s of the flexible manipulator: the deviation is of second order in the deflection (relative 1e-2)."""
    plant = sim.Spasim(DATA / "robotflexsim.dat")
    nominal = replace(flexible, name="nominal")
    signals = {"positions": [1, 2, 3], "rates": [4, 5, 6]}
    law = sim.computed_torque(nominal, nominal, 28.0, 0.85, **signals, interpolation="spline")
    times = flexible.t[:13]
    start = {"plant": plant.start() + flexible.x0}
    full = sim.closed_loop(plant, law, times, feedback="1-6", x0=start, atol=1e-7)["plant"]
    linear = sim.simulate_ltv(flexible).y[:13]
    amplitude = np.abs(full[:, 6:9] - flexible.y0[:13, 6:9]).max()
    assert np.abs(full - linear)[:, 6:9].max() < 1e-2 * amplitude


def test_sigma0_holds_the_weight(flexible):
    """At rest the static deflection from sigma0 is the one that a small load calculation gives: K0B dq = sigma0."""
    n = flexible.m0.shape[1]
    E = flexible.B[0][n:]
    load = flexible.m0[0] @ E[:, 3:] @ flexible.sigma0[0]
    assert flexible.k0b[0] @ flexible.x0[:n] == pytest.approx(load, abs=1e-9)  # of a few hundred N m
    assert not flexible.x0[n:].any()


def test_reduction_of_the_manipulator(flexible):
    """4 of 11 modes: the tip deviates from the full linear system by less than 2 % of its largest deflection in the
    mean."""
    full = sim.simulate_ltv(flexible)
    reduced = sim.simulate_ltv(sim.reduce_modes(flexible, 4).system)
    off, size = np.abs(reduced.dy - full.dy)[:, 6:9], np.abs(full.dy)[:, 6:9].max()
    assert off.mean() < 0.02 * size
