"""Batches of cases are driven as single runs are: same tolerances of a case, same counters."""

from dataclasses import replace

import numpy as np
import pytest

import spacar
from spacar.compiled.library import why_off
from spacar.forward.driver import ITERATED, POSITION, Tolerances
from spacar.kinematics.kinematics import CONVERGED
from spacar.mechanism import build
from tests.ensembles import ensemble
from tests.examples import DATA

ROBOT = DATA / "robotsim.dat"


@pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
def test_a_batch_of_one_is_a_single_run():
    """The steps are the same ones, so the results agree to the rounding of a step (1e-12 of the size, 1e3 eps)."""
    options = {"duration": 0.05, "n_steps": 3, "integrator": 155}
    single = spacar.run(1, ROBOT, **options)
    (case,) = ensemble([spacar.read_deck(ROBOT, 1)], **options)
    counters = [{k: v for k, v in f.statistics.items() if k != "rhs"} for f in case.frames]
    assert counters == [{k: v for k, v in f.statistics.items() if k != "rhs"} for f in single.frames]
    np.testing.assert_allclose(case["x"], single["x"], rtol=0, atol=1e-12 * np.abs(single["x"]).max())


def test_positions_are_as_exact_as_the_method_needs_them():
    settings = replace(build(spacar.read_deck(ROBOT, 1), 1).settings, atol=1e-6, rtol=1e-3)
    of = {code: Tolerances.of(replace(settings, integrator=code)) for code in (140, 155, 430)}
    assert of[140].position == CONVERGED  # fixed steps: no error estimate that could be disturbed
    assert of[155].position == POSITION * min(of[155].atol, of[155].rtol)
    assert of[430].position == ITERATED
