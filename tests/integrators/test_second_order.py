"""Code 225: its error estimate is the error of a step, and its steps are those that an order of two needs."""

import numpy as np
import pytest

from spacar.integrators import METHODS, Problem, integrate
from spacar.integrators.problem import Evaluation, Tolerance

from .integrator_models import Kepler, Pendulum, pendulum_reference


def estimate_and_error(h, before):
    """Estimate of a step of the Kepler orbit and its true error; `before`: length of the step before, 0 for none."""
    problem = Kepler()
    # an absolute tolerance far above the size of the motion and no relative one: the estimate in parts of it
    integrator = METHODS[225].build(Evaluation(problem, 0.0, 2.0), 4, Tolerance(100.0, 0.0))
    t = 0.5
    y = problem.exact(np.array([t - before]))[0]
    integrator.start(t - before, y)
    if before:
        integrator.begin(t - before)
        integrator.attempt(before)
        integrator.finish()
    integrator.begin(t)
    y = integrator.y.copy()
    integrator.attempt(h)
    # the exact solution from the present state: the code of order 8 at the limit of rounding
    *_, out = integrate(problem, y, [t, t + h], 853, atol=1e-14, rtol=1e-13)
    return 100.0 * integrator.scaled, out.y - integrator.y_new


@pytest.mark.parametrize("before", [0.0, 0.5, 1.0, 2.0])
def test_the_estimate_is_the_error_of_the_step(before):
    """The relative difference falls with h: the estimate is right in its first term, positions and velocities."""
    differences = []
    for h in (0.02, 0.01):
        estimate, error = estimate_and_error(h, before * h)
        differences.append(
            [np.linalg.norm((estimate - error)[part]) / np.linalg.norm(error[part]) for part in (slice(2), slice(2, 4))]
        )
    wide, fine = np.array(differences)
    assert (fine < 0.05).all(), differences
    assert (wide / fine > 1.6).all(), differences


def steps(tolerance, code=225):
    *_, out = integrate(Pendulum(), Pendulum.y0, [0.0, 4.0], code, atol=tolerance, rtol=tolerance)
    return out.work.n_steps, float(np.linalg.norm(out.y - pendulum_reference(4.0)))


@pytest.mark.slow
def test_the_error_of_the_result_is_the_tolerance():
    """It is proportional to the tolerance, with a factor near one; steps of order two grow with the square root."""
    tolerances = (1e-3, 1e-5, 1e-7)
    counts, errors = zip(*map(steps, tolerances), strict=True)
    # both components of the state are of size one: tolerance + tolerance
    ratios = np.array(errors) / (2.0 * np.array(tolerances))
    assert (ratios > 0.2).all()
    assert (ratios < 5.0).all()
    assert ratios.max() / ratios.min() < 1.5
    assert np.array(counts[1:]) / counts[:-1] == pytest.approx([10.0, 10.0], rel=0.1)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_no_more_steps_than_equal_ones_of_the_same_error(tolerance):
    """220 is the same method with equal steps; on a smooth motion these are nearly the best."""
    count, error = steps(tolerance)
    *_, out = integrate(Pendulum(), Pendulum.y0, [0.0, 4.0], 220, step=4.0 / count)
    assert out.work.n_steps == count
    assert error < 1.5 * np.linalg.norm(out.y - pendulum_reference(4.0))


def test_an_accepted_step_costs_two_evaluations():
    """Its stage and its end; the first step one more, in its middle; a few to choose the first step."""
    *_, out = integrate(Pendulum(), Pendulum.y0, [0.0, 4.0], 225, atol=1e-5, rtol=1e-5)
    assert out.work.n_rhs <= 2 * (out.work.n_steps + out.work.n_rejected) + 5


def test_a_jump_of_the_load_between_steps_is_noticed():
    """No break is announced: the error stays near the tolerance although the step before lies on the other side."""

    class Jump(Problem):
        n_positions = 1

        def rhs(self, t, y):
            return np.array([y[1], -y[0] + (1.0 if t > 1.0 else 0.0)])

    *_, out = integrate(Jump(), np.array([1.0, 0.0]), [0.0, 3.0], 225, atol=1e-7, rtol=1e-7)
    # q = cos t + 1 - cos(t - 1) behind the jump
    exact = np.array([np.cos(3.0) + 1 - np.cos(2.0), -np.sin(3.0) + np.sin(2.0)])
    assert np.abs(out.y - exact).max() < 1e-4
