"""Failures say when, how small the step was, which component and what to try; recoverable ones recover."""

import numpy as np
import pytest

from spacar.errors import AnalysisError
from spacar.integrators import METHODS, Problem, integrate
from spacar.integrators.methods import AUTOMATIC

from .integrator_models import Linear, Pendulum

VARIABLE = [c for c, m in METHODS.items() if m.variable_step]
EXPLICIT_FIXED = [130, 140, 220]


class Explosion(Problem):
    """q' = v, v' = v^2: infinite at t = 1."""

    n_positions = 1

    def rhs(self, t, y):
        return np.array([y[1], y[1] ** 2])

    def jacobian(self, t, y):
        return np.array([[0.0, 1.0], [0.0, 2.0 * y[1]]]), np.zeros(2)

    def component_name(self, i):
        return ("position of hinge 3", "velocity of hinge 3")[i]


@pytest.mark.parametrize("code", VARIABLE)
def test_finite_escape_time_stops_with_reason(code):
    with pytest.raises(AnalysisError) as failure:
        list(integrate(Explosion(), np.array([0.0, 1.0]), [0.0, 2.0], code))
    error = failure.value
    text = str(error)
    # The automatic method has gone over to an implicit code, whose iteration fails before its error estimate does.
    also = ("integrator.newton",) if code == AUTOMATIC else ()
    assert error.code in ("integrator.step-too-small", "integrator.not-finite", *also)
    # The numerical solution escapes near t = 1 (relative tolerance 1e-4, amplified by 1/(1-t)).
    assert error.data["t"] == pytest.approx(1.0, abs=0.02)
    assert "t = 1.0" in text or "t = 0.99" in text
    assert "hinge 3" in text


class NotFinite(Pendulum):
    """Undefined in a window of time that only very small steps meet."""

    def __init__(self, first, last):
        self.first, self.last = first, last

    def rhs(self, t, y):
        f = super().rhs(t, y)
        if self.first < t < self.last:
            f[1] = np.nan
        return f


@pytest.mark.parametrize("code", VARIABLE)
def test_undefined_derivative_reduces_the_step_then_fails(code):
    with pytest.raises(AnalysisError) as failure:
        list(integrate(NotFinite(1.0, 9.0), Pendulum.y0, [0.0, 2.0], code))
    error = failure.value
    assert error.code == "integrator.not-finite"
    assert "state component 1 is nan" in str(error)
    # Ten reductions by four of a step of order 0.1 s end within 1e-6 of the wall.
    assert 0.9 < error.data["t"] <= 1.0
    assert "reductions of the step size" in str(error)


@pytest.mark.parametrize("code", EXPLICIT_FIXED)
def test_undefined_derivative_fails_at_once_in_fixed_steps(code):
    with pytest.raises(AnalysisError, match=r"fixed|smaller step size") as failure:
        list(integrate(NotFinite(1.0, 9.0), Pendulum.y0, [0.0, 2.0], code, step=0.1))
    assert failure.value.code == "integrator.not-finite"
    assert failure.value.data["t"] == pytest.approx(0.95, abs=0.1)


class Reluctant(Pendulum):
    """Refuses predictions that are far from the last accepted state, as a position iteration does."""

    def __init__(self, radius):
        self.radius = radius
        self.centre = Pendulum.y0.copy()
        self.refusals = 0

    def rhs(self, t, y):
        if np.abs(y - self.centre).max() > self.radius:
            self.refusals += 1
            raise AnalysisError("the position iteration did not converge", "kinematics.position", residual=1.0)
        return super().rhs(t, y)

    def accepted(self, t, y):
        self.centre = y.copy()


@pytest.mark.parametrize("code", VARIABLE)
def test_errors_of_the_problem_reduce_the_step(code):
    problem = Reluctant(0.1)
    times = [0.0, 1.0, 2.0]
    outputs = list(integrate(problem, Pendulum.y0, times, code))
    plain = list(integrate(Pendulum(), Pendulum.y0, times, code))
    assert problem.refusals > 0 or code == 225
    assert sum(o.work.n_rejected for o in outputs) >= problem.refusals
    # Both runs are within ten times the tolerance 1e-4 of the truth.
    np.testing.assert_allclose(outputs[-1].y, plain[-1].y, atol=2e-3)


class Wall(Pendulum):
    def rhs(self, t, y):
        if t > 0.5:
            raise AnalysisError("the mass matrix is singular", "dynamics.singular", element=7)
        return super().rhs(t, y)


@pytest.mark.parametrize("code", VARIABLE)
def test_errors_of_the_problem_are_raised_with_time_when_reduction_does_not_help(code):
    with pytest.raises(AnalysisError, match=r"the mass matrix is singular.*at t = 0.[45]") as failure:
        list(integrate(Wall(), Pendulum.y0, [0.0, 1.0], code))
    assert failure.value.code == "dynamics.singular"
    assert failure.value.data["element"] == 7
    assert failure.value.data["t"] == pytest.approx(0.5, abs=1e-3)
    assert isinstance(failure.value.__cause__, AnalysisError)


