"""All integration codes on mechanisms: the same motion, the order of the method, exact Jacobians."""

from functools import cache

import models
import numpy as np
import pytest

import spacar
from spacar.arrays import Array
from spacar.dynamics import Dynamics
from spacar.errors import AnalysisError
from spacar.integrators import METHODS
from spacar.kinematics.kinematics import CONVERGED
from spacar.linearization.state_jacobian import state_jacobian
from spacar.mechanism import build
from tests.examples import DATA

from .reduced_form import random_state

FIXED = {c: m.order for c, m in METHODS.items() if not m.variable_step}


def end(name: str, duration: float, **options: float) -> np.ndarray:
    """Positions at the end of a run with one output step."""
    r = spacar.run(1, DATA / f"{name}.dat", duration=duration, n_steps=1, **options)
    return r["x"][-1]


@cache
def exact(name: str, duration: float, n_steps: int = 1) -> np.ndarray:
    """Positions at all outputs with ERROR 1e-11."""
    options = {"duration": duration, "n_steps": n_steps, "atol": 1e-11, "rtol": 1e-11}
    return spacar.run(1, DATA / f"{name}.dat", integrator=155, **options)["x"]


def test_the_table_of_codes_is_complete() -> None:
    assert set(FIXED) | {0, 135, 155, 225} <= set(METHODS)


@pytest.mark.parametrize(("name", "duration"), [("crankfl", 0.001), ("fingersim", 0.025)])
@pytest.mark.parametrize(("code", "tolerance"), [(0, 1e-8), (135, 1e-6), (155, 1e-8), (225, 1e-4)])
def test_variable_steps_reach_the_tolerance(name: str, duration: float, code: int, tolerance: float) -> None:
    """Positions are of size 1 and rates of size 100: within a hundred times the tolerance."""
    found = end(name, duration, integrator=code, atol=tolerance, rtol=tolerance)
    np.testing.assert_allclose(found, exact(name, duration)[-1], atol=100 * tolerance)


LOW = (310, 320, 410, 420)  # implicit, of lower order than 330 and 430


@pytest.mark.parametrize("code", [pytest.param(c, marks=[pytest.mark.slow] * (c in LOW)) for c in sorted(FIXED)])
@pytest.mark.parametrize(
    ("name", "duration", "steps"),
    [pytest.param("crankfl", 0.001, 40, marks=pytest.mark.slow), ("fingersim", 0.025, 16)],
)
def test_fixed_steps_have_the_order_of_the_table(name: str, duration: float, steps: int, code: int) -> None:
    """Two halvings; the second observed order within 0.35 of the theoretical one (asymptotic but not at its limit)."""
    factor = 2 if FIXED[code] == 1 else 1
    sizes = [duration / (factor * steps * k) for k in (1, 2, 4)]
    found = [end(name, duration, integrator=code, step=step, atol=1e-10) for step in sizes]
    errors = [np.abs(x - exact(name, duration)[-1]).max() for x in found]
    order = np.log2(errors[1] / errors[2])
    if errors[2] > 1e-11:  # else rounding decides
        assert order > FIXED[code] - 0.35
    assert errors[2] < errors[0]


@pytest.mark.parametrize(
    "name", ["crankfl", "fingersim", "trike2", "trike3v", "trike3i", "screw", "robotsim", "massspring"]
)
def test_jacobian_against_differences(name: str) -> None:
    """Fourth order differences of F with h = 1e-4: h^4 F^(5)/30 and 1e-11/h, below 2e-6 of the largest in each row."""
    d = Dynamics(build(spacar.read_deck(DATA / f"{name}.dat", 1)))
    y = random_state(d, 1e-3, 0.1)
    J, _ = state_jacobian(d, 0.01, y)
    h = 1e-4
    numeric = np.empty_like(J)
    for k in range(len(y)):
        e = np.zeros(len(y))
        e[k] = h
        near = d.rhs(0.01, y + e) - d.rhs(0.01, y - e)
        far = d.rhs(0.01, y + 2 * e) - d.rhs(0.01, y - 2 * e)
        numeric[:, k] = (8 * near - far) / (12 * h)
    scale = np.abs(J).max(axis=1, keepdims=True) + 1.0
    np.testing.assert_allclose(J / scale, numeric / scale, atol=2e-6)


