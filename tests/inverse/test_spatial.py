"""Spatial paths and extra loads in modes 2 and 3, on the manipulator of the manual (bibliography.md)."""

import re

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.errors import InputError
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
    rates = np.column_stack([circled.element(i, 1, "ed") for i in (1, 2, 3)])
    power = (circled["u0"] * rates).sum(axis=1)[:21]
    work = float(np.sum(0.5 * (power[1:] + power[:-1]) * np.diff(circled.t[:21])))
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


# BEAMW in modes 2 and 3: a robot arm with warping beams against its twin of BEAM.
# With rigid torsion and fixed warping nodes a BEAMW is a BEAM. With flexible torsion and warping held at both ends
# it has the torsional stiffness 6/5 GIt + 12 ECw/l^2 (theory-warping.md section 4), with the twist rates eliminated
# GIt.
GIT, ECW = 3e4, 1.5e3
WARPING = {4: (20, 21), 5: (22, 23)}


def warped(text: str, held: bool = True) -> str:
    """BEAM p rp q rq as BEAMW with two warping nodes, fixed or prescribed."""
    text = re.sub(
        r"^BEAM +(\d+) (\d+) (\d+) (\d+) (\d+)",
        lambda m: f"BEAMW {m[1]} {m[2]} {m[3]} {WARPING[int(m[1])][0]} {m[4]} {m[5]} {WARPING[int(m[1])][1]}",
        text,
        flags=re.MULTILINE,
    )
    keyword = "FIX" if held else "INPUTX"
    return text.replace("FIX 1\n", "FIX 1\n" + "".join(f"{keyword} {w}\n" for w in (20, 21, 22, 23)), 1)


def twisting(text: str, torsion: float, warping: float | None = None) -> str:
    """Torsion of both links as a degree of freedom with this stiffness."""
    text = re.sub(r"^(INPUTE [45]) 3", r"\1 2 3", text, flags=re.MULTILINE)
    text = re.sub(r"^EM ([45]) (\S+)", r"EM \1 \2 0.02", text, flags=re.MULTILINE)
    tail = "" if warping is None else f" 0. 0. {warping!r}"
    return re.sub(r"^ESTIFF ([45]) 0\. 0\. (\S+ \S+)", rf"ESTIFF \1 0. {torsion!r} \2{tail}", text, flags=re.MULTILINE)


def motion() -> str:
    """The deck of mode 2 with a tenth of the steps."""
    return (DATA / "robotflexinv.dat").read_text().replace("1.0 100", "1.0 10").replace("0.2 20", "0.2 2")


@pytest.fixture(scope="module")
def nominal():
    text = motion()
    return {name: spacar.run(2, parse_deck(t, name, 2)) for name, t in (("plain", text), ("warped", warped(text)))}


def test_inverse_dynamics_is_that_of_the_twin(nominal):
    """The same motors, motion, forces and moments; the torque is what modes 2, 7 and 8 carry together."""
    plain, own = nominal["plain"], nominal["warped"]
    assert own["u0"] == pytest.approx(plain["u0"], rel=1e-9, abs=1e-9 * np.abs(plain["u0"]).max())
    for node in (5, 8):
        for k in (1, 2, 3):
            assert own.node(node, k, "xdd") == pytest.approx(plain.node(node, k, "xdd"), abs=1e-9)
    for element in (4, 5):
        size = max(np.abs(plain.element(element, k, "sig")).max() for k in range(1, 7))
        for k in (1, 3, 4, 5, 6):
            expected = plain.element(element, k, "sig")
            assert own.element(element, k, "sig") == pytest.approx(expected, abs=1e-9 * size)
        torque = own.element(element, 2, "sig") + own.element(element, 7, "sig") - own.element(element, 8, "sig")
        assert torque == pytest.approx(plain.element(element, 2, "sig"), abs=1e-9 * size)


def stiffness(result: spacar.Result, step: int) -> tuple[np.ndarray, np.ndarray, list[str]]:
    return result["k0"][step], result["m0"][step], list(result.mechanism.numbering.q_names)


@pytest.fixture(scope="module")
def linear():
    return (DATA / "robotflexinvlin.dat").read_text()


