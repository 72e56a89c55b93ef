"""Both evaluators keep the contract of `spacar.dynamics.evaluator`: they say the same of a state.

A position is known to 1e-11 of the model size (CONVERGED); stiffness turns that into forces, so the bound is 1e-8 of
the largest value of each kind, as in `tests/compiled`.
"""

import numpy as np
import pytest

import spacar
from spacar.compiled import CompiledDynamics
from spacar.compiled.library import unavailable
from spacar.dynamics import Dynamics
from spacar.dynamics.evaluator import Evaluator
from spacar.dynamics.motion_equations import EquationsOfMotion
from spacar.errors import AnalysisError
from spacar.linearization.matrices import linearize
from spacar.linearization.state_jacobian import state_jacobian
from tests.examples import DATA

MODELS = ["robotsim", "crankfl", "plbeam5"]

pytestmark = pytest.mark.skipif(unavailable() is not None, reason=str(unavailable()))


def pair(name: str) -> tuple[list[Evaluator], np.ndarray]:
    """The evaluators at the start, and a state near it that moves."""
    mechanism = spacar.frames(1, DATA / f"{name}.dat").mechanism
    both: list[Evaluator] = [Dynamics(mechanism), CompiledDynamics(mechanism)]
    y, start = (evaluator.start() for evaluator in both)
    np.testing.assert_array_equal(start, y)
    rng, n = np.random.default_rng(7), both[0].n_positions
    return both, y + np.r_[1e-3 * rng.standard_normal(n), rng.standard_normal(len(y) - n)]


def same(found: np.ndarray, expected: np.ndarray, size: float | None = None) -> None:
    size = np.abs(expected).max(initial=0.0) if size is None else size
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * max(size, 1e-12))


@pytest.mark.parametrize("name", MODELS)
def test_every_protocol(name):
    (general, compiled), y = pair(name)
    assert compiled.n_positions == general.n_positions
    assert [compiled.component_name(i) for i in range(len(y))] == [general.component_name(i) for i in range(len(y))]
    same(compiled.rhs(1e-3, y), general.rhs(1e-3, y))
    a, b = general.placement(), compiled.placement()
    same(b.x, a.x)
    same(b.xd, a.xd)
    same(b.e, a.e, 1.0)
    assert compiled.condition() == pytest.approx(general.condition(), rel=1e-8)
    assert compiled.position_matrix().rcond() == pytest.approx(general.position_matrix().rcond(), rel=1e-8)
    for evaluator in (general, compiled):  # its sweeps and factors are those of the state
        numpy_evaluator = evaluator.numpy_evaluator()
        same(numpy_evaluator.kinematics.x, a.x)
        same(numpy_evaluator.xd, a.xd)
        sweep = numpy_evaluator.sweep
        same(sweep.gradient() @ numpy_evaluator.xd, sweep.rate(a.xd), np.abs(a.xd).max())


@pytest.mark.parametrize("name", MODELS)
def test_stages_are_right_hand_sides(name):
    """K_i = F(t + c_i h, y + h a_i K), of Heun's method of third order."""
    (general, compiled), y = pair(name)
    c, a, h = np.array([0.0, 1 / 3, 2 / 3]), np.array([[0.0, 0, 0], [1 / 3, 0, 0], [0, 2 / 3, 0]]), 1e-6
    K = np.zeros((3, len(y)))
    K[0] = compiled.rhs(0.0, y)
    assert general.blocks is None
    assert compiled.blocks.stages(1, c, a, 0.0, h, (0.0, 1.0), y, K, 1e-11) == 3
    for i in (1, 2):
        same(K[i], general.rhs(c[i] * h, y + h * (a[i] @ K)))


@pytest.mark.parametrize("name", MODELS)
def test_a_companion_goes_its_own_way(name):
    """What it evaluates leaves the first one where it stands."""
    both, y = pair(name)
    for evaluator in both:
        evaluator.rhs(1e-3, y)
        before = evaluator.placement().x.copy()
        other = evaluator.fork()
        other.frame(2e-3, 0.5 * y)
        np.testing.assert_array_equal(evaluator.placement().x, before)
        same(evaluator.numpy_evaluator().kinematics.x, before)


