"""The start of a motion in C: it is recorded as Python does it, and shown before the outputs behind it."""

import re
from typing import Any

import numpy as np
import pytest

import spacar
from spacar.compiled import CompiledDynamics
from spacar.compiled.compiled_model import DOUBTFUL_MASS
from spacar.compiled.library import why_off
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.mass_check import dynamic_mass, is_doubtful, largest_mass
from spacar.errors import AnalysisError
from spacar.forward import motion as forward
from spacar.frame import StoredFrames
from spacar.integrators import radau
from spacar.kinematics.kinematics import CONVERGED
from spacar.mechanism import build
from spacar.mechanism.mechanism import Mechanism
from tests.examples import DATA

from .other_ways import IterationInPython, OneByOne, pushed, take
from .test_output_block import SLIDER, UPRIGHT, slider

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))


@pytest.mark.parametrize("options", [{}, {"integrator": 0}])
def test_the_outputs_behind_the_start_come_together(options):
    start, block = spacar.frames(1, slider(1.0, 10), **options).blocks()
    assert isinstance(block, StoredFrames)
    np.testing.assert_array_equal([start[0].t, *block.t], np.linspace(0.0, 1.0, 11))
    assert set(start[0].statistics.values()) == {0}  # nothing has been done yet
    assert block[0].statistics["rhs"] == 1 + 2 * block[0].statistics["steps"] + block[0].statistics["rejected"]


@pytest.mark.parametrize("error", [1e-3, 1e-6])
def test_a_dead_point_in_the_first_steps_is_seen(error, monkeypatch):
    """The first output lies behind it; the sentences are those of steps in Python."""
    deck, said = slider(4.0, 1, ("ERROR", error, error)), []
    for _ in range(2):
        run, ended = spacar.frames(1, deck), ""
        try:
            list(run)
        except AnalysisError as stopped:
            ended = str(stopped)
        said.append([re.sub(r"(t =|and) [\d.]+", "", text) for text in (*run.report.lines, ended)])
        take(monkeypatch, OneByOne)
    assert said[0] == said[1]
    assert any("singular position" in text for text in said[0])


@pytest.mark.parametrize("integrator", [-1, 0, 155])
@pytest.mark.parametrize(("body", "error", "said"), [
    ("return t, [], [[2, 1, 0.0 / (t == 0.0)]]", AnalysisError, "ZeroDivisionError"),
    ("if t > 0.0: raise KeyboardInterrupt\n    return t, [], []", KeyboardInterrupt, None),
], ids=["exception", "interruption"])  # fmt: skip
def test_the_frame_of_the_start_stays_when_nothing_behind_it_can_be_evaluated(body, error, said, integrator, tmp_path):
    """An exception of the user function at every later time, and an interruption, which is heard."""
    path = pushed(tmp_path, body)
    times = []
    with pytest.raises(error, match=said):
        times.extend(frame.t for frame in spacar.frames(1, path, integrator=integrator))
    assert times == [0.0]


@pytest.mark.parametrize("given", [True, False], ids=["prescribed", "free"])
def test_steps_are_watched_where_there_are_any(given, monkeypatch):
    """Outputs of a prescribed motion are placed one after the other: no step is looked at, no determinant sampled."""
    rows = [("INPUTX", 5, 1, UPRIGHT, -0.1, 0.0), ("TIMESTEP", 1.0, 10)]
    deck = spacar.Deck.build([*SLIDER[:-1], ("INPUTX", 5, 1)], rows, mode=1) if given else slider(1.0, 10)
    asked = []
    monkeypatch.setattr(forward, "singularity_monitor", lambda *of: asked.append(of))
    assert len(spacar.run(1, deck).frames) == 11
    assert len(asked) == (not given)


# The start of a motion in C: the first look at the mass matrix, and the bound of the condition before it.
HEAVY = """
PLBEAM 1 1 2 4 3   PLBEAM 2 4 5 7 6   X 1 0. 0.   X 4 0. -1.   X 7 0.5 -1.5
FIX 1   DYNX 2 1   DYNX 5 1   END HALT
XM 4 1.   XM 7 {mass}   STARTDX 2 1 0.3 0.   STARTDX 5 1 0.4 0.   TIMESTEP 1. 1   END END
"""


def looked_at(mechanism: Mechanism) -> tuple[bool, bool]:
    """What C and NumPy say at the start: is the mass matrix to be looked at closely?"""
    compiled, general = CompiledDynamics(mechanism), Dynamics(mechanism)
    y = general.start_values()
    state, out = y.copy(), np.zeros_like(y)
    status = compiled.solver.start(compiled.state, state.ctypes.data, out.ctypes.data, True)
    general.rhs(0.0, y, CONVERGED)
    general.sweep.mass()
    largest = largest_mass(mechanism, general.sweep)
    M = dynamic_mass(general.kinematics, general.coupling)
    return status == DOUBTFUL_MASS, is_doubtful(mechanism, M, general.condition(), largest)