def test_explicit_time_derivative_of_the_motion() -> None:
    """dF/dt of a prescribed crank with acceleration, against differences of F."""
    rows = [("PLTOR", 1, 1, 2), ("PLBEAM", 2, 3, 2, 4, 5), ("X", 4, 0.7), ("FIX", 1), ("FIX", 3), ("INPUTE", 1),
            ("DYNE", 2, 2, 3)]  # fmt: skip
    dynamics = [("EM", 2, 1.0), ("ESTIFF", 2, 0.0, 20.0), ("INPUTE", 1, 1, 0.0, 1.0, 2.0), ("TIMESTEP", 1.0, 10)]
    d = Dynamics(build(spacar.Deck.build(rows, dynamics)))
    y = random_state(d, 1e-2, 0.5)
    _, F_t = state_jacobian(d, 0.5, y)
    h = 1e-4
    four = (-d.rhs(0.5 + 2 * h, y) + 8 * d.rhs(0.5 + h, y) - 8 * d.rhs(0.5 - h, y) + d.rhs(0.5 - 2 * h, y)) / (12 * h)
    # F is exact to CONVERGED; the weights of its difference over 7e-4 of the output interval of 0.1 s are 11 in all.
    np.testing.assert_allclose(F_t, four, atol=CONVERGED * 11 / 7e-5 * np.abs(d.rhs(0.5, y)).max())


@pytest.mark.slow
def test_implicit_codes_take_large_steps_on_a_stiff_mechanism() -> None:
    """crankfl with released elongation, EA 1000 times too stiff for explicit steps of this size.

    The L-stable codes follow the slow motion of the inextensible rod, the explicit ones explode or stop.
    """
    text = (DATA / "crankfl.dat").read_text()
    stiff = text.replace("DYNE 2 2 3", "DYNE 2").replace("DYNE 3 2 3", "DYNE 3")
    for k in (2, 3):
        stiff = stiff.replace(f"ESTIFF {k} 0.000000", f"ESTIFF {k} 6.0e6").replace(f"EDAMP {k}", f"% EDAMP {k}")
        stiff = stiff.replace(f"STARTDE {k} 2", f"EDAMP {k} 100.0\nSTARTDE {k} 2")
    deck = spacar.parse_deck(stiff, "stiff.dat", 1)
    reference = spacar.run(1, DATA / "crankfl.dat", duration=0.01, n_steps=10, atol=1e-9, rtol=1e-9)
    for code in (420, 430):
        r = spacar.run(1, deck, duration=0.01, n_steps=10, integrator=code, step=2e-5)
        # The axial elongation under inertia is about 1e-5 m; the motion of the slider is that of the rigid rod length.
        np.testing.assert_allclose(r.node(8, 1), reference.node(8, 1), atol=5e-5)
        assert np.abs(r.element(2, 1)).max() < 1e-4
    with pytest.raises(AnalysisError) as caught:
        spacar.run(1, deck, duration=0.01, n_steps=10, integrator=140, step=1e-4)
    assert "t = " in str(caught.value)
    assert "\n" not in str(caught.value)


def test_dense_output_agrees_with_a_run_that_stops_there() -> None:
    """Output points do not influence the steps: values inside a step to ten times the tolerance."""
    many = spacar.run(1, DATA / "fingersim.dat", duration=0.1, n_steps=100, atol=1e-9, rtol=1e-9)
    few = spacar.run(1, DATA / "fingersim.dat", duration=0.1, n_steps=4, atol=1e-9, rtol=1e-9)
    np.testing.assert_allclose(many["x"][::25], few["x"], atol=1e-7)
    steps = [sum(f.statistics["steps"] for f in r.frames[1:]) for r in (many, few)]
    assert steps[0] <= 1.5 * steps[1] + 10


def test_second_order_codes_refuse_kinematic_coordinates() -> None:
    with pytest.raises(AnalysisError) as caught:
        spacar.run(1, DATA / "trike2.dat", integrator=225)
    assert "kinematic coordinates" in str(caught.value)


@pytest.mark.parametrize(
    ("code", "asked", "atol"),
    [*((code, 1e-8, 1e-5) for code in (0, 155, 140, 330, 430)), (553, 1e-7, 1e-6), (595, 1e-7, 1e-6),
     pytest.param(135, 1e-8, 1e-5, marks=pytest.mark.slow)],
)  # fmt: skip
def test_kinematic_coordinates_with_all_kinds_of_codes(code: int, asked: float, atol: float) -> None:
    """A tricycle that rolls without slip: its kinematic coordinates belong to the first-order part of the state."""
    a = spacar.run(1, DATA / "trike2.dat", n_steps=10, duration=0.2, atol=1e-9, rtol=1e-9)
    step = {} if code > 500 else {"step": 4e-3}
    b = spacar.run(1, DATA / "trike2.dat", n_steps=10, duration=0.2, integrator=code, atol=asked, rtol=asked, **step)
    np.testing.assert_allclose(b["x"], a["x"], atol=atol)