def test_linearization_with_held_warping_is_that_of_the_twin(nominal, linear):
    """K0 and M0 of mode 3, at rest, on the way and at the end."""
    l = float(np.hypot(0.268, 0.6467))  # both links are as long
    twin = twisting(linear, 1.2 * GIT + 12.0 * ECW / l**2)
    plain = spacar.run(3, parse_deck(twin, "plain", 3), nominal=nominal["plain"])
    own = spacar.run(3, parse_deck(warped(twisting(linear, GIT, ECW)), "warped", 3), nominal=nominal["warped"])
    for step in (0, 3, 11):
        for ours, theirs in zip(stiffness(own, step)[:2], stiffness(plain, step)[:2], strict=True):
            assert ours == pytest.approx(theirs, rel=1e-9, abs=1e-9 * np.abs(theirs).max())


def test_linearization_with_free_warping_is_that_of_the_twin(linear):
    """The twist rates eliminated from K0, GIt is left. They are degrees of freedom of both runs."""
    text = motion()
    l = float(np.hypot(0.268, 0.6467))
    rows = "".join(f"EM {e} {m} 0.02 0. 0. 0. 1e-4\n" for e, m in ((4, 4), (5, 2)))
    free = re.sub(r"^EM [45].*\n", "", warped(twisting(linear, GIT, ECW), held=False), flags=re.MULTILINE)
    free = free.replace("GRAVITY", rows + "GRAVITY")
    own = spacar.run(3, parse_deck(free, "free", 3), nominal=spacar.run(2, parse_deck(warped(text, False), "free", 2)))
    plain = spacar.run(
        3, parse_deck(twisting(linear, GIT), "plain", 3), nominal=spacar.run(2, parse_deck(text, "plain", 2))
    )
    K, _, names = stiffness(own, 3)
    w = np.array([name.endswith(" w") for name in names])
    assert w.sum() == 4
    left = K[~w][:, ~w] - K[~w][:, w] @ np.linalg.solve(K[w][:, w], K[w][:, ~w])
    expected = stiffness(plain, 3)[0]
    assert left == pytest.approx(expected, rel=1e-8, abs=1e-8 * np.abs(expected).max())
    assert own["m0"][3][w][:, w] == pytest.approx(0.5 * l * 1e-4 * np.eye(4), rel=1e-9)


# A slider in a guide: one coordinate is moved along a path, the other one fixed. Velocities of nodes and elements
# with one number are told apart.
MECHANISM = "PLBEAM 1 1 2 3 4\nPLBEAM 2 3 5 6 7\nX 3 0.3 0.4\nX 6 0.6 0\nFIX 1\nFIX 6 2\nINPUTX 6 1\n"
TEXT = MECHANISM + "END HALT\nXM 3 1\nEND HALT\nTRAJECT 1\nTRANS 6 {end}\nTRTIME 1 8\nEND END\n"


def test_a_slider_follows_its_guide() -> None:
    """Two rods of 0.5 m: the middle node is at half the way, at the height of an isosceles triangle; symmetric profile
    of constant acceleration 4 L/T^2."""
    r = spacar.run(2, parse_deck(TEXT.format(end="0.8 0"), mode=2))
    x = r.node(6, 1)
    t = r.t
    way = np.where(t < 0.5, 2 * t**2, 1 - 2 * (1 - t) ** 2)
    assert x == pytest.approx(0.6 + 0.2 * way, abs=1e-14)
    assert np.all(r.node(6, 2) == 0.0)
    assert r.node(3, 2) == pytest.approx(np.sqrt(0.25 - (x / 2) ** 2), abs=1e-12)


def test_a_path_that_leaves_the_guide_is_refused() -> None:
    with pytest.raises(InputError, match="coordinate 2 of node 6 is fixed at 0 m: not on the path"):
        spacar.run(2, parse_deck(TEXT.format(end="0.8 0.1"), mode=2))


@pytest.mark.parametrize("number", [6, 9])
def test_a_velocity_belongs_to_a_node_or_an_element(number: int) -> None:
    """Node 6 moves with a rise time of its own, an element with the same number with another one."""
    text = MECHANISM + f"PLBEAM {number} 20 21 22 23\nX 20 5 0\nX 22 6 0\nFIX 20\nFIX 21\nINPUTE {number} 1\n"
    text += "END HALT\nXM 3 1\nEND HALT\nTRAJECT 1\nTRANS 6 0.8 0\nTRVMAX 6 0.1\nTRE "
    text += f"{number} 0.1\nTREPMAX {number} 0.8\nTRTIME 1 20\nEND END\n"
    r = spacar.run(2, parse_deck(text, mode=2))
    peak = r.t[np.argmax(r.node(6, 1, "xd"))], r.t[np.argmax(r.element(number, 1, "ed"))]
    assert peak == pytest.approx((0.1, 0.8))
