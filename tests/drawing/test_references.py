"""Every example model has a picture that somebody has looked at; it must not change unnoticed."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from spacar_drawing.mechanism_picture import Extras, draw_steps

from tests.examples import DATA

from .models import DPI, PICTURES, REFERENCE, pixels, result_source, words

# Root mean square of the difference in grey levels. Matplotlib 3.8 and 3.11 differ by 0.2 (antialiasing); a joint that
# moves by 3 % of the width of the picture gives more than this, see the test below.
TOLERANCE = 1.0


def stored(name):
    return np.asarray(Image.open(REFERENCE / f"{name}.png").convert("L"), float)


def difference(a, b):
    assert np.all(np.abs(np.subtract(a.shape, b.shape)) <= 1)  # rounding of the size in pixels
    h, w = np.minimum(a.shape, b.shape)
    return float(np.sqrt(np.mean((a[:h, :w] - b[:h, :w]) ** 2)))


def test_every_example_has_a_picture():
    assert set(PICTURES) == {p.stem for p in DATA.glob("*.dat")} == {p.stem for p in REFERENCE.glob("*.png")}


@pytest.mark.parametrize("name", PICTURES)
def test_picture_is_the_reviewed_one(name):
    assert difference(pixels(PICTURES[name]()), stored(name)) < TOLERANCE


def test_the_tolerance_notices_a_change():
    source = result_source("fourbar", 1)

    def drawn(x, settings=source.settings):
        return pixels(draw_steps(source.scene, x, settings, Extras(True, True, title="")))

    x, right = source.x().copy(), drawn(source.x())
    x[:, source.scene.lnp[1, 0] - 1] += 0.04  # one of four nodes, 3 % of the width
    assert difference(drawn(x), stored("fourbar")) > TOLERANCE
    assert difference(right, stored("fourbar")) < 0.5
    assert difference(drawn(source.x(), replace(source.settings, hidden=frozenset({3}))), right) > TOLERANCE
    assert DPI < 60


def test_the_letters_are_the_numbers_of_nodes_and_elements():
    """Pictures are compared without letters. Position and orientation node at one place share a label: 1 (2)."""
    nodes, elements = [str(k) for k in range(1, 5)], [str(k) for k in range(1, 6)]
    assert sorted(words(PICTURES["fourbar"]())) == sorted(nodes + elements)
    assert words(PICTURES["column2"]()) == ["1 (2)", "3 (4)", "5 (6)", "1", "2"]
