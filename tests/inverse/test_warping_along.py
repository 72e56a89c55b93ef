"""BEAMW in modes 2 and 3: a robot arm with warping beams against its twin of BEAM, a cross hinge against mode 10.

With rigid torsion and fixed warping nodes a BEAMW is a BEAM. With flexible torsion and warping held at both ends it has
the torsional stiffness 6/5 GIt + 12 ECw/l^2 (theory-warping.md section 4), with the twist rates eliminated GIt.
"""

import re

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from tests.examples import DATA

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


def test_mode_3_about_the_load_steps_of_mode_10():
    """The published cross hinge: mass, stiffness and geometric stiffness of mode 3 are those of mode 10."""
    text = (DATA / "crosshingew.dat").read_text().replace("END\nHALT", "OUTLEVEL 0 1\nEND\nHALT", 1)
    text = text.replace("ITERSTEP 10 9 0.0000005", "ITERSTEP 20 3 1e-11")
    ten = spacar.run(10, parse_deck(text, "h", 10))
    three = spacar.run(3, parse_deck(text, "h", 3), nominal=ten)
    n = ten.mechanism.numbering
    order = np.array([list(three.mechanism.numbering.q_names).index(n.q_names[i]) for i in n.dynamic])
    for step in range(len(ten.t)):
        for name in ("m0", "k0", "g0"):
            ours, theirs = three[name][step][np.ix_(order, order)], ten[name][step]
            # the stationary solution is in equilibrium to 1e-8 of its loads, on which only G0 depends
            limit = (1e-6 if name == "g0" else 1e-9) * np.abs(theirs).max()
            assert np.abs(ours - theirs).max() <= limit, (name, step)
