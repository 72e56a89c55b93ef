"""Measured orders of every code, of the dense output, and damping of infinitely stiff components."""

import re
from pathlib import Path

import numpy as np
import pytest

from spacar.integrators import AUTOMATIC, Problem, integrate
from spacar.integrators import METHODS as ALL
from spacar.integrators import dop853 as table
from spacar.integrators.implicit import sdirk_tableau
from spacar.integrators.problem import Evaluation, Tolerance

from .integrator_models import OSCILLATOR, Kepler, Linear, Pendulum, ProtheroRobinson, equal_steps, pendulum_reference

# The orders are claims of the table; these tests measure them, so a new row is measured without being named here.
METHODS = {code: row for code, row in ALL.items() if code != AUTOMATIC}  # which is made of two of them
FIXED = {c: m.order for c, m in METHODS.items() if not m.variable_step}
VARIABLE = {c: m.order for c, m in METHODS.items() if m.variable_step and m.order}
IMPLICIT = tuple(c for c, m in METHODS.items() if m.needs_jacobian and not m.variable_step)
DOCS = Path(__file__).parents[2] / "docs"
# Newton tolerance of the implicit codes: below the smallest discretization error of these tests (1e-9).
TIGHT = 1e-13


def test_table_holds_every_documented_code():
    """Those of the original are listed in note d13 of the reference; all are in the table of section 9."""
    language = (DOCS / "reference" / "input-language.md").read_text(encoding="utf-8")
    note = language[language.index("**d13**") : language.index("**d14**")]
    listed = note[note.index("Codes of the original:") :].split(".")[0]
    original = {int(c) for c in re.findall(r"\d+", listed)}
    assert original == {c for c, m in METHODS.items() if m.original}
    theory = (DOCS / "reference" / "theory-system.md").read_text(encoding="utf-8")
    section = theory.split("\n## 9. ")[1].split("\n## ")[0]
    rows = re.findall(r"^\| ([\d, ]+) \| .* \|$", section, re.MULTILINE)
    assert {int(c) for row in rows for c in row.split(", ")} == set(METHODS)
    assert all(m.citation and m.name for m in METHODS.values())


@pytest.mark.parametrize(("code", "order"), FIXED.items())
def test_order_of_fixed_step_codes(code, order):
    end = 4.0
    reference = np.array(pendulum_reference(end))
    errors = []
    for n in (160, 320):
        *_, out = integrate(Pendulum(), Pendulum.y0, [0.0, end], code, atol=TIGHT, step=end / n)
        assert out.work.n_steps == n
        errors.append(np.linalg.norm(out.y - reference))
    # The next term of the error expansion is h/T small, so halving the step shows the order to about a tenth.
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.15)
    assert METHODS[code].order == order
    assert not METHODS[code].variable_step


@pytest.mark.parametrize(("code", "order"), VARIABLE.items())
def test_order_of_variable_step_codes(code, order):
    end = 4.0
    reference = np.array(pendulum_reference(end))
    # Orders 8 and 9 reach rounding soon, so their steps are longer and the measured order less settled.
    counts, margin = ((10, 20), 0.6) if order >= 8 else ((80, 160), 0.25)
    errors = [np.linalg.norm(equal_steps(code, Pendulum(), Pendulum.y0, end, n)[0] - reference) for n in counts]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=margin)
    assert METHODS[code].order == order
    assert METHODS[code].variable_step


@pytest.mark.parametrize(("code", "local_order"), [(135, 4), (155, 5), (225, 3), (853, 8)])
def test_order_of_dense_output(code, local_order):
    """Error inside one step of the exact orbit: h^4 cubic Hermite (h^3 by a 225 step), h^5, h^8."""
    problem = Kepler()
    errors = []
    for h in (0.1, 0.05) if code == 853 else (0.04, 0.02):
        _, integrator = equal_steps(code, problem, problem.y0, h, 1)
        inner = np.linspace(0.05, 0.95, 19) * h
        dense = np.array([integrator.interpolate(t) for t in inner])
        errors.append(np.abs(dense - problem.exact(inner)).max())
    assert np.log2(errors[0] / errors[1]) > local_order - 0.35


@pytest.mark.parametrize("code", [135, 155, 225, 853, 553, 595])
def test_dense_output_meets_the_step_ends(code):
    y0, iteration = np.array([1.0, -0.5]), 1e-13 * METHODS[code].needs_jacobian
    end, integrator = equal_steps(code, Linear(OSCILLATOR), y0, 0.3, 1)
    # Both ends are reproduced by construction: rounding, and what the iteration of an implicit code leaves.
    np.testing.assert_allclose(integrator.interpolate(0.3), end, rtol=0, atol=max(iteration, 1e-14))
    np.testing.assert_allclose(integrator.interpolate(0.0), y0, rtol=0, atol=1e-14)


@pytest.mark.parametrize("code", IMPLICIT)
def test_infinitely_stiff_component_is_damped_in_one_step(code):
    """|R(-1e8)| <= 5e-8; an A-stable but not L-stable method would give |R| near 1."""
    problem = Linear([[-1e8]], n_positions=0)
    *_, out = integrate(problem, np.array([1.0]), [0.0, 1.0], code, atol=1e-12, step=1.0)
    assert out.work.n_steps == 1
    assert abs(out.y[0]) <= 5e-8


@pytest.mark.parametrize("code", IMPLICIT)
def test_stiff_slow_solution_is_followed(code):
    """Explicit codes need 1e6 steps, these get cos t with 100."""
    *_, out = integrate(ProtheroRobinson(1e6), np.array([1.0]), [0.0, 1.0], code, atol=1e-9, step=0.01)
    # Stiffness reduces the order of some of them to about 2: h^2 = 1e-4 with a margin of ten.
    assert abs(out.y[0] - np.cos(1.0)) < 1e-3


@pytest.mark.parametrize("code", [410, 420, 430])
def test_sdirk_order_conditions(code):
    c, a = sdirk_tableau(code)
    b, order = a[-1], METHODS[code].order
    # Closed-form conditions, coefficients given to 16 digits.
    np.testing.assert_allclose(a.sum(axis=1), c, atol=1e-15)
    conditions = [b.sum() - 1, b @ c - 1 / 2, b @ c**2 - 1 / 3, b @ a @ c - 1 / 6][: (1, 2, 4)[order - 1]]
    np.testing.assert_allclose(conditions, 0.0, atol=1e-15)


def test_853_table_conditions():
    """Independent truths about the published numbers: row sums and quadrature conditions."""
    t = table.TABLEAU
    # Entries up to 90 with 16 digits: sums right to a few 1e-14.
    np.testing.assert_allclose(t.a.sum(axis=1), t.c, atol=1e-13)
    np.testing.assert_allclose(table.A_EXTRA.sum(axis=1), table.C_EXTRA, atol=1e-13)
    for q in range(8):
        assert t.b @ t.c**q == pytest.approx(1 / (q + 1), abs=1e-14)
        assert t.b @ t.a @ t.c**q == pytest.approx(1 / ((q + 1) * (q + 2)), abs=1e-14) or q == 7
    assert abs(table.ERROR_3.sum()) < 1e-14
    assert abs(table.ERROR_5.sum()) < 1e-14


# Code 225: its error estimate is the error of a step, and its steps are those that an order of two needs.
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