# Codes 553 and 595 on mechanisms: same answers as explicit codes, with steps that high frequencies do not limit.
CODES = (553, 595)


def cantilever(n: int, damping: float = 0.0, load: float = 1.0) -> spacar.Deck:
    """Unit cantilever (L = EI = m = 1) of n beams, released under gravity; highest frequency about 60 n^2 rad/s."""
    dynamics = (*(f"EDAMP {i} 0. {damping!r}" for i in range(1, n + 1)), f"GRAVITY 0. {-load!r}", "TIMESTEP 0.9 6")
    return spacar.parse_deck(models.cantilever(n, EI=1.0, length=1.0, dynamics=dynamics), mode=1)


def run(deck: spacar.Deck, code: int, error: float, compiled: bool | None = False) -> tuple[np.ndarray, dict[str, int]]:
    """Positions at all outputs, and the work."""
    r = spacar.run(1, deck, integrator=code, atol=error, rtol=error, compiled=compiled)
    names = ("steps", "rhs", "jacobians", "rejected")
    return r["x"], {k: sum(f.statistics.get(k, 0) for f in r.frames) for k in names}


@pytest.mark.parametrize("damping", [pytest.param(0.0, marks=pytest.mark.slow), 0.003])
def test_refined_cantilever_against_an_explicit_code(damping: float) -> None:
    deck = cantilever(4, damping)
    exact, explicit = run(deck, 0, 1e-6, None)  # whichever is there: the compiled path is faster
    for code in CODES:
        found, work = run(deck, code, 1e-4, None)
        # The deflection is 0.25; the tolerance of a step is 1e-4.
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-4)
        assert work["steps"] < explicit["steps"]
        assert work["jacobians"] < 5


def energies(result: spacar.Result, n: int) -> np.ndarray:
    """Kinetic + elastic + potential energy at all outputs.

    The weight is consistent with the cubic displacements: its potential is that of both ends and, through their
    tangents, l/12 of the end slopes.
    """
    dynamics = Dynamics(result.mechanism)
    rows, columns, values = dynamics.law.stiffness
    found = []
    for frame in result.frames:
        dynamics.kinematics.x = frame.x.copy()
        dynamics.kinematics.refresh()
        dynamics.sweep.mass()
        kinetic = 0.5 * frame.xd @ dynamics.sweep.mass_times(frame.xd)
        elastic = 0.5 * float(frame.e[rows] @ (values * frame.e[columns]))
        number = result.mechanism.numbering
        y = frame.x[[number.x_index(2 * i + 1, 2) for i in range(n + 1)]]
        slope = np.sin(frame.x[[number.x_index(2 * i + 2, 1) for i in range(n + 1)]])
        weight = (0.5 * (y[:-1] + y[1:]) + (slope[:-1] - slope[1:]) / (12.0 * n)).sum() / n
        found.append(kinetic + elastic + weight)
    return np.array(found)


@pytest.mark.parametrize("code", [0, *CODES])
def test_energy_is_conserved(code: int) -> None:
    """Released cantilever: 0.1 changes hands, so ERROR allows 1e-6 (found: 1e-9 and less)."""
    result = spacar.run(1, cantilever(2), integrator=code, atol=1e-5, rtol=1e-5)
    assert np.ptp(energies(result, 2)) < 0.1 * 1e-5


@pytest.mark.parametrize(("n", "codes"), [(8, (553,)), pytest.param(16, CODES, marks=pytest.mark.slow)])
def test_unresolved_frequencies_do_not_limit_the_steps(n: int, codes: tuple[int, ...]) -> None:
    """Sixteen elements, 15,000 rad/s: an explicit code needs 5,000 steps whatever the error asked for."""
    reference, _ = run(cantilever(n), 595, 1e-4, None)  # whichever is there: the compiled path is faster
    for code in codes:
        found, work = run(cantilever(n), code, 9e-3, None)
        assert work["steps"] < 150
        np.testing.assert_allclose(found, reference, rtol=0, atol=3e-3)