@pytest.mark.parametrize("name", ["robotsim", "crankfl"])
def test_settling_does_not_disturb_what_follows(name):
    """The same numbers to the last bit, with and without."""
    (_, compiled), y = pair(name)
    (_, undisturbed), _ = pair(name)
    compiled.rhs(1e-3, y)
    compiled.numpy_evaluator().place(0.0, 0.5 * y)
    undisturbed.rhs(1e-3, y)
    np.testing.assert_array_equal(compiled.rhs(1.1e-3, y), undisturbed.rhs(1.1e-3, y))


@pytest.mark.parametrize("name", MODELS)
def test_the_state_that_c_could_not_do_is_settled_with_its_velocity(name, monkeypatch):
    """The general evaluator has done it; its velocity, too, is that of the state afterwards."""
    (general, compiled), y = pair(name)
    compiled.rhs(0.0, y)
    other = y.copy()
    other[general.n_positions :] *= 2.0
    frame = general.frame(1e-3, other)
    monkeypatch.setattr(type(compiled.solver), "evaluate", lambda *arguments: -1)
    same(compiled.frame(1e-3, other).xdd, frame.xdd)
    numpy_evaluator = compiled.numpy_evaluator()
    same(numpy_evaluator.xd, frame.xd)
    expected = linearize(general, frame.xdd, frame.sig, t=frame.t)
    same(linearize(numpy_evaluator, frame.xdd, frame.sig, t=frame.t).c0, expected.c0)


@pytest.mark.parametrize("name", ["robotsim", "crankfl", "plbeam5"])
def test_mode_4_linearizes_about_the_frame_that_c_evaluated(name):
    """It was linearized about another state: c0 of crankfl was wrong by 130 %, n0 by 226 %, and robotsim failed.

    Steps are controlled with the default ERROR (1e-4), and both paths choose them alike up to rounding.
    """
    options = {"duration": 0.01, "n_steps": 4}
    a = spacar.run(4, DATA / f"{name}.dat", **options)
    b = spacar.run(4, DATA / f"{name}.dat", compiled=True, **options)
    for frame, expected in zip(b.frames, a.frames, strict=True):
        assert frame.matrices.keys() == expected.matrices.keys()
        for key, value in expected.matrices.items():
            np.testing.assert_allclose(
                frame.matrices[key], value, rtol=0, atol=1e-4 * max(np.abs(value).max(initial=0.0), 1e-9)
            )


def test_a_failure_is_explained_alike():
    """A rod of a slider-crank that cannot reach: the same error with the same words, whoever met it."""
    text = "PLRBEAM 1 1 2 3\nPLTRUSS 2 3 4\nX 3 1. 0.\nX 4 2. 0.5\nFIX 1\nFIX 4 2\nDYNX 2 1\nEND\nHALT\n"
    mechanism = spacar.frames(1, spacar.deck.parse_deck(text + "XM 3 1.\nXM 4 1.\nEND\nEND\n", mode=1)).mechanism
    said = []
    for evaluator in (Dynamics(mechanism), CompiledDynamics(mechanism)):
        y = evaluator.start()
        with pytest.raises(AnalysisError) as found:
            evaluator.rhs(0.1, np.array([-np.pi / 2 - 0.5, 0.0]))
        said.append((found.value.code, str(found.value).split(";")[0]))
        assert np.isfinite(evaluator.rhs(0.0, y)).all()  # it goes on from where it stood
    assert said[0] == said[1]


def test_the_jacobian_asks_for_the_position_it_is_given():
    """`within` reaches Newton's method in both: with a wide one, one iteration is enough.

    Then V is that of a configuration 1e-5 away, and the Jacobian with it: ten times that is allowed.
    """
    both, y = pair("crankfl")
    for evaluator in both:
        evaluator.rhs(1e-3, y)
        wide, _ = state_jacobian(evaluator, 1e-3, y + 1e-5, 1.0)
        assert evaluator.numpy_evaluator().kinematics.iterations <= 1
        narrow, _ = state_jacobian(evaluator, 1e-3, y + 1e-5)
        np.testing.assert_allclose(wide, narrow, rtol=0, atol=1e-4 * np.abs(narrow).max())


def test_the_numpy_evaluator_overrides_nothing_of_the_equations():
    """The physics stands in one place."""
    own = {name for name in vars(Dynamics) if callable(getattr(Dynamics, name))} - {"__init__"}
    assert not own & vars(EquationsOfMotion).keys()
