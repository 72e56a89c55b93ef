"""A spatial mechanism in the x-y plane and its planar model: the same motion, and `trade` that finds it."""

import numpy as np
import pytest

import spacar
from spacar.deck.rewrite.in_plane import planar
from spacar.errors import UsageError

CHAIN = """
BEAM 1 1 2 3 4 {y}
BEAM 2 3 4 5 6 {y}
HINGE 3 6 7 0 0 {axis}
RBEAM 4 5 7 8
X 3 1. 0.2 0.
X 5 1.7 0.6 0.
X 8 2.2 0.1 0.
FIX 1
FIX 2
DYNE 1 {modes}
DYNE 2 {modes}
DYNE 3 1
{more}
END HALT
EM 1 1. 0. {inertia}
EM 2 1. 0. {inertia}
EM 4 2. 0.1 {inertia}
ESTIFF 1 1e4 10. {stiffness}
ESTIFF 2 1e4 10. {stiffness}
EDAMP 1 1. 0.1 {damping}
ESTIFF 3 3.
XM 8 1.
XM 7 0 0 0 0 0 0.3
XF 8 1. -2. 0.
XF 6 0. 0. 0.7
ESIG 1 3. {preload}
ESIG 3 0.2
GRAVITY 0 -9.81 0
STARTDE 1 {start} 0.05 1.
STARTDE 3 1 0.1 1.
STARTDE 1 {modes_last} 0. 0.
{load}
TIMESTEP 0.4 20
END END
"""
NORMAL_Y = {"modes": "1 3 4", "stiffness": "20. 1e3 0.02 0.", "damping": "0.2 0.", "inertia": "0.01 0.05",
            "preload": "0. 2. 1.", "start": 3, "modes_last": 4}  # fmt: skip
NORMAL_Z = {"modes": "1 5 6", "stiffness": "1e3 20. 0. 0.02", "damping": "0. 0.2", "inertia": "0.05 0.01",
            "preload": "0. 0. 0. 2. 1.", "start": 5, "modes_last": 6}  # fmt: skip


def chain(y="", axis="1", more="", load="", **facts):
    return spacar.parse_deck(CHAIN.format(y=y, axis=axis, more=more, load=load, **facts), mode=1)


@pytest.mark.parametrize("axis", ["1", "-2"])
@pytest.mark.parametrize(
    ("y", "facts"), [("", NORMAL_Y), ("0 0 -1", NORMAL_Y), ("0 1 0", NORMAL_Z), ("0.3 -1 0", NORMAL_Z)]
)
def test_the_planar_model_moves_as_the_spatial_one(y, facts, axis):
    """Every sign counts: preloads, start values, moments and damping of both signs of the normal. Rotary inertia of the
    sine measure is the same in plane and space; tolerances of the integration times the largest motion, 1 m."""
    given = chain(y, axis, **facts)
    runs = [spacar.run(1, deck, rtol=1e-10, atol=1e-11, beams="sine") for deck in (given, planar(given))]
    for node in (3, 5, 8):
        one, other = (run.node(node)[:, :2] for run in runs)
        assert np.ptp(one, axis=0).max() > 0.01
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"more": "HINGE 5 4 9 0 1 1"}, "HINGE 5"),
        ({"more": "X 9 0. 0. 1.\nTRUSS 5 5 9"}, "plane z = constant"),
        ({"load": "XF 3 0. 0. 1."}, "XF 3"),
        ({"modes": "1 2 3 4", "load": "STARTDE 2 2 0. 1."}, "STARTDE 2"),
        ({"load": "DELXF 6 1. 0. 0."}, "DELXF 6"),
        ({"y": "0 1 1"}, "BEAM 1"),
    ],
)
def test_motion_out_of_the_plane_has_no_planar_model(change, named):
    with pytest.raises(UsageError, match=named):
        planar(chain(**NORMAL_Y | change))


SLIDER_CRANK = """
HINGE 1 1 2 0 0 1
BEAM 2 3 2 4 5
HINGE 3 5 6 0 0 1
BEAM 4 4 6 7 8
X 4 0.15 0. 0.
X 7 0.45 0. 0.
FIX 1
FIX 3
FIX 7 2
RLSE 3 1
INPUTE 1 1
DYNE 4 3 4
END HALT
EM 2 0.2225
EM 4 0.2225
XM 7 0.033375
ESTIFF 4 1e5 10. 12.72 12.72
EDAMP 4 0 0 0.01272 0
INPUTE 1 1 0. 150.
TIMESTEP 0.1 100
END END
"""


@pytest.mark.parametrize(
    ("variables", "target", "found"), [(("x[7,1]", "x[4,2]"), 1e-3, True), (("x[7,1]", "e[4,3]"), 5e-2, False)]
)
def test_trade_prefers_planar_elements_where_they_have_what_is_asked(variables, target, found):
    """What names a deformation of a spatial beam has no like in the plane."""
    answer = spacar.trade(spacar.parse_deck(SLIDER_CRANK, mode=1), target=target, variables=list(variables))
    assert ("planar" in answer.deck.source) is found
    if found:
        exact = spacar.run(1, spacar.parse_deck(SLIDER_CRANK, mode=1), rtol=1e-9, atol=1e-10)
        simple = spacar.run(1, answer.deck, **answer.options)
        for node, c in ((7, 1), (4, 2)):
            want = exact.node(node, c)
            assert np.abs(simple.node(node, c) - want).max() <= target * np.ptp(want)