@pytest.mark.parametrize("mass", [10.0**-k for k in range(18)])
def test_light_masses_are_doubted_as_in_numpy(mass: float) -> None:
    """Up to the last pivot of a Cholesky factorization, which NumPy asks by eigenvalues: the same answer."""
    mechanism = build(spacar.parse_deck(HEAVY.format(mass=mass), mode=1), 1)
    in_c, in_numpy = looked_at(mechanism)
    assert in_c == in_numpy
    assert in_c == (mass < 1.5e-8)  # sqrt(eps) of the largest mass


@pytest.mark.parametrize("name", ["slider", "crank", "crankfl", "fourbar", "cardan", "robotsim", "plbeam5", "trike3v"])
def test_the_bound_of_the_condition_is_one(name: str) -> None:
    """From below for the reciprocal condition, and not far from it: by a factor of 100 in these models."""
    compiled = CompiledDynamics(build(spacar.read_deck(DATA / f"{name}.dat", 1), 1))
    compiled.start()
    exact, bound = compiled.solver.rcond(), compiled.solver.rcond(0.0)
    assert 0.01 * exact < bound <= exact * (1.0 + 1e-12)
    assert compiled.position_matrix().rcond() == exact
    assert compiled.solver.rcond(np.inf, 0) == 0.0  # not asked for with so many unknowns
    assert compiled.position_matrix().surely_regular()


# The Newton iteration of codes 553 and 595 in C makes the steps of the one in Python, with the same counts.
COUNTS = ("steps", "rhs", "jacobians", "rejected", "iterations")


def both(monkeypatch: pytest.MonkeyPatch, source: object, code: int, **options: float) -> list[spacar.Result]:
    """Results with the iteration in C, and in Python, which it leaves without a trace."""
    calls = []

    class Counted(CompiledDynamics):
        def newton(self, *arguments: Any) -> tuple[bool, float, float] | None:
            calls.append(super().newton(*arguments))
            return calls[-1]

    found = []
    for kind in (Counted, IterationInPython):
        take(monkeypatch, kind)
        found.append(spacar.run(1, source, integrator=code, **options))  # type: ignore[arg-type]
    assert calls
    assert None not in calls
    return found


FREE = """PLTRUSS 1 1 2   X 2 1 0   DYNX 1   DYNX 2   RLSE 1 1   END HALT
XM 1 2   XM 2 1   ESTIFF 1 50   STARTDX 2 2 0 3   END END"""


@pytest.mark.parametrize("code", [553, 595])
@pytest.mark.parametrize("name", ["crankfl", "fingersim", "trike2", "trike3v", "free"])
def test_the_same_steps(monkeypatch: pytest.MonkeyPatch, name: str, code: int) -> None:
    """Flexible; belts; wheels, whose kinematic coordinates leave no positions that are integrals; Euler parameters; no
    coordinate but degrees of freedom."""
    options = {"duration": 0.01 if name == "crankfl" else 0.1, "n_steps": 4, "atol": 1e-6, "rtol": 1e-6}
    source = spacar.parse_deck(FREE, "free", 1) if name == "free" else DATA / f"{name}.dat"
    in_c, in_python = both(monkeypatch, source, code, **options)
    for a, b in zip(in_c.frames, in_python.frames, strict=True):
        assert [a.statistics.get(k) for k in COUNTS] == [b.statistics.get(k) for k in COUNTS]
    for what, within in (("x", 1e-9), ("xd", 1e-7), ("e", 1e-9)):
        size = max(1.0, float(np.abs(in_python[what]).max()))
        np.testing.assert_allclose(in_c[what], in_python[what], rtol=0, atol=within * size)


def test_steps_that_do_not_converge(monkeypatch: pytest.MonkeyPatch) -> None:
    """A first step that is far too long: the iteration fails, with the same words in both; shorter steps are tried."""
    failed = []
    slow = radau.slow_newton

    def spy(*arguments: object) -> object:
        failure = slow(*arguments)  # type: ignore[arg-type]
        failed.append(str(failure))
        return failure

    monkeypatch.setattr(radau, "slow_newton", spy)
    options = {"duration": 0.05, "n_steps": 2, "step": 0.05, "atol": 1e-4, "rtol": 1e-4}
    in_c, in_python = both(monkeypatch, DATA / "crankfl.dat", 595, **options)
    half = len(failed) // 2
    assert half > 0
    assert [text[:60] for text in failed[:half]] == [text[:60] for text in failed[half:]]
    np.testing.assert_allclose(in_c["x"], in_python["x"], rtol=0, atol=1e-8)
