"""What codes 553 and 595 must resolve is what ERROR asks of the displacements: cost and error of a released cantilever.

Truth: the modal solution of the linear motion about the start, for a load so small that what is not linear is 1e-6 of
it. F and the exact state matrix at the start give q(t) = V (1 - cos(omega t))/omega^2 V^-1 F_u, where -dF_u/dq =
V omega^2 V^-1.
"""

from functools import cache

import models
import numpy as np
import pytest

import spacar
from spacar.arrays import Array
from spacar.deck import parse_deck
from spacar.deck.deck import Deck
from spacar.dynamics.array_evaluator import Dynamics
from spacar.linearization.state_jacobian import state_jacobian
from spacar.mechanism import build

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
def run(n: int, code: int, error: float) -> tuple[float, int]:
    """Error of the coordinates over ERROR, and the right-hand sides. ERROR is a part of the load."""
    r = spacar.run(1, released(n), integrator=code, atol=error * LOAD, rtol=1e-14)
    return np.abs(r["x"] - exact(n)).max() / (error * LOAD), sum(f.statistics.get("rhs", 0) for f in r.frames)


@pytest.mark.parametrize("code", [553, 595])
def test_cost_grows_smoothly_and_error_is_kept(code: int) -> None:
    """Amplitudes of beta^-5 with frequencies of beta^2: a decade of ERROR resolves frequencies 2.5 times as high. When
    velocities counted as such, n = 16 needed 3,149 right-hand sides at 1e-2 and 18,794 at 1e-3 (595)."""
    ratios, rhs = zip(*(run(16, code, error) for error in (1e-2, 1e-3, 1e-4)), strict=True)
    assert max(ratios) < 1.0
    assert max(rhs[1] / rhs[0], rhs[2] / rhs[1]) < 4.0
    assert rhs[0] < 300


@pytest.mark.parametrize("code", [553, 595])
def test_finer_meshes_cost_no_more_steps(code: int) -> None:
    """Their further modes are below ERROR; the highest frequency is four times that of half as many elements."""
    (coarse, few), (fine, many) = (run(n, code, 1e-3) for n in (8, 16))
    assert max(coarse, fine) < 1.0
    assert many < 1.2 * few


def test_vibrations_that_are_passed_over_are_no_dead_points() -> None:
    """Velocities change by more than the accelerations of such a vibration explain, and 32 beams have no cheap
    determinant. With the accelerations taken for those of the motion this run stopped as reflected."""
    found = spacar.run(1, released(32, 1.0), integrator=595, atol=1e-2, rtol=1e-2)
    # the continuous beam: 1/8 (1 - cos) of its first mode, nearly; half a period after 0.89 s
    assert found["x"][-1, 3 * 32 + 1] == pytest.approx(-0.25, abs=0.02)
