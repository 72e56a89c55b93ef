"""Stationary solutions: elastica, load steps of all types, cutting, failures, sparse against dense."""

import numpy as np
import pytest
from spacar_formats.loadsbd import loadsbd, loadsbm
from statics import cantilever, elastica, solve

import spacar
from spacar.deck import parse_deck
from spacar.errors import AnalysisError
from spacar.stationary import continuation

from .walk import levels, walked


def test_strongly_bent_cantilever_converges_with_second_order():
    """The tip of the elastica at a load of 10 EI/l^2; the element has order 2 for finite rotations of the chord."""
    exact = np.array(elastica())[:2]
    errors = [np.linalg.norm(solve(n)[2][:2] - exact) for n in (10, 20, 40)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 2.0) < 0.1)
    assert errors[-1] < 3e-4


def test_prediction_saves_iterations(monkeypatch):
    def iterations() -> int:
        return sum(solver.iterations for solver, _ in levels(cantilever(10, 3.0, steps=10)))

    predicted = iterations()
    monkeypatch.setattr(continuation, "REMEMBERED", 1)
    assert predicted < 0.8 * iterations()


def test_load_steps_are_cut_when_newton_fails():
    """One step to 100 EI/l^2 cannot converge; cut, it arrives at the same state as many small steps."""
    result = spacar.run(8, parse_deck(cantilever(10, 100.0, steps=1).replace("ITERSTEP 20", "ITERSTEP 10"), mode=8))
    assert any("cut to 0.5" in line for line in result.report)
    slow = spacar.run(8, parse_deck(cantilever(10, 100.0, steps=100), mode=8))
    assert np.allclose(result["x"], slow["x"], rtol=0, atol=1e-9)


# One beam from (0,0) to (1,0), clamped, and a spring hinge: every kind of load acts on it.
LOADED = """
PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   PLTOR 3 2 7   PLTRUSS 4 5 8
X 3 0.5 0.   X 5 1. 0.   X 8 1.5 0.4
FIX 1   FIX 7   INPUTE 3 1   INPUTX 8 1   FIX 8 2   DYNE 1 2 3   DYNE 2 2 3   RLSE 4   END HALT
EM 1 1.   EM 2 1.   XM 5 0.3   ESTIFF 1 0. 1.   ESTIFF 2 0. 1.   ESTIFF 4 2.   {loads}   {settings}
END END
"""
INITIAL = "XF 5 0.2 0.1\nGRAVITY 0. -0.4\nESIG 1 0. 0.1 0.05\nINPUTX 8 1 1.6\nINPUTE 3 1 0.1"
DELTAS = "DELXF 5 0.3 -0.2\nDELGRAV 0.1 0.3\nDELESIG 1 0. -0.05 0.1\nDELINPX 8 1 0.2\nDELINPE 3 1 -0.3"
SUM = "XF 5 0.5 -0.1\nGRAVITY 0.1 -0.1\nESIG 1 0. 0.05 0.15\nINPUTX 8 1 1.8\nINPUTE 3 1 -0.2"


def loaded(loads: str, settings: str, mode: int = 7) -> spacar.Result:
    return spacar.run(mode, parse_deck(LOADED.format(loads=loads, settings=settings), mode=mode))


@pytest.mark.parametrize("kind", [2, 3])
def test_initial_and_additional_loading(kind):
    """All DEL... keywords: the end is the equilibrium under the sum; step 1 that of the initial loading alone."""
    steps = loaded(f"{INITIAL}\n{DELTAS}", f"ITERSTEP 20 6 1e-12 1 {kind} 3")
    assert len(steps.frames) == 7
    assert np.allclose(steps.t, np.arange(7))
    first, last = loaded(INITIAL, "ITERSTEP 20 3 1e-12"), loaded(SUM, "ITERSTEP 20 3 1e-12")
    for name in ("x", "e", "sig", "fxtot"):
        assert np.allclose(steps[name][0], first[name][0], rtol=0, atol=1e-10)
        assert np.allclose(steps[name][-1], last[name][0], rtol=0, atol=1e-10)


