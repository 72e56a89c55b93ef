"""A slider in a guide: one coordinate is moved along a path, the other one fixed. Velocities of nodes and elements with
one number are told apart."""

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.errors import InputError

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
