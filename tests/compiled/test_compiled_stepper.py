"""Steps in C, from output to output: they are those of the integrators in Python, with all that these look at."""

import numpy as np
import pytest

import spacar
from spacar.compiled.compiled_evaluator import CompiledDynamics
from spacar.compiled.library import unavailable
from spacar.errors import AnalysisError
from spacar.forward import accepted_steps, driver
from spacar.integrators import drive
from tests.examples import DATA

from .other_ways import OneByOne, free_crank, pushed, take

pytestmark = pytest.mark.skipif(unavailable() is not None, reason=str(unavailable()))

PENDULUM = """PLBEAM 1 1 2 4 3   PLBEAM 2 4 5 7 6   X 1 0. 0.   X 4 0.7 -0.7   X 7 1.4 -1.4
FIX 1   DYNX 2 1   DYNX 5 1   END HALT
EM 1 1.0   EM 2 1.0   GRAVITY 0. -9.81   TIMESTEP 2. 7   END END
"""
FREE_CRANK = free_crank("1. 3")
CODES = (0, 135, 155, 853)


@pytest.fixture
def one_by_one(monkeypatch):
    """Lets the steps be made in Python."""
    return lambda: take(monkeypatch, OneByOne)


def run(source, **options):
    deck = spacar.parse_deck(source, mode=1) if isinstance(source, str) else source
    return spacar.run(1, deck, **options)


def same(source, one_by_one, tolerance, alike=False, **options):
    """The same steps and motions both ways. `alike`: errors of steps are so near to rounding, or to the tolerance,
    that a step may be taken here and refused there."""
    many = run(source, **options)
    one_by_one()
    single = run(source, **options)
    if alike:
        steps, others = (sum(f.statistics["steps"] for f in r.frames[1:]) for r in (many, single))
        assert steps == pytest.approx(others, rel=0.1, abs=3)
    else:
        assert [f.statistics for f in many.frames] == [f.statistics for f in single.frames]
    for name in ("x", "xd"):
        np.testing.assert_allclose(many[name], single[name], atol=tolerance * np.abs(single[name]).max(), rtol=0)


@pytest.mark.parametrize("code", CODES)
@pytest.mark.parametrize("model", [PENDULUM, FREE_CRANK], ids=["pendulum", "crank"])
def test_steps_and_states_are_those_of_python(model, code, one_by_one):
    """Sums are rounded in another order: eps, grown by the motion."""
    same(model, one_by_one, 1e-9, integrator=code, atol=1e-4, rtol=1e-4)


@pytest.mark.parametrize("name", ["robotsim", "cardan", "fourbar", "trike2", "screw"])
@pytest.mark.parametrize("code", [0, 853])
def test_examples(name, code, one_by_one):
    """Spatial, with wheels and a screw (ERROR is 1e-4) that Python evaluates, with prescribed motions."""
    rough = name == "screw"
    same(DATA / f"{name}.dat", one_by_one, 1e-3 if rough else 1e-8, alike=rough, integrator=code)


def test_orders_up_to_twelve(one_by_one):
    """A tight tolerance brings Adams to its high orders, so that every coefficient is used."""
    same(PENDULUM, one_by_one, 1e-9, alike=True, integrator=0, atol=1e-9, rtol=1e-9)


@pytest.mark.parametrize("code", CODES)
def test_breaks(code):
    """A new start at each; the first step after it is not longer than the last before it."""
    found = []
    for trailed in (True, False):
        problem, y = problem_of(FREE_CRANK, trailed)
        found.append(list(drive.integrate(problem, y, [0.0, 0.3, 1.0], code, 1e-7, 1e-7, breaks=(0.2, 0.7))))
    for a, b in zip(*found, strict=True):
        np.testing.assert_allclose(a.y, b.y, rtol=1e-9)
        assert (a.work.n_steps, a.work.n_rhs, a.work.n_rejected) == (b.work.n_steps, b.work.n_rhs, b.work.n_rejected)


def problem_of(text, trailed):
    """What the integrators see of a model, and its start state; `trailed`: steps are made in C."""
    evaluator = CompiledDynamics(spacar.frames(1, spacar.parse_deck(text, mode=1)).mechanism)
    y = evaluator.start()
    trail = accepted_steps.StepHistory(evaluator, None, lambda t: None)
    return driver.Integrand(evaluator, trail, 1e-11, evaluator.stepper(trail) if trailed else None, trail=trail), y


@pytest.mark.parametrize("code", [0, 155])
def test_user_functions_are_called_in_every_step(code, tmp_path, one_by_one):
    path = pushed(tmp_path, "return t, [], [[2, 1, 0.02 * t]]", FREE_CRANK)
    same(path, one_by_one, 1e-9, integrator=code)


@pytest.mark.parametrize("code", [0, 155])
def test_a_user_function_that_fails_ends_the_run_with_the_sentences_of_python(code, tmp_path, one_by_one):
    path = pushed(tmp_path, "return t, [], [[2, 1, 1.0 / (t < 0.4)]]", FREE_CRANK)
    said = []
    for _ in range(2):
        with pytest.raises(AnalysisError, match="ZeroDivisionError") as caught:
            run(path, integrator=code)
        said.append(str(caught.value))
        one_by_one()
    first, second = (text.split(" after ")[0] for text in said)  # behind it: sizes of steps near rounding
    assert first == second
    assert said[0].endswith("correct the function")


@pytest.mark.parametrize("code", [0, 155])
def test_too_many_steps_are_counted(code):
    problem, y = problem_of(FREE_CRANK, True)
    with pytest.raises(AnalysisError, match="more than 40 integration steps"):
        list(drive.integrate(problem, y, [0.0, 50.0], code, 1e-8, 1e-8, max_steps=40))


@pytest.mark.parametrize("code", CODES)
def test_a_long_way_between_outputs_equals_one_in_many_outputs(code):
    """83 turns between outputs: each is placed from the start of its own step."""
    far, near = (run(free_crank(t), integrator=code, atol=1e-7, rtol=1e-7) for t in ("4. 2", "4. 400"))
    np.testing.assert_allclose(far["x"][-1], near["x"][-1], atol=1e-4)
    np.testing.assert_allclose(far["x"][1], near["x"][200], atol=1e-4)
