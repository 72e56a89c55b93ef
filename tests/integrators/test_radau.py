"""Codes 553 and 595 (Radau IIA): coefficients, stiff and undamped problems, dense output, iteration, failures."""

import numpy as np
import pytest
from scipy.linalg import expm

from spacar.errors import AnalysisError
from spacar.integrators import Problem, integrate
from spacar.integrators.radau import radau

from .integrator_models import OSCILLATOR, Linear, Pendulum, ProtheroRobinson, equal_steps

CODES = (553, 595)
STAGES = {553: 3, 595: 5}


# -- coefficients ---------------------------------------------------------------------------------------------
def test_three_stages_have_the_published_coefficients():
    """Hairer & Wanner II, table IV.5.6."""
    m, r = radau(3), np.sqrt(6.0)
    # Closed forms of numbers of size one: rounding only.
    np.testing.assert_allclose(m.c, [(4 - r) / 10, (4 + r) / 10, 1], atol=1e-15)
    a = [
        [(88 - 7 * r) / 360, (296 - 169 * r) / 1800, (-2 + 3 * r) / 225],
        [(296 + 169 * r) / 1800, (88 + 7 * r) / 360, (-2 - 3 * r) / 225],
        [(16 - r) / 36, (16 + r) / 36, 1 / 9],
    ]
    np.testing.assert_allclose(m.a, a, atol=1e-15)
    # Real eigenvalue of the inverse: root of 60 - 36 z + 9 z^2 - z^3, the denominator of the stability function.
    assert np.polyval([-1, 9, -36, 60], m.real) == pytest.approx(0.0, abs=1e-12)
    # Embedded quadrature of order 3 (IV.8.16): lambda_0 times the estimate is (-13 -+ 7 r, -1) / 3 in Z.
    np.testing.assert_allclose(m.error, [(-13 - 7 * r) / 3, (-13 + 7 * r) / 3, -1 / 3], rtol=1e-12)


@pytest.mark.parametrize("s", [3, 5])
def test_order_conditions_and_transformation(s):
    m = radau(s)
    for k in range(1, 2 * s):
        assert m.a[-1] @ m.c ** (k - 1) == pytest.approx(1 / k, abs=1e-14)  # B(2s - 1)
    for k in range(1, s + 1):
        np.testing.assert_allclose(m.a @ m.c ** (k - 1), m.c**k / k, atol=1e-14)  # C(s)
    np.testing.assert_allclose(m.back @ m.to, np.eye(s), atol=1e-13)
    blocks = m.to @ m.inverse @ m.back
    expected = np.zeros((s, s))
    expected[0, 0] = m.real
    for i, pair in enumerate(m.pairs):
        j = 2 * i + 1
        expected[j : j + 2, j : j + 2] = [[pair.real, -pair.imag], [pair.imag, pair.real]]
    # Entries up to 30, condition of the eigenvectors some tens.
    np.testing.assert_allclose(blocks, expected, atol=1e-11)


# -- stiff problems -------------------------------------------------------------------------------------------
@pytest.mark.parametrize("code", CODES)
@pytest.mark.parametrize("rate", [1e2, 1e6, 1e9])
def test_prothero_robinson(code, rate):
    """An explicit method needs rate * 10 / 3 steps."""
    problem, times = ProtheroRobinson(rate), np.linspace(0.0, 10.0, 11)
    outputs = list(integrate(problem, np.array([1.0]), times, code, atol=1e-7, rtol=1e-7))
    error = max(abs(o.y[0] - np.cos(o.t)) for o in outputs)
    assert error < 2e-6  # ten times atol + rtol |y|
    assert sum(o.work.n_steps for o in outputs) < 500
    assert sum(o.work.n_jacobian for o in outputs) == 1


class VanDerPol(Problem):
    """eps q'' = (1 - q^2) q' - q with eps = 1e-6: jumps within 1e-6 of the time between them."""

    n_positions = 1
    y0 = np.array([2.0, -0.66])

    def rhs(self, t, y):
        return np.array([y[1], 1e6 * ((1.0 - y[0] ** 2) * y[1] - y[0])])

    def jacobian(self, t, y):
        return np.array([[0.0, 1.0], [1e6 * (-2.0 * y[0] * y[1] - 1.0), 1e6 * (1.0 - y[0] ** 2)]]), np.zeros(2)


@pytest.mark.slow
def test_van_der_pol_against_another_program():
    from scipy.integrate import solve_ivp

    p = VanDerPol()
    times = [0.0, 0.5, 1.0, 1.5, 2.0]
    reference = solve_ivp(
        p.rhs, (0, 2), p.y0, "Radau", times, rtol=1e-10, atol=1e-10, jac=lambda t, y: p.jacobian(t, y)[0]
    ).y.T
    for code in CODES:
        outputs = list(integrate(p, p.y0, times, code, atol=1e-6, rtol=1e-6))
        # Each jump amplifies errors about tenfold; the reference is good to 1e-8.
        np.testing.assert_allclose([o.y for o in outputs], reference, rtol=2e-5, atol=2e-5)
        assert sum(o.work.n_steps for o in outputs) < 1000


