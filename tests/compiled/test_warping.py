"""BEAMW in C against the general path; bounds as in test_compiled."""

from __future__ import annotations

import numpy as np
import pytest

from spacar.compiled import CompiledDynamics
from spacar.compiled.library import unavailable
from spacar.compiled.numbers import without_form
from spacar.deck import Deck
from spacar.dynamics import Dynamics
from spacar.mechanism import build

pytestmark = pytest.mark.skipif(unavailable() is not None, reason=str(unavailable()))

KINEMATICS = [
    ("BEAMW", 1, 1, 2, 3, 4, 5, 6, 0.0, 1.0, 0.2, 0.01), ("BEAMW", 2, 4, 5, 6, 7, 8, 9, 0.0, 1.0, 0.2),
    ("X", 4, 1.0, 0.1, 0.0), ("X", 7, 2.0, 0.0, 0.3), ("DYNE", 1), ("DYNE", 2), ("LDEFORM", 2),
    ("FIX", 1), ("FIX", 2), ("FIX", 3),
]  # fmt: skip
DYNAMICS = [
    *(("ESTIFF", k, 1e4, 20.0, 30.0, 40.0, 0.01, 0.02, 5.0) for k in (1, 2)),
    *(("EDAMP", k, 1.0, 0.2, 0.3, 0.4, 0.0, 0.0, 0.05) for k in (1, 2)),
    *(("EM", k, 1.0, 0.02, 0.01, 0.01, 0.0, 0.03) for k in (1, 2)),
    ("GRAVITY", 0.0, 0.0, -9.81), ("XM", 9, 0.1), ("XF", 9, 2.0), ("XF", 7, 0.0, 1.0, 2.0),
]  # fmt: skip


@pytest.mark.parametrize("measure", ["sine", "angle"])
def test_frames_equal_those_of_the_general_path(measure):
    mechanism = build(Deck.build(KINEMATICS, DYNAMICS, mode=1), 1, beams=measure)
    assert without_form(mechanism) == []
    general, compiled = Dynamics(mechanism), CompiledDynamics(mechanism)
    y, rng = general.start(), np.random.default_rng(4)
    n = general.n_positions
    assert n == 14
    for _ in range(5):
        state = y + np.r_[1e-2 * rng.standard_normal(n), rng.standard_normal(len(y) - n)]
        a, b = general.frame(0.0, state), compiled.frame(0.0, state)
        for variable in ("x", "xd", "xdd", "e", "ed", "edd", "sig", "fx", "fxgrav", "fxtot"):
            want = getattr(a, variable)
            np.testing.assert_allclose(getattr(b, variable), want, atol=1e-8 * np.abs(want).max(), rtol=0)
        expected = general.rhs(0.0, state)
        np.testing.assert_allclose(compiled.rhs(0.0, state), expected, atol=1e-8 * np.abs(expected).max())
