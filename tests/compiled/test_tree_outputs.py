"""Outputs of rigid trees: stresses from the tips inwards, nodal forces and rates, all as on the general path, which
solves the equations of all elements.

Both know forces to the rounding of sums of some hundred terms, in accelerations of the condition of the mass matrix:
1e-9 of the largest value of each kind.
"""

import numpy as np
import pytest

import spacar
from spacar.compiled import CompiledDynamics
from spacar.compiled.library import unavailable
from spacar.deck import parse_deck
from spacar.dynamics import Dynamics
from spacar.errors import Report
from spacar.forward.accepted_steps import singularity_monitor
from spacar.frame import E_FIELDS, X_FIELDS
from spacar.mechanism import build
from tests.examples import DATA

from .test_tree_motion import CASES

pytestmark = pytest.mark.skipif(unavailable() is not None, reason=str(unavailable()))


def started(text: str) -> tuple[Dynamics, CompiledDynamics, np.ndarray]:
    mechanism = build(parse_deck(text, 1), 1)
    general, compiled = Dynamics(mechanism), CompiledDynamics(mechanism)
    y = general.start()
    compiled.start()
    return general, compiled, y


@pytest.mark.parametrize(("grow", "seed", "links"), CASES)
def test_frames_of_random_trees(grow, seed, links):
    general, compiled, y = started(grow(seed, links))
    rng = np.random.default_rng(seed)
    rigid = slice(0, compiled.numbering.e_class["input"].start)
    for k in range(3):
        t, state = 0.01 * k, y + 0.3 * k * rng.standard_normal(len(y))
        a, b = general.frame(t, state), compiled.frame(t, state)
        assert not b.e[rigid].any()  # the equations of all elements leave rounding there
        scale = max(1.0, *(np.abs(getattr(a, of)).max() for of in ("xdd", "fxtot")))
        for name in (*X_FIELDS, *E_FIELDS):
            want = getattr(a, name)
            size = max(scale, np.abs(want).max())
            np.testing.assert_allclose(getattr(b, name), want, atol=1e-9 * size, rtol=0, err_msg=name)
        compiled._y[:] = state
        assert compiled.solver.rhs(compiled.state, t + 1e-9, *compiled._addresses, 1e-14) == 0  # others iterate
        want = general.rhs(t + 1e-9, state, 1e-14)
        np.testing.assert_allclose(compiled._out, want, atol=1e-9 * max(1.0, np.abs(want).max()), rtol=0)


def test_forces_of_a_hanging_chain():
    """At rest every hinge carries the weight below it, N = m g (closed form); nothing moves."""
    n, mass, g = 5, 2.0, 9.81
    rows = []
    for k in range(n):
        rows.append(f"PLTOR {2 * k + 1} {2 * k + 1 if k else 100} {2 * k + 3}")
        rows.append(f"PLRBEAM {2 * k + 2} {2 * k + 2} {2 * k + 3} {2 * k + 4}")
    rows += [f"X {2 * k + 2} 0.0 {-float(k)}" for k in range(n + 1)]
    rows += ["FIX 100", "FIX 2", *(f"DYNE {2 * k + 1} 1" for k in range(n)), "END", "HALT"]
    rows += [f"XM {2 * k + 4} {mass}" for k in range(n)]
    rows += [f"GRAVITY 0.0 {-g}", "TIMESTEP 0.1 1", "END", "END", ""]
    _, compiled, y = started("\n".join(rows))
    frame = compiled.frame(0.0, y)
    numbering = compiled.numbering
    for k in range(n):
        along = [abs(frame.sig[numbering.e_index(2 * k + 2, mode)]) for mode in (1, 2)]
        assert max(along) == pytest.approx((n - k) * mass * g, rel=1e-14)
        assert min(along) <= 1e-14 * n * mass * g
    assert np.abs(frame.xdd).max() <= 1e-13 * g
    np.testing.assert_allclose(frame.fxtot[numbering.x_index(2, 2)], n * mass * g, rtol=1e-14)


@pytest.mark.parametrize(("grow", "seed", "links"), CASES[3::9])
def test_a_state_that_is_there_is_not_evaluated_again(grow, seed, links):
    """The start is handed on: as derivative, frame and fork; other loads at the same state are seen."""
    _, compiled, y = started(grow(seed, links))
    shown = compiled.fork()
    frames = [e.frame(0.0, y) for e in (compiled, shown)]
    rates = compiled.rhs(0.0, y)
    fresh = CompiledDynamics(compiled.model.mechanism)
    fresh.rhs(0.5, y)
    want, again = fresh.rhs(0.0, y), fresh.frame(0.0, y)
    size = max(1.0, np.abs(want).max())
    np.testing.assert_allclose(rates, want, atol=1e-12 * size, rtol=0)
    for frame in frames:
        for name in (*X_FIELDS, *E_FIELDS):
            value = getattr(again, name)
            np.testing.assert_allclose(
                getattr(frame, name), value, atol=1e-12 * max(size, np.abs(value).max()), rtol=0, err_msg=name
            )
    force = np.zeros(len(frames[0].x))
    force[compiled.numbering.x_class["calculable"]] = 1.0
    compiled.push(np.zeros(len(frames[0].e)), force)
    np.testing.assert_allclose(compiled.frame(0.0, y).fx, frames[0].fx + force, atol=1e-13, rtol=1e-13)


@pytest.mark.parametrize(("grow", "seed", "links"), CASES)
def test_the_bound_of_the_condition_holds_everywhere(grow, seed, links):
    """Never above the reciprocal condition of the general path, which is an estimate from above within a factor of
    three; and of use: above the limit of a doubtful position, so that dead points are not looked for."""
    general, compiled, y = started(grow(seed, links))
    bound = compiled.solver.rcond_everywhere()
    rng = np.random.default_rng(seed)
    for k in range(3):
        general.frame(0.0, y + k * rng.standard_normal(len(y)))
        assert bound <= general.position_matrix().rcond()
    assert bound > 1e-6
    assert compiled.position_matrix().regular_everywhere()
    assert singularity_monitor(compiled, Report()) is None


@pytest.mark.parametrize("name", ["crank2", "crankfl"])
def test_other_mechanisms_have_dead_points(name):
    compiled = CompiledDynamics(spacar.frames(1, DATA / f"{name}.dat").mechanism)
    compiled.start()
    assert not compiled.position_matrix().regular_everywhere()
    assert singularity_monitor(compiled, Report()) is not None