@pytest.mark.parametrize("code", CODES)
@pytest.mark.parametrize("frequency", [1e2, 1e3, 1e4])
def test_unexcited_undamped_vibration_does_not_limit_the_step(code, frequency):
    """A slow oscillator (w = 1) and one of w = frequency, undamped, at rest and coupled by a rotation of 0.5 rad."""
    c, s = np.cos(0.5), np.sin(0.5)
    rotation = np.array([[c, -s], [s, c]])
    stiffness = rotation @ np.diag([1.0, frequency**2]) @ rotation.T
    zero = np.zeros((2, 2))
    problem = Linear(np.block([[zero, np.eye(2)], [-stiffness, zero]]))
    mode = rotation[:, 0]
    outputs = list(
        integrate(problem, np.concatenate((mode, 0.0 * mode)), np.linspace(0, 10, 21), code, atol=1e-6, rtol=0.0)
    )
    # The rounded stiffness of the slow oscillator is wrong by 1e-16 frequency^2, 1e-8 at most.
    error = max(np.abs(o.y[:2] - np.cos(o.t) * mode).max() for o in outputs)
    assert error < 1e-5
    assert sum(o.work.n_steps for o in outputs) < {553: 300, 595: 150}[code]


# -- steps and dense output -----------------------------------------------------------------------------------
@pytest.mark.parametrize("code", CODES)
def test_order_of_dense_output(code):
    """Inside one step velocities err as h^(s+1), positions as h^(s+2)."""
    y0, errors = np.array([1.0, -0.5]), []
    for h in (0.4, 0.2):
        _, integrator = equal_steps(code, Linear(OSCILLATOR), y0, h, 1)
        inner = np.linspace(0.05, 0.95, 19) * h
        dense = np.array([integrator.interpolate(t) for t in inner])
        exact = np.array([expm(OSCILLATOR * t) @ y0 for t in inner])
        errors.append(np.abs(dense - exact).max(axis=0))
    orders = np.log2(errors[0] / errors[1])
    # The next term of the expansion, h w = 0.8 at most, moves the measured order by some tenths.
    np.testing.assert_allclose(orders, [STAGES[code] + 2, STAGES[code] + 1], atol=0.4)


@pytest.mark.parametrize("code", CODES)
def test_kinematic_coordinates(code):
    """q' = v, k' = v cos k + q, v' = -100 q + k: the last rates belong to the first positions, k has its own."""

    class Rolling(Problem):
        n_positions = 2

        def rhs(self, t, y):
            q, k, v = y
            return np.array([v, v * np.cos(k) + q, -100.0 * q + k])

        def jacobian(self, t, y):
            _, k, v = y
            return np.array([[0, 0, 1], [1, -v * np.sin(k), np.cos(k)], [-100, 1, 0]]), np.zeros(3)

    y0, times = np.array([0.1, 0.3, 0.5]), np.linspace(0.0, 3.0, 13)
    reference = np.array([o.y for o in integrate(Rolling(), y0, times, 853, atol=1e-12, rtol=1e-12)])
    y = np.array([o.y for o in integrate(Rolling(), y0, times, code, atol=1e-8, rtol=1e-8)])
    np.testing.assert_allclose(y, reference, rtol=0, atol=1e-7)  # ten times the tolerance


# -- iteration ------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("code", CODES)
def test_linear_problem_needs_one_jacobian_and_keeps_its_factors(code):
    problem = Linear(OSCILLATOR)
    outputs = list(integrate(problem, np.array([1.0, 0.0]), [0.0, 20.0], code, atol=1e-6, rtol=1e-6))
    assert problem.n_jacobian == 1
    # Two iterations a step: the second shows that the first was enough.
    iterations = sum(o.work.newton_iterations for o in outputs)
    assert iterations <= 2 * sum(o.work.n_steps + o.work.n_rejected for o in outputs)


@pytest.mark.parametrize("code", CODES)
def test_wrong_jacobian_shortens_steps_but_does_not_spoil_the_answer(code):
    class Wrong(Pendulum):
        def jacobian(self, t, y):
            return np.array([[0.0, 1.0], [-50.0, -3.0]]), np.zeros(2)

    times = [0.0, 1.0, 2.0]
    *_, out = integrate(Wrong(), Pendulum.y0, times, code, atol=1e-7, rtol=1e-7)
    *_, exact = integrate(Pendulum(), Pendulum.y0, times, 853, atol=1e-12, rtol=1e-12)
    np.testing.assert_allclose(out.y, exact.y, rtol=0, atol=1e-6)


@pytest.mark.parametrize("code", CODES)
def test_failing_iteration_says_where_how_far_and_what_to_do(code):
    """A force that changes its sign with every rounding of the velocity cannot be solved for."""
    random = np.random.default_rng(3)

    class Noisy(Pendulum):
        def rhs(self, t, y):
            return super().rhs(t, y) + 1e24 * random.standard_normal(2)

        def component_name(self, i):
            return ("angle", "rate of the angle")[i]

    with pytest.raises(AnalysisError) as failure:
        list(integrate(Noisy(), Pendulum.y0, [0.0, 1.0], code, atol=1e-10, rtol=0.0))
    error, text = failure.value, str(failure.value)
    assert error.code == "integrator.newton"
    assert error.data["error"] > 0.01
    assert "Newton iteration does not converge" in text
    assert "times the tolerance in rate of the angle" in text
    assert "reductions of the step size" in text
    assert "enlarge ERROR" in text