@pytest.mark.parametrize("code", [*EXPLICIT_FIXED, 320, 430])
def test_errors_of_the_problem_are_raised_with_time_in_fixed_steps(code):
    with pytest.raises(AnalysisError, match=r"singular.*stopped at t = 0\.5 s with step size 0\.05 s") as failure:
        list(integrate(Wall(), Pendulum.y0, [0.0, 1.0], code, step=0.05))
    assert failure.value.code == "dynamics.singular"


def test_an_error_at_the_start_is_raised_at_once():
    class Bad(Pendulum):
        def rhs(self, t, y):
            return np.array([np.inf, 0.0])

    for code in METHODS:
        with pytest.raises(AnalysisError, match=r"state component 0 is inf") as failure:
            list(integrate(Bad(), Pendulum.y0, [0.0, 1.0], code))
        assert failure.value.code == "integrator.not-finite"


@pytest.mark.parametrize("code", [0, 140, 155])
def test_step_limit_names_stiffness(code):
    with pytest.raises(AnalysisError, match=r"more than 20 integration steps.*INTEGRAT 553") as failure:
        list(integrate(Pendulum(), Pendulum.y0, [0.0, 50.0], code, atol=1e-10, rtol=1e-10, step=0.01, max_steps=20))
    assert failure.value.code == "integrator.too-many-steps"


@pytest.mark.parametrize("code", [0, 135, 155, 225, 853])
def test_impossible_tolerance_is_reported(code):
    """A noisy derivative cannot be integrated to 1e-14: the step shrinks to the resolution of the time."""
    random = np.random.default_rng(3)

    class Noisy(Pendulum):
        def rhs(self, t, y):
            return super().rhs(t, y) + 1e3 * random.standard_normal(2)

    with pytest.raises(AnalysisError) as failure:
        list(integrate(Noisy(), Pendulum.y0, [0.0, 1.0], code, atol=1e-14, rtol=0.0))
    error = failure.value
    assert error.code == "integrator.step-too-small"
    assert error.data["step"] < 1e-12
    assert error.data["error"] > 1.0
    assert error.data["component"] in (0, 1)
    assert "times the tolerance, largest in state component" in str(error)


@pytest.mark.parametrize("code", [220, 225, 255])
def test_second_order_codes_refuse_kinematic_coordinates(code):
    with pytest.raises(AnalysisError, match=r"kinematic coordinates.*use INTEGRAT 0") as failure:
        integrate(Linear(np.zeros((3, 3)), n_positions=2), np.zeros(3), [0.0, 1.0], code)
    assert failure.value.code == "integrator.second-order"


@pytest.mark.parametrize("code", [410, 420, 430])
def test_newton_failure_says_how_far(code):
    class Jagged(Pendulum):
        """The Jacobian has the wrong sign and size: Newton diverges."""

        def rhs(self, t, y):
            return np.array([y[1], -100.0 * y[0] - 1e3 * np.sign(y[1]) * (1 + y[1] ** 2) ** 0.5])

        def jacobian(self, t, y):
            return np.zeros((2, 2)), np.zeros(2)

    with pytest.raises(AnalysisError, match=r"Newton iteration did not converge.*last change") as failure:
        list(integrate(Jagged(), Pendulum.y0, [0.0, 1.0], code, step=0.1))
    assert failure.value.code == "integrator.newton"
    assert failure.value.data["error"] > 1e-5


def test_newton_renews_the_jacobian_once():
    """A Jacobian that is wrong at the step start only costs a second factorization, not the run."""

    class Late(Pendulum):
        def rhs(self, t, y):
            return np.array([y[1], -1e4 * (y[0] - np.sin(t))])

        def jacobian(self, t, y):
            stiffness = 1e4 if t not in (0.0,) else 0.0
            return np.array([[0.0, 1.0], [-stiffness, 0.0]]), np.zeros(2)

    *_, out = integrate(Late(), np.array([0.0, 1.0]), [0.0, 0.1], 410, step=0.1)
    assert out.work.n_jacobian == 2
    assert out.work.newton_iterations > 10


@pytest.mark.parametrize("code", [310, 330, 430])
def test_singular_iteration_matrix_is_reported(code):
    gamma = 1.0 if code == 310 else 0.43586652150845900
    rate = 1.0 / gamma
    while 1.0 - gamma * rate != 0.0:
        rate = np.nextafter(rate, 0.0 if gamma * rate > 1.0 else 9.0)
    with pytest.raises(AnalysisError, match=r"iteration matrix.*singular at t = 0 s") as failure:
        list(integrate(Linear([[rate]], n_positions=0), np.ones(1), [0.0, 1.0], code, step=1.0))
    assert failure.value.code == "integrator.singular"
