"""Codes 553 and 595 on mechanisms: same answers as explicit codes, with steps that high frequencies do not limit."""

from functools import cache

import models
import numpy as np
import pytest

import spacar
from spacar.arrays import Array
from spacar.deck import parse_deck
from spacar.deck.deck import Deck
from spacar.dynamics import Dynamics
from spacar.linearization.state_jacobian import state_jacobian
from spacar.mechanism import build
from tests.examples import DATA

CODES = (553, 595)


def cantilever(n: int, damping: float = 0.0) -> Deck:
    """Unit cantilever (L = EI = m = 1) of n beams, released under gravity 1; highest frequency about 60 n^2 rad/s."""
    dynamics = (*(f"EDAMP {i} 0. {damping!r}" for i in range(1, n + 1)), "GRAVITY 0. -1.", "TIMESTEP 0.9 6")
    return parse_deck(models.cantilever(n, EI=1.0, length=1.0, dynamics=dynamics), mode=1)


def run(deck: Deck, code: int, error: float, compiled: bool | None = False) -> tuple[np.ndarray, dict[str, int]]:
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


@cache
def at_1e_10(name: str, duration: float) -> np.ndarray:
    options = {"duration": duration, "n_steps": 4}
    return spacar.run(1, DATA / f"{name}.dat", integrator=155, atol=1e-10, rtol=1e-10, **options)["x"]


@pytest.mark.parametrize("code", CODES)
def test_examples_reach_the_tolerance(code: int) -> None:
    """Prescribed crank with a flexible rod, and a spatial finger: as explicit codes at 1e-10."""
    for name, duration in (("crankfl", 0.002), ("fingersim", 0.025)):
        options = {"duration": duration, "n_steps": 4}
        found = spacar.run(1, DATA / f"{name}.dat", integrator=code, atol=1e-6, rtol=1e-6, **options)["x"]
        np.testing.assert_allclose(found, at_1e_10(name, duration), rtol=0, atol=1e-6)


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


def released(n: int, load: float = LOAD) -> Deck:
    """Unit cantilever (L = EI = m = 1) of n beams, released under its weight."""
    dynamics = (f"GRAVITY 0. {-load!r}", "TIMESTEP 0.9 6")
    return parse_deck(models.cantilever(n, EI=1.0, length=1.0, dynamics=dynamics), mode=1)


@cache
def exact(n: int) -> Array:
    """Coordinates at the outputs, by the modal solution."""
    d = Dynamics(build(released(n)))
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
    r = spacar.run(1, released(n), integrator=code, atol=error * LOAD, rtol=1e-14)
    return np.abs(r["x"] - exact(n)).max() / (error * LOAD), sum(f.statistics.get("rhs", 0) for f in r.frames)


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
    found = spacar.run(1, released(32, 1.0), integrator=595, atol=1e-2, rtol=1e-2)
    # the continuous beam: 1/8 (1 - cos) of its first mode, nearly; half a period after 0.89 s
    assert found["x"][-1, 3 * 32 + 1] == pytest.approx(-0.25, abs=0.02)