@pytest.mark.parametrize("code", CODES)
def test_examples_reach_the_tolerance(code: int) -> None:
    """Prescribed crank with a flexible rod, and a spatial finger: as explicit codes at 1e-11."""
    for name, duration in (("crankfl", 0.002), ("fingersim", 0.025)):
        options = {"duration": duration, "n_steps": 4}
        found = spacar.run(1, DATA / f"{name}.dat", integrator=code, atol=1e-6, rtol=1e-6, **options)["x"]
        np.testing.assert_allclose(found, exact(name, duration, 4), rtol=0, atol=1e-6)


def test_general_and_compiled_path_take_the_same_steps() -> None:
    pytest.importorskip("spacar.compiled")
    deck = cantilever(2)
    a, of_a = run(deck, 595, 1e-4)
    b, of_b = run(deck, 595, 1e-4, compiled=True)
    # The same mathematics with different rounding: the steps may differ by a few.
    np.testing.assert_allclose(b, a, rtol=0, atol=1e-6)
    assert abs(of_a["steps"] - of_b["steps"]) <= 0.05 * of_a["steps"]


# What codes 553 and 595 must resolve is what ERROR asks of the displacements: cost and error of a released
# cantilever. Truth: the modal solution of the linear motion about the start, for a load so small that what is not
# linear is 1e-6 of it. F and the exact state matrix at the start give q(t) = V (1 - cos(omega t))/omega^2 V^-1 F_u,
# where -dF_u/dq = V omega^2 V^-1.
LOAD = 1e-3  # deflection 2.5e-4 of the length


@cache
def far_better(n: int) -> Array:
    """Coordinates at the outputs, by the modal solution."""
    d = Dynamics(build(cantilever(n, load=LOAD)))
    y0 = d.start()
    f = d.rhs(0.0, y0).copy()
    J = state_jacobian(d, 0.0, y0)[0]
    nq = len(y0) // 2
    squares, V = np.linalg.eig(-J[nq:, :nq])
    squares, V = squares.real, V.real
    amplitudes = np.linalg.solve(V, f[nq:]) / squares
    found = []
    for t in np.linspace(0.0, 0.9, 7):
        y0[:nq] = V @ (amplitudes * (1.0 - np.cos(np.sqrt(squares) * t)))
        d.rhs(t, y0)
        found.append(d.placement().x.copy())
    return np.array(found)


@cache
def work_of(n: int, code: int, error: float) -> tuple[float, int]:
    """Error of the coordinates over ERROR, and the right-hand sides. ERROR is a part of the load."""
    r = spacar.run(1, cantilever(n, load=LOAD), integrator=code, atol=error * LOAD, rtol=1e-14)
    return np.abs(r["x"] - far_better(n)).max() / (error * LOAD), sum(f.statistics.get("rhs", 0) for f in r.frames)


@pytest.mark.parametrize("code", [553, 595])
def test_cost_grows_smoothly_and_error_is_kept(code: int) -> None:
    """Amplitudes of beta^-5 with frequencies of beta^2: a decade of ERROR resolves frequencies 2.5 times as high. When
    velocities counted as such, n = 16 needed 3,149 right-hand sides at 1e-2 and 18,794 at 1e-3 (595)."""
    ratios, rhs = zip(*(work_of(16, code, error) for error in (1e-2, 1e-3, 1e-4)), strict=True)
    assert max(ratios) < 1.0
    assert max(rhs[1] / rhs[0], rhs[2] / rhs[1]) < 4.0
    assert rhs[0] < 300


@pytest.mark.parametrize("code", [553, 595])
def test_finer_meshes_cost_no_more_steps(code: int) -> None:
    """Their further modes are below ERROR; the highest frequency is four times that of half as many elements."""
    (coarse, few), (fine, many) = (work_of(n, code, 1e-3) for n in (8, 16))
    assert max(coarse, fine) < 1.0
    assert many < 1.2 * few


def test_vibrations_that_are_passed_over_are_no_dead_points() -> None:
    """Velocities change by more than the accelerations of such a vibration explain, and 32 beams have no cheap
    determinant. With the accelerations taken for those of the motion this run stopped as reflected."""
    found = spacar.run(1, cantilever(32), integrator=595, atol=1e-2, rtol=1e-2)
    # the continuous beam: 1/8 (1 - cos) of its first mode, nearly; half a period after 0.89 s
    assert found["x"][-1, 3 * 32 + 1] == pytest.approx(-0.25, abs=0.02)
