"""Mechanisms that fly: a common translation is no jump between configurations, however far a step goes.

Truth: Galilei. Seen from a frame that goes along, the motion is that of the same mechanism without the drift.
"""

import numpy as np
import pytest

import spacar
from spacar.compiled.compiled_evaluator import CompiledDynamics
from spacar.kinematics.kinematics import Kinematics

MASSES = """PLTRUSS 1 1 2   X 2 1 0   DYNX 1   DYNX 2   RLSE 1 1   END HALT
XM 1 2   XM 2 1   ESTIFF 1 50
STARTDX 1 1 0 {0}   STARTDX 1 2 0 {1}   STARTDX 2 1 1 {0}   STARTDX 2 2 0 {2}   TIMESTEP 3 10
ERROR 1e-9 1e-9   END END
"""
# a rod turns beside them about a fixed point
RODS = """PLRBEAM 1 1 2 3   PLRBEAM 2 3 4 5   PLRBEAM 3 6 7 8   X 3 1 0   X 5 2 0   X 6 0 5   X 8 1 5
FIX 6   INPUTX 7   DYNX 1   DYNX 2   DYNX 4   END HALT   EM 1 1   EM 2 1
STARTDX 1 1 0 {0}   STARTDX 1 2 0 {1}   STARTDX 2 1 0 1   STARTDX 4 1 0 {2}   INPUTX 7 1 0 3
TIMESTEP 5 10   ERROR 1e-9 1e-9   END END
"""


def flown(model: str, drift: float, compiled: bool) -> spacar.Result:
    text = model.format(drift, 0.7 * drift - 1.0, (0.7 * drift if model is MASSES else 0.0) + 2.0)
    return spacar.run(1, spacar.parse_deck(text, "flight", 1), compiled=compiled)


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize(("model", "nodes"), [(MASSES, (1, 2)), (RODS, (1, 3, 5))])
def test_common_translation_is_no_jump(
    model: str, nodes: tuple[int, ...], compiled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    at_rest = flown(model, 0.0, compiled)
    calls: list[str] = []
    kept = CompiledDynamics._in_general, Kinematics._approach
    monkeypatch.setattr(CompiledDynamics, "_in_general", lambda *a: (calls.append("general"), kept[0](*a))[1])
    monkeypatch.setattr(Kinematics, "_approach", lambda *a: (calls.append("pieces"), kept[1](*a))[1])
    flight = flown(model, 1e3, compiled)
    for node in nodes:
        for k, drift in ((1, 1e3), (2, 0.7e3)):
            moved = flight.node(node, k) - drift * flight.t
            # ERROR 1e-9 in parts of the positions, 2e4 m, and its accumulation over some thousand steps
            assert np.abs(moved - at_rest.node(node, k)).max() < 2e-4
    assert len(calls) <= len(flight.t)
