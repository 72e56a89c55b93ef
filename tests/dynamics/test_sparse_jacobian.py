"""Implicit codes with the sparse form of the Jacobian (above 300 degrees of freedom) and with the dense one."""

from pathlib import Path

import frames
import numpy as np
import pytest
from scipy.sparse import csr_array

import spacar
from spacar.compiled import CompiledDynamics
from spacar.dynamics import Dynamics
from spacar.errors import AnalysisError
from spacar.integrators.resolvent import eliminated, resolvent
from spacar.linearization import state_jacobian as jacobian
from spacar.linearization.descriptor import DescriptorSystem
from spacar.mechanism import build

ROOT = Path(__file__).resolve().parents[2]

# wheels, a slider-crank with a flexible rod and prescribed motion, a robot, flexures, a screw
MODELS = ("trike2", "crankfl", "robotflexsim", "lateral4", "fingersim", "plbeam5free", "screw", "massspring")


@pytest.mark.parametrize("name", MODELS)
def test_both_forms_solve_the_same(name, monkeypatch):
    """(s I - J)^-1 b at a displaced moving state, s real and complex, to the condition of the mass matrix."""
    evaluator = Dynamics(build(spacar.read_deck(ROOT / "data" / f"{name}.dat"), 1))
    rng = np.random.default_rng(1)
    y = evaluator.start()
    y = y + 1e-3 * rng.normal(size=y.size)
    b, nq = rng.normal(size=y.size), eliminated(len(y), evaluator.n_positions)
    for s in (30.0, 30.0 + 50.0j):
        J = jacobian.state_jacobian(evaluator, 0.1, y, 1e-13)[0]
        whole = np.linalg.solve(s * np.eye(len(y)) - J, b)
        dense = resolvent(J, s, nq, 0.0, 0.0)(b)
        with monkeypatch.context() as patch:
            patch.setattr(jacobian, "LARGE", -1)
            sparse = resolvent(jacobian.state_jacobian(evaluator, 0.1, y, 1e-13)[0], s, nq, 0.0, 0.0)(b)
        for found in (dense, sparse):
            np.testing.assert_allclose(found, whole, rtol=0, atol=1e-9 * np.abs(whole).max())


@pytest.mark.parametrize("code", [310, 330, 420, 595, pytest.param(553, marks=pytest.mark.slow)])
def test_runs_agree(code, monkeypatch):
    """A frame of 44 beams that is released: its first outputs, to what is left by iterations within ERROR."""
    deck = spacar.parse_deck(frames.deck((3, 2, 1), 1), mode=1)
    options = {"integrator": code, "duration": 0.01, "n_steps": 3, "atol": 1e-9, "rtol": 1e-9}
    dense = spacar.run(1, deck, **options)["x"]
    monkeypatch.setattr(jacobian, "LARGE", 0)
    sparse = spacar.run(1, deck, **options)["x"]
    np.testing.assert_allclose(sparse, dense, rtol=0, atol=1e-9)


class Nowhere:
    """A form whose factors turn out to be useless."""

    def resolvent(self, s):
        return lambda b: np.full_like(b, np.nan)


@pytest.mark.parametrize("form", ["dense", "sparse", "found late"])
def test_an_eigenvalue_of_the_step(form):
    """y' = diag(1, 2) y with s = 1: said with time, step and what to change."""
    A = np.diag([1.0, 2.0])
    J = {"dense": A, "sparse": DescriptorSystem(csr_array(A), None, None, 2), "found late": Nowhere()}[form]
    with pytest.raises(AnalysisError, match=r"singular at t = 3 s with step size 0.1 s .*INTEGRAT position 2") as found:
        resolvent(J, 1.0, 0, 3.0, 0.1)(np.ones(2))
    assert found.value.code == "integrator.singular"


def test_what_is_remembered_of_a_step_is_its_end(monkeypatch):
    """Not its last stage, so far off that a step over vibrations was halved 40 times in search of a dead point."""
    from spacar.forward.continuity import Continuity

    seen = []
    check = Continuity.check
    monkeypatch.setattr(Continuity, "check", lambda self, t, y: (check(self, t, y), seen.append(self.steps[-1]))[0])
    deck = spacar.parse_deck(frames.deck((3, 2, 1), 1), mode=1)
    result = spacar.run(1, deck, integrator=320, duration=0.01, n_steps=2)
    n = result.mechanism.numbering
    for step in seen:
        at = np.concatenate((step.at.x[n.x_class["dynamic"]], step.at.e[n.e_class["dynamic"]]))
        np.testing.assert_allclose(at, step.y[: n.nddof], rtol=0, atol=1e-14)
    assert len(seen) > 2


# Right-hand sides of lattices: the engine's where its factors are cheap, else NumPy's with condensed factors.
CELLS = [((4, 2, 2), False), ((12, 12), False), ((8, 4, 4), False), ((10, 5, 5), True)]


@pytest.mark.parametrize(("cells", "large"), CELLS)
def test_the_engine_leaves_large_lattices_to_numpy_and_both_agree(cells, large):
    """Accelerations at a displaced, moving state; 2e-13 of the largest was found (condition of the mass matrix)."""
    mechanism = build(spacar.parse_deck(frames.deck(cells, 1)), 1)
    compiled = CompiledDynamics(mechanism)
    assert compiled.solver.too_large() == large
    numpy_evaluator = Dynamics(mechanism)
    y = numpy_evaluator.start_values()
    y = y + 1e-4 * np.random.default_rng(3).normal(size=y.size)
    want, got = (e.rhs(0.0, y).copy() for e in (numpy_evaluator, compiled))
    np.testing.assert_allclose(got, want, rtol=0, atol=1e-10 * np.abs(want).max())
