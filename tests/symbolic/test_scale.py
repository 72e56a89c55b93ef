"""What must be derived in seconds: chains of rigid links by the held strategy, against the recursive one."""

import numpy as np
import pytest

pytest.importorskip("sympy")

from spacar.symbolic import MultibodySystem


def chain(n: int) -> MultibodySystem:
    S = MultibodySystem(gravity=("0", "-g", "0"))
    frame, end = S.N, S.O
    for i in range(1, n + 1):
        q, _ = S.coordinate(f"q{i}", speed=f"s{i}")
        frame = S.frame(f"B{i}", frame, 3, q, f"b{i}x")
        middle = S.point(f"C{i}", end, S.expression("L/2") * frame[1])
        S.rigid_body(f"body{i}", frame, middle, "m", (0, 0, "J"))
        end = S.point(f"P{i}", end, S.expression("L") * frame[1])
    return S


@pytest.mark.parametrize("links", [4, pytest.param(8, marks=pytest.mark.slow)])
def test_rigid_links_held(links):
    """Both strategies give one acceleration; tolerance: 8 eps cond(M) with cond below 1e4 for eight equal links."""
    values = {"L": 0.4, "m": 1.3, "J": 0.05, "g": 9.81}
    chance = np.random.default_rng(8)
    y = chance.uniform(-0.5, 0.5, 2 * links).tolist()
    a, b = (np.array(chain(links).derive(kind).program().function(values)(0.0, y)) for kind in ("held", "recursive"))
    assert np.max(abs(a - b)) < 8 * np.finfo(float).eps * 1e4 * np.max(abs(b))
