"""The start of a motion in C: the first look at the mass matrix, and the bound of the condition before it."""

import numpy as np
import pytest

from spacar.compiled import CompiledDynamics
from spacar.compiled.compiled_model import DOUBTFUL_MASS
from spacar.compiled.library import why_off
from spacar.deck import parse_deck, read_deck
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.mass_check import dynamic_mass, is_doubtful, largest_mass
from spacar.kinematics.kinematics import CONVERGED
from spacar.mechanism import build
from spacar.mechanism.mechanism import Mechanism
from tests.examples import DATA

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))

PENDULUM = """
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
    mechanism = build(parse_deck(PENDULUM.format(mass=mass), mode=1), 1)
    in_c, in_numpy = looked_at(mechanism)
    assert in_c == in_numpy
    assert in_c == (mass < 1.5e-8)  # sqrt(eps) of the largest mass


@pytest.mark.parametrize("name", ["slider", "crank", "crankfl", "fourbar", "cardan", "robotsim", "plbeam5", "trike3v"])
def test_the_bound_of_the_condition_is_one(name: str) -> None:
    """From below for the reciprocal condition, and not far from it: by a factor of 100 in these models."""
    compiled = CompiledDynamics(build(read_deck(DATA / f"{name}.dat", 1), 1))
    compiled.start()
    exact, bound = compiled.solver.rcond(), compiled.solver.rcond(0.0)
    assert 0.01 * exact < bound <= exact * (1.0 + 1e-12)
    assert compiled.position_matrix().rcond() == exact
    assert compiled.solver.rcond(np.inf, 0) == 0.0  # not asked for with so many unknowns
    assert compiled.position_matrix().surely_regular()


def test_the_condition_is_that_of_numpy() -> None:
    mechanism = build(read_deck(DATA / "robotsim.dat", 1), 1)
    compiled, general = CompiledDynamics(mechanism), Dynamics(mechanism)
    compiled.start()
    general.start()
    assert compiled.condition() == pytest.approx(general.condition(), rel=1e-12)
