"""Spatial paths and extra loads in modes 2 and 3, on the manipulator of the manual (bibliography.md)."""

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from tests.examples import DATA

LEGS = """TRAJECT 1
TRCIRL 8 0 0 0  0 0.3 0.45
TRFRONT 8 1
TRTIME 1 20
TRAJECT 2
TRANS 8 0.1 0.4 0.1
TRM 8 5.
TRF 8 10. 0 0
TRTIME 0.5 10
"""


@pytest.fixture(scope="module")
def circled():
    text = (DATA / "robotinv.dat").read_text()
    before, after = text[: text.index("TRAJECT 1")], text[text.index("NOMS 1") :]
    return spacar.run(2, parse_deck(before + LEGS + after, "circle.dat", 2))


def test_circle_in_space(circled):
    """The path starts at (0.536, 0, 0), stays on the sphere and ends on the ray to (0, 0.3, 0.45)."""
    tip = np.column_stack([circled.node(8, i) for i in (1, 2, 3)])
    radius = np.linalg.norm(tip[:21], axis=1)
    assert radius == pytest.approx(0.536, abs=1e-12)
    end = np.array([0.0, 0.3, 0.45])
    assert tip[20] == pytest.approx(0.536 * end / np.linalg.norm(end), abs=1e-12)
    normal = np.cross([1.0, 0.0, 0.0], end)
    assert tip[:21] @ normal == pytest.approx(0.0, abs=1e-12)


def test_power_of_the_motors_is_the_change_of_energy(circled):
    """Work of u0 by the trapezoidal rule against kinetic plus potential energy at rest at both ends of the first
    leg.
    """
    u0, ed, t = (
        circled["u0"][:21],
        np.column_stack([circled.element(i, 1, "ed") for i in (1, 2, 3)])[:21],
        circled.t[:21],
    )
    power = (u0 * ed).sum(axis=1)
    work = float(np.sum(0.5 * (power[1:] + power[:-1]) * np.diff(t)))
    # weights 121 N at node 5 and 307 N at node 8 (14 N at the fixed node 4 do no work)
    rise = [circled.node(5, 3)[20] - circled.node(5, 3)[0], circled.node(8, 3)[20] - circled.node(8, 3)[0]]
    # 20 intervals over a smooth power (zero at both ends): relative error below 1 %
    assert work == pytest.approx(121.0 * rise[0] + 307.0 * rise[1], rel=1e-2)


def test_extra_loads_in_mode_3(circled):
    """With the trajectories in the mode 3 file the inputs agree, without them the log says by how much they do not."""
    text = (DATA / "robotinvlin.dat").read_text()
    without = spacar.run(3, parse_deck(text, "lin.dat", 3), nominal=circled)
    assert any("nominal inputs differ" in line and "TRM" in line for line in without.report)
    place = text.index("NOMS 1")
    deck = parse_deck(text[:place] + LEGS + text[place:], "lin.dat", 3)
    with_loads = spacar.run(3, deck, nominal=circled)
    assert with_loads["u0"] == pytest.approx(circled["u0"], abs=1e-7)
    assert not any("nominal inputs differ" in line for line in with_loads.report)


def test_turn_of_a_body_about_a_fixed_axis():
    """Orientation against SciPy's rotations; power of the motors against Euler's equation."""
    from scipy.spatial.transform import Rotation

    text = """HINGE 1 1 2 0 0 1   HINGE 2 2 3 0 1 0   HINGE 3 3 4 1 0 0
FIX 1   INPUTX 4 2 3 4   RLSE 1 1   RLSE 2 1   RLSE 3 1   END HALT
XM 4 1. 0. 0. 2. 0. 3.   END HALT
TRAJECT 1   TROT 4 0.8 0.3 0.5 1.   TRTIME 1 10   NOMS 1 1 1   NOMS 2 2 1   NOMS 3 3 1   END END
"""
    result = spacar.run(2, parse_deck(text, "body.dat", 2))
    axis = np.array([0.3, 0.5, 1.0]) / np.linalg.norm([0.3, 0.5, 1.0])
    for k, t in enumerate(result.t):
        early = t < 0.5 - 1e-12
        angle = 1.6 * t * t if early else 0.8 - 1.6 * (1 - t) ** 2
        rate, acceleration = (3.2 * t, 3.2) if early else (3.2 * (1 - t), -3.2)
        lam = np.array([result.node(4, i)[k] for i in (1, 2, 3, 4)])
        R = Rotation.from_quat([*lam[1:], lam[0]]).as_matrix()
        assert pytest.approx(Rotation.from_rotvec(angle * axis).as_matrix(), abs=1e-11) == R
        J, w = R @ np.diag([1.0, 2.0, 3.0]) @ R.T, rate * axis
        moment = J @ (acceleration * axis) + np.cross(w, J @ w)
        power = sum(result["u0"][k, i] * result.element(i + 1, 1, "ed")[k] for i in range(3))
        assert power == pytest.approx(moment @ w, abs=1e-10)