@pytest.mark.parametrize(("every", "stored"), [(1, 8), (2, 5), (3, 4), (100, 2)])
def test_stored_steps(every, stored):
    """The initial solution, every `every`-th step and the last."""
    assert len(loaded(f"{INITIAL}\n{DELTAS}", f"ITERSTEP 20 7 1e-10 {every} 2").frames) == stored


@pytest.mark.parametrize("kind", [0, 1])
def test_types_without_additional_loading(kind):
    result = loaded(f"{INITIAL}\n{DELTAS}", f"ITERSTEP 30 3 1e-12 1 {kind}")
    assert len(result.frames) == 1
    assert np.allclose(result["x"], loaded(INITIAL, "ITERSTEP 20 5 1e-12")["x"], rtol=0, atol=1e-10)


def test_three_number_moment_increment():
    """DELXF with three numbers on a spatial orientation node is a global moment, with or without XF on the node."""
    text = """
BEAM 1 1 2 3 4 0. 1. 0.   X 3 1. 0. 0.   FIX 1   FIX 2   DYNE 1 2 3 4 5 6   END HALT
ESTIFF 1 0. 2. 1. 1.   EM 1 1. 0.1   {}   END END
"""

    def x(loads: str) -> np.ndarray:
        return spacar.run(7, parse_deck(text.format(loads), mode=7))["x"][-1]

    total = x("XF 4 0.3 0.2 -0.1\nITERSTEP 20 4 1e-12")
    assert np.allclose(x("DELXF 4 0.3 0.2 -0.1\nITERSTEP 20 4 1e-12 1 2"), total, rtol=0, atol=1e-11)
    parts = "XF 4 0.1 0.1 0.2\nDELXF 4 0.2 0.1 -0.3\nITERSTEP 20 4 1e-12 1 2"
    assert np.allclose(x(parts), total, rtol=0, atol=1e-11)


@pytest.mark.parametrize("beams", ["sine", "angle"])
@pytest.mark.parametrize(
    ("tube", "y", "modes", "law"), [("PLTUBE", "", "2 3", "0. 1."), ("TUBE", "0. 1. 0.", "5 6", "0. 1. 1. 1.")]
)
def test_flow_in_a_tube(tube, y, modes, law, beams):
    """DELOMF: the end is the state under the total mass flow, with a jet at the free end."""

    def run(flow: str, more: str) -> np.ndarray:
        text = f"""
{tube} 1 1 2 3 4 {y}   {tube} 2 3 4 5 6 {y}   X 3 0.5 0.   X 5 1. 0.
FIX 1   FIX 2   DYNE 1 {modes}   DYNE 2 {modes}   END HALT
EM 1 1. 0.5 {flow}   EM 2 1. 0.5 {flow} 1. 2   ESTIFF 1 {law}   ESTIFF 2 {law}   XF 5 0. 0.3
{more}   END END
"""
        return spacar.run(7, parse_deck(text, mode=7), beams=beams)["x"][-1]

    total = run("0.9", "ITERSTEP 20 4 1e-12")
    assert np.allclose(run("0.3", "DELOMF 1 0.6\nDELOMF 2 0.6\nITERSTEP 20 4 1e-12 1 2"), total, rtol=0, atol=1e-10)
    assert not np.allclose(run("0.", "ITERSTEP 20 4 1e-12"), total, rtol=0, atol=1e-4)


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("steps", [1, 2, 7])
@pytest.mark.parametrize(("offset", "pulled"), [(1e-4, 0.001), (1e-4, 0.5), (0.02, 0.05), (0.2, 0.5)])
def test_a_slack_chain_that_is_pulled_tight(offset, pulled, steps, compiled):
    """A rigid and an elastic bar, straight from where their lengths are used up: N = EA/l (distance - 2 l). Its slack
    path ends there, in a fork whose other branch has no stiffness before."""
    length = (1.0 + offset**2) ** 0.5
    text = chain(offset, pulled, steps)
    force = spacar.run(8, parse_deck(text, mode=8), compiled=compiled).element(2, variable="sig")[-1]
    assert force == pytest.approx(40.0 / length * (2.0 + pulled - 2.0 * length), rel=1e-9)


