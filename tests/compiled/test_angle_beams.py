"""Beams in the angle measure: the compiled functions give the motion of the general evaluator."""

from __future__ import annotations

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.compiled.numbers import without_form
from spacar.elements.spatial.angle_measure import rotation_factor
from spacar.mechanism import build


def arm(spatial: bool) -> Deck:
    """Two clamped beams with large deflections and rates at the start, and all stiffnesses that a beam can have."""
    rows: list[tuple] = [("FIX", 1)]
    dynamics: list[tuple] = [("TIMESTEP", 0.001, 1), ("ERROR", 1e-8, 1e-8)]
    for k in (1, 2):
        p = 2 * k - 1
        if spatial:
            more, stiffness = (0.0, 1.0, 0.2, 0.01), (400.0, 0.3, 1.0, 2.0, 0.001, 0.002)
            rows += [
                ("BEAM", k, p, p + 1, p + 2, p + 3, *more),
                ("DYNE", k, *range(1, 7)),
                ("X", p + 2, 0.5 * k, 0.1 * k, 0.0),
            ]
            dynamics += [("ESTIFF", k, *stiffness), ("EM", k, 1.0, 0.01, 0.01, 0.01)]
        else:
            rows += [("PLBEAM", k, p, p + 1, p + 2, p + 3), ("DYNE", k, 1, 2, 3), ("X", p + 2, 0.5 * k, 0.1 * k)]
            dynamics += [("ESTIFF", k, 400.0, 1.0, 0.001), ("EM", k, 1.0, 0.01)]
    modes = range(2, 7) if spatial else (2, 3)
    dynamics += [("STARTDE", k, m, 0.04 * (m - 3.4) * k, 0.3 * (4.6 - m)) for k in (1, 2) for m in modes]
    force = (50.0, -600.0, 400.0) if spatial else (50.0, -600.0)
    rows += [("FIX", 2), ("ADEFORM",)]
    return Deck.build(rows, [*dynamics, ("XF", 5, *force)])


@pytest.mark.parametrize("spatial", [False, True])
def test_both_engines_compute_the_same_motion(spatial):
    deck = arm(spatial)
    assert without_form(build(deck, 1)) == []
    compiled, general = (spacar.run(1, deck, compiled=c) for c in (True, False))
    assert not any("not compiled" in line for line in compiled.report)
    for name in ("x", "xd", "xdd", "e", "sig"):
        a, b = (np.array([getattr(f, name) for f in r.frames]) for r in (compiled, general))
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-6 * max(1.0, np.abs(b).max()), err_msg=name)
    assert np.abs(general.frames[-1].e).max() > 0.02


def test_rotation_factor_in_c_far_from_one():
    """A beam twisted by 2.2 rad: the closed form of G in C."""
    rows = [("BEAM", 1, 1, 2, 3, 4, 0.0, 1.0, 0.0), ("X", 3, 1.0, 0.0, 0.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1, 2)]
    dynamics = [("ESTIFF", 1, 0.0, 2.0), ("EM", 1, 1.0, 0.5), ("STARTDE", 1, 2, 2.2, 0.0), ("TIMESTEP", 0.5, 2)]
    deck = Deck.build([*rows, ("ADEFORM",)], [*dynamics, ("ERROR", 1e-11, 1e-11)])
    result = spacar.run(1, deck, compiled=True)
    phi = 2 * np.arctan2(result.node(4, 2), result.node(4, 1))
    omega = np.sqrt(2.0 / 0.25)  # GIt/l0 over the half of the inertia that is at the end
    np.testing.assert_allclose(phi, 2.2 * np.cos(omega * np.array([0.0, 0.25, 0.5])), atol=1e-8)
    assert rotation_factor(np.array([np.cos(1.1)]))[0, 0] == pytest.approx(2.2 / np.sin(1.1))
