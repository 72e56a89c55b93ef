"""The linearized equations about rest in one call of C against NumPy and against differences of the equilibrium."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.compiled.compiled_elements import with_compiled_elements
from spacar.compiled.library import why_off
from spacar.deck import parse_deck, read_deck
from spacar.dynamics.motion_equations import Accelerations
from spacar.errors import Report
from spacar.kinematics.constraint_condition import Conditioning
from spacar.kinematics.element_sweep import ElementSweep
from spacar.linearization import linearize
from spacar.mechanism import build
from spacar.stationary import StationarySolver, load_program

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
from statics import cantilever

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
MODELS = Path(__file__).resolve().parents[2] / "data"

# prescribed coordinates and deformations, a dynamic coordinate, damping, inertia of deformations, gravity
MIXED = """PLBEAM 1 1 2 3 4
PLBEAM 2 3 4 5 6
PLTRUSS 3 1 5
PLTRUSS 4 3 7
X 3 1. 0.
X 5 2. 0.1
X 7 1. 1.
FIX 1
FIX 2
FIX 7 1
INPUTX 5 2
DYNX 3 2
INPUTE 1 1
DYNE 2 1 2
DYNE 1 3
DYNE 4 1
RLSE 2 3
RLSE 1 2
RLSE 3 1
END
HALT
EM 1 1.
XM 7 2.
ESTIFF 1 1000. 3.
ESTIFF 2 1000. 2.
ESTIFF 3 7.
ESTIFF 4 50.
EDAMP 1 0. 0.1
EDAMP 4 0.3
ESIG 3 0.3
MEE 2 1 2 1 0.2
GRAVITY 0. -0.5
INPUTX 5 2 0.15 0. 0.
INPUTE 1 1 0.01 0. 0.
XF 3 0.1 -0.2
ITERSTEP 20 4 1e-10
END
END
"""
# masses whose gravity depends on the orientation of the beams
HEAVY = """BEAM 1 1 2 3 4 0. 1. 0.
BEAM 2 3 4 5 6 0. 1. 0.
X 3 1. 0. 0.
X 5 2. 0. 0.3
FIX 1
FIX 2
DYNE 1 1 2 3 4 5 6
DYNE 2 1 2 3 4 5 6
END
HALT
EM 1 2. 0.1 0.01 0.01 0.
EM 2 2. 0.1 0.01 0.01 0.
ESTIFF 1 5e4 20. 30. 40. 0. 0.
ESTIFF 2 5e4 20. 30. 40. 0. 0.
GRAVITY 0. 0. -9.81
XF 5 3. 2. 1.
ITERSTEP 20 3 1e-10
END
END
"""
TEXTS = {"cantilever": cantilever(6), "longer": cantilever(30), "mixed": MIXED, "heavy": HEAVY}
FILES = ("lateral4", "robotsim", "plbeam5", "finger")
SUMS = ("m0", "c0", "d0", "k0", "n0", "g0", "ak0", "bk0")


def solved(m) -> StationarySolver:
    solver = StationarySolver(with_compiled_elements(m), Report())
    for _ in solver.stored(load_program(m.settings)):
        pass
    return solver


def model(name: str):
    return build(parse_deck(TEXTS[name], 7), 7) if name in TEXTS else build(read_deck(MODELS / f"{name}.dat", 7), 7)


def spread(A: np.ndarray) -> float:
    return max(float(np.abs(A).max(initial=0.0)), 1e-3)


@pytest.mark.parametrize("name", [*TEXTS, *FILES])
def test_the_linearized_equations_are_those_of_numpy(name):
    solver = solved(model(name))
    about = solver.about()
    assert about is not None
    d = solver.dynamics
    L, expected = about.linearization(), linearize(d, solver.solution.xdd, solver.solution.sigma)
    for field in (*SUMS, "W", "We", "G", "Ge", "sigma", "V", "M", "load_x", "S", "Sd", "inertia_x", "Z", "Yev"):
        value, wanted = (np.asarray(getattr(each, field)) for each in (L, expected))
        assert value.shape == wanted.shape, field
        # cond 10: digits of the transfer functions
        np.testing.assert_allclose(value, wanted, rtol=0.0, atol=1e-11 * spread(wanted), err_msg=field)
    here, there = about.condition, Conditioning.of(d.kinematics)
    assert here.at_most == pytest.approx(there.at_most, rel=1e-9)
    assert here.number == pytest.approx(there.number, rel=1e-9)


@pytest.mark.parametrize("name", [*TEXTS, *FILES])
def test_the_stored_state_is_that_of_numpy(name):
    solver = solved(model(name))
    state, d = solver.solution, solver.dynamics
    frame = solver.about().frame(1.0, state.sigma, d.loads)
    found = Accelerations(state.xdd, state.sigma, state.convective)
    expected = d.complete(1.0, found, d.forces.inertia(d.sweep, d.xd))
    for field in ("x", "xd", "xdd", "e", "ed", "edd", "sig", "fx", "fxgrav", "fxtot"):
        value, wanted = getattr(frame, field), getattr(expected, field)
        # e within some eps of the lengths; forces are sums of a few terms of the size of the largest stress
        size = max(spread(wanted), spread(frame.sig) if field.startswith("fx") else 1.0)
        np.testing.assert_allclose(value, wanted, rtol=0.0, atol=1e-13 * size, err_msg=field)
    given = slice(0, d.numbering.e_class["input"].stop)
    assert (frame.e[given] == expected.e[given]).all()


# nothing is said of these: no step is cut, no element is near the end of its range, no inertia is doubtful
@pytest.mark.parametrize(("name", "mode"), [("heavy", 7), ("heavy", 8), ("mixed", 8)])
def test_an_ordinary_run_evaluates_no_elements_in_numpy(name, mode, monkeypatch, tmp_path):
    """They cost a tenth of the run of a small model."""
    path, made = tmp_path / "model.dat", []
    path.write_text(TEXTS[name].replace("-9.81", "-4."))  # bends less than 22 degrees
    evaluate = ElementSweep.strain
    monkeypatch.setattr(ElementSweep, "strain", lambda *its: made.append(1) or evaluate(*its))
    spacar.run(mode, path)
    assert not made


@pytest.mark.parametrize("name", ["cantilever", "heavy"])
def test_the_tangent_is_the_difference_quotient_of_the_equilibrium(name):
    """K0 + N0 + G0 = d(W^T force)/dq along the constraints: a small extra load moves the degrees of freedom by its
    inverse."""
    text = TEXTS[name]
    node = {"cantilever": 13, "heavy": 5}[name]
    solver = solved(model(name))
    L, n = solver.about().linearization(), solver.mechanism.numbering
    load = next(line for line in text.splitlines() if line.startswith(f"XF {node}"))
    step, row, moved = 1e-5, n.x_index(node, 1), []
    for sign in (1.0, -1.0):
        words = load.split()
        words[2] = repr(float(words[2]) + sign * step)
        other = solved(build(parse_deck(text.replace(load, " ".join(words)), 7), 7))
        moved.append(other.dynamics.kinematics.x.copy())
    slope = (moved[0] - moved[1]) / (2.0 * step)
    predicted = L.W @ np.linalg.solve(L.stiffness, L.W[row])
    np.testing.assert_allclose(predicted, slope, rtol=0.0, atol=1e-6 * spread(slope))


def test_large_models_are_left_to_numpy():
    assert solved(build(parse_deck(cantilever(50), 7), 7)).about() is None  # 153 coordinates
    assert solved(build(parse_deck(cantilever(48), 7), 7)).about() is not None


def test_where_the_degrees_of_freedom_do_not_determine_the_configuration_numpy_says_so():
    text = """PLTRUSS 1 1 2
PLTRUSS 2 2 3
X 2 0. 1.
X 3 1. 1.
FIX 1
FIX 3
DYNX 2 2
RLSE 2 1
END
HALT
XM 2 1.
ESTIFF 2 10.
ITERSTEP 20 1 1e-10
END
END
"""
    assert solved(build(parse_deck(text, 7), 7)).about() is None