def test_a_dead_point_on_the_way(tmp_path):
    """The tight chain is at a dead point of its elongation: matrices of these load steps are nan in the result file."""
    text = chain(0.2, 0.0, 1).replace("ITERSTEP 60 1 1e-12", "DELINPX 3 1 0.05\nITERSTEP 60 1 1e-12 1 3")
    text = text.replace("DYNE 2 1", "DYNE 2 1\nOUTLEVEL 15 3")
    result = spacar.run(10, parse_deck(text, mode=10))
    result.save(tmp_path / "chain")
    sbd, sbm = loadsbd(tmp_path / "chain"), loadsbm(tmp_path / "chain")
    for values in (result["k0"], sbm["k0"], sbd["dx"][:, :1], sbd["d2x"][:, :1]):
        assert np.isnan(values).ravel().tolist() == [False, True]
    assert np.isfinite(result["eigval"]).all()


def chain(offset: float, pulled: float, steps: int) -> str:
    return f"""
PLTRUSS 1 1 2   PLTRUSS 2 2 3   X 2 1. {offset}   X 3 2. 0.
FIX 1   FIX 3 2   INPUTX 3 1   DYNE 2 1   END HALT
ESTIFF 2 40.   XM 2 1.   INPUTX 3 1 {2.0 + pulled}   ITERSTEP 60 {steps} 1e-12   END END
"""


def test_singular_stiffness():
    """A free-free beam without load rests; a load on its rigid motion has no stationary solution."""
    free = cantilever(4, 0.0).replace("FIX 1\nFIX 2\n", "DYNX 1\nDYNX 2\n")
    still = spacar.run(7, parse_deck(free.replace("ESTIFF 1", "EM 1 1.\nEM 2 1.\nEM 3 1.\nEM 4 1.\nESTIFF 1"), mode=7))
    assert np.count_nonzero(np.hypot(*still["eigval"][0].T) < 1e-5) == 6  # three rigid motions, in pairs
    with pytest.raises(AnalysisError, match="motion without stiffness, mainly node 9 y"):
        spacar.run(7, parse_deck(free.replace("XF 9 0. 0.0", "XF 9 0. 1.0"), mode=7))


def test_no_dynamic_degrees_of_freedom():
    text = "PLTRUSS 1 1 2\nPLTRUSS 2 2 3\nX 1 0. 0.\nX 2 1. 1.\nX 3 2. 0.\nFIX 1\nFIX 3\n"
    text += "END\nHALT\nXF 2 0. -1.\nEND\nEND\n"
    result = spacar.run(10, parse_deck(text, mode=10))
    assert np.allclose(result.frames[0].sig, -np.sqrt(0.5))
    assert sum("no dynamic degrees of freedom" in line for line in result.report) == 2
    assert np.array_equal(result["xcompl"][0], np.zeros(6))


def test_levels_on_the_way_are_cheap():
    """Four steps to 10 EI/l^2 with turns of more than 0.8 rad took 127 evaluations when the position was first tried
    in one go, and when every level was solved to the tolerance; the result keeps the tolerance of ITERSTEP."""
    solver, exact = (walked(cantilever(10, steps=steps)) for steps in (4, 40))
    assert solver.dynamics.sweep.count <= 80
    assert np.allclose(solver.y, exact.y, rtol=0, atol=1e-10)


def test_a_loading_that_does_nothing_is_solved_once():
    """Without loads all levels have the solution of the first."""
    one, ten = (walked(cantilever(4, 0.0, steps)) for steps in (1, 10))
    assert not one.y.any()
    assert not ten.y.any()
    assert ten.dynamics.sweep.count <= one.dynamics.sweep.count + 1
