"""Simulations run on the integrators of mode 1, by the same codes; the names of SciPy are aliases in one table."""

import numpy as np
import pytest
import scipy.integrate

from spacar.errors import AnalysisError, UsageError
from spacar.integrators import NAMES, named
from spacar.simulation import Continuous, Diagram, Function, Linear, simulate

TIMES = np.linspace(0.0, 2.0, 21)


def oscillator():
    """x'' = -9 x - 0.4 x' + cos 2 t."""
    plant = Linear("p", [[0.0, 1.0], [-9.0, -0.4]], [[0.0], [1.0]], [[1.0, 0.0]], x0=[1.0, 0.0])
    return Diagram().add(plant, Function("force", lambda t: np.cos(2 * t), 0, 1)).connect("force", "p")


def truth():
    """By a code of other people at its tightest tolerance."""

    def rhs(t, y):
        return [y[1], -9 * y[0] - 0.4 * y[1] + np.cos(2 * t)]

    return scipy.integrate.solve_ivp(rhs, (0, 2), [1, 0], "DOP853", TIMES, rtol=1e-13, atol=1e-14).y[0]


@pytest.mark.parametrize("method", [135, 155, 853, 553, 595, "853"])
def test_codes_of_integrat(method):
    r = simulate(oscillator(), TIMES, method=method, rtol=1e-8, atol=1e-10)
    # errors of some hundred steps of 1e-8 add up
    assert r["p"][:, 0] == pytest.approx(truth(), abs=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_the_code_bit_for_bit(name):
    by_name, by_code = (simulate(oscillator(), TIMES, method=m) for m in (name, NAMES[name]))
    assert np.array_equal(by_name.y, by_code.y)
    assert by_name.statistics == by_code.statistics
    assert named(name.lower()) is named(NAMES[name])


def test_155_takes_the_steps_that_scipy_takes():
    """The same pair of formulas under the same tolerance: about the same number of steps."""
    r = simulate(oscillator(), TIMES, rtol=1e-8, atol=1e-10)
    s = scipy.integrate.RK45(
        lambda t, y: [y[1], -9 * y[0] - 0.4 * y[1] + np.cos(2 * t)], 0, [1, 0], 2, rtol=1e-8, atol=1e-10
    )
    n = 0
    while s.status == "running":
        s.step()
        n += 1
    assert 0.8 * n <= r.statistics["steps"] <= 1.25 * n


def test_a_stiff_loop_wants_an_implicit_code():
    """x' = -1e6 (x - cos t): stability holds 155 to 2e6/3.3 steps, 553 takes less than 200."""
    stiff = Continuous("s", lambda t, x, u: [-1e6 * (x[0] - np.cos(t))], lambda t, x, u: x, [1.0], 0, 1)
    r = simulate(Diagram().add(stiff), TIMES, method=553)
    assert r.statistics["steps"] < 200
    assert r["s"][:, 0] == pytest.approx(np.cos(TIMES), abs=2e-6)  # x lags by 1e-6 s


def test_the_largest_step_is_kept():
    """A pulse of 0.02 s between the steps of a slow motion is seen when max_step is 0.01 s."""
    pulse = Continuous("s", lambda t, x, u: [float(0.9 < t < 0.92)], lambda t, x, u: x, [0.0], 0, 1)
    r = simulate(Diagram().add(pulse), TIMES, max_step=0.01)
    assert r["s"][-1, 0] == pytest.approx(0.02, rel=1e-4)
    assert r.statistics["steps"] >= 200


@pytest.mark.parametrize(
    ("method", "sentence"),
    [("Euler", "method 'Euler' does not exist"), (7, "unknown integration code 7"),
     (410, "method 410 cannot be used here"),
     (0, "method 0 cannot be used here; choose 135, 155, 553, 595, 853")],
)  # fmt: skip
def test_wrong_methods(method, sentence):
    with pytest.raises(UsageError, match=sentence):
        simulate(oscillator(), TIMES, method=method)


def test_a_mistake_of_a_block_is_not_tried_again():
    calls = []

    def wrong(t, x, u):
        calls.append(t)
        return [np.nan if t > 0.5 else 1.0]

    block = Continuous("c", wrong, lambda t, x, u: x, [0.0], 0, 1)
    with pytest.raises(AnalysisError, match=r"states of c at t = .*component 1 is nan") as found:
        simulate(Diagram().add(block), TIMES)
    assert found.value.code.startswith("simulation.")
    assert sum(t > 0.5 for t in calls) == 1
