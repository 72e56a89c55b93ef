"""Code 0: coefficients against exact integrals, the measured Kepler table of theory-system.md section 9.1."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from spacar.integrators import Problem, integrate
from spacar.integrators.adams import (
    GAMMA_STAR,
    interpolation_weights,
    lowered,
    next_step_size,
    predictor_weights,
    step_coefficients,
)

from .integrator_models import Kepler


def run(problem, times, tolerance, code=0):
    outputs = list(integrate(problem, problem.y0, times, code, atol=tolerance, rtol=tolerance))
    return outputs, np.array([o.y for o in outputs])


@pytest.mark.parametrize(
    ("tolerance", "code", "evaluations", "error"),
    [
        (1e-6, 0, 504, 9e-4), (1e-8, 0, 780, 9e-6), (1e-10, 0, 1084, 8e-8), (1e-6, 155, 728, 4e-4),
        (1e-8, 155, 1346, 7e-6), (1e-10, 155, 3368, 1e-7), (1e-6, 853, 878, 2e-4), (1e-8, 853, 1340, 8e-6),
        (1e-10, 853, 2219, 5e-8),
    ],
)
def test_kepler_table(tolerance, code, evaluations, error):
    problem = Kepler()
    times = np.linspace(0.0, 20.0, 201)
    outputs, y = run(problem, times, tolerance, code)
    used = sum(o.work.n_rhs for o in outputs)
    # The table's errors are rounded to a digit (up to 25 percent at 2e-4); step decisions differ by rounding.
    # Code 853 takes 4^(1/8) = 1.19 times more steps than the table's program, for the sake of its outputs.
    assert 0.9 * evaluations <= used <= (1.3 if code == 853 else 1.1) * evaluations
    assert np.abs(y - problem.exact(times)).max() <= 1.3 * error


def test_dense_output_is_as_good_as_the_steps():
    """Errors at 4001 output times are not larger than a few times those at the 20 breaks that end a step."""
    problem = Kepler()
    breaks = np.linspace(1.0, 19.0, 19)
    _, y = run(problem, np.linspace(0.0, 20.0, 4001), 1e-9)
    fine = np.abs(y - problem.exact(np.linspace(0.0, 20.0, 4001))).max()
    _, y = run(problem, np.append(np.append(0.0, breaks), 20.0), 1e-9)
    coarse = np.abs(y - problem.exact(np.append(np.append(0.0, breaks), 20.0))).max()
    # The orbit passes its fast pericentre between two of the coarse times, worth a factor of a few.
    assert fine < 5.0 * coarse


def test_polynomial_motion_is_exact():
    """y' = 6 t^5: from order 6 on the polynomial is exact, so only the low-order start leaves an error."""

    class Power(Problem):
        n_positions = 0
        y0 = np.zeros(1)

        def rhs(self, t, y):
            return np.array([6.0 * t**5])

    times = np.linspace(0.0, 3.0, 301)
    outputs, y = run(Power(), times, 1e-10)
    assert np.abs(y[:, 0] - times**6).max() < 1e-8  # tolerance 1e-10 relative to 729
    assert sum(o.work.n_steps for o in outputs) < 80


def test_constant_step_coefficients_are_the_adams_ones():
    g = predictor_weights([1 / i for i in range(1, 8)], 7)
    exact = [1, 1 / 2, 5 / 12, 3 / 8, 251 / 720, 95 / 288, 19087 / 60480, 5257 / 17280]
    np.testing.assert_allclose(g, exact, rtol=1e-14)
    # gamma* = g_k+1 - g_k up to sign, tabulated with three digits.
    np.testing.assert_allclose(-np.diff(exact), GAMMA_STAR[1:8], rtol=6e-3)


def variable_history(steps, f):
    """phi rows of f at the ends of `steps`, from their definition as modified divided differences."""
    t = np.concatenate([[0.0], np.cumsum(steps)])
    t -= t[-1]
    phi, divided, product = [], {i: f(x) for i, x in enumerate(t)}, 1.0
    last = len(t) - 1
    for order in range(len(t)):
        if order:
            divided = {
                i: (divided[i] - divided[i - 1]) / (t[i] - t[i - order]) for i in range(order, last + 1)
            }
            product *= t[last] - t[last - order]
        phi.append(product * divided[last])
    return np.array(phi), np.cumsum(steps[::-1]).tolist()


def test_variable_step_prediction_integrates_the_interpolating_polynomial():
    """Order 4 in unequal steps against the exact integral of a cubic derivative."""
    rate = Polynomial([0.3, -1.2, 0.7, 2.0])
    steps = [0.3, 0.1, 0.25, 0.2]
    phi, sums = variable_history(steps, rate)
    h = 0.37
    psi = [*sums, *[0.0] * (13 - len(sums))]
    psi_new, g, _, matrix = step_coefficients(h, 4, 1, psi)
    np.testing.assert_allclose(psi_new[:3], [h, h + 0.2, h + 0.45], rtol=1e-15)
    predicted = matrix @ phi[:4, None]
    exact = rate.integ()(h)
    # Exact up to rounding: four differences hold a cubic.
    assert h * predicted[0, 0] == pytest.approx(exact, rel=1e-13)
    assert predicted[1, 0] == pytest.approx(rate(h), rel=1e-13)  # phi^e_1 is the extrapolated derivative
    assert len(g) == 5


def test_equal_steps_agree_with_the_general_formulas():
    """The short cut for equal steps gives what the recursion gives."""
    h, k = 0.2, 6
    psi = [h * i for i in range(1, 14)]
    _, g, sigma, matrix = step_coefficients(h, k, k, psi)
    _, g_general, sigma_general, matrix_general = step_coefficients(h, k, 1, psi)
    np.testing.assert_allclose(g[: k + 1], g_general, rtol=1e-13)
    np.testing.assert_allclose(sigma[: k + 1], sigma_general, rtol=1e-13)
    np.testing.assert_allclose(matrix, matrix_general, rtol=1e-13)


def test_interpolation_weights_integrate_the_polynomial():
    rate = Polynomial([0.3, -1.2, 0.7, 2.0, -1.1])
    phi, sums = variable_history([0.3, 0.1, 0.25, 0.2], rate)
    for tau in (-0.2, -0.13, -0.01, 0.0, 0.1):
        w = interpolation_weights(tau, 4, sums)
        assert tau * (w @ phi) == pytest.approx(rate.integ()(tau), rel=1e-12, abs=1e-15)


def test_order_and_step_rules():
    assert lowered(3, 1.0, 1.0, 0.5)
    assert not lowered(3, 1.0, 1.1, 0.5)
    assert lowered(2, 1.0, 0.5, 0.0)
    assert not lowered(1, 1.0, 0.0, 0.0)
    assert next_step_size(1.0, 3, 0.5 / 16) == 2.0
    assert next_step_size(1.0, 3, 0.5) == 1.0
    assert next_step_size(1.0, 3, 0.5001) == 0.9
    assert next_step_size(1.0, 1, 1e9) == 0.5
