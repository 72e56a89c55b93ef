"""Elements without a picture of their own: a line between the position nodes, or a mark."""

import numpy as np
import pytest
from spacar_drawing import element_pictures
from spacar_drawing.drawn_shapes import Line, Mark
from spacar_drawing.element_pictures import element_shapes
from spacar_drawing.look import look_of
from spacar_drawing.mechanism_picture import Extras, draw_steps
from spacar_drawing.scene import Pose
from spacar_drawing.settings import WORDS
from spacar_drawing.settings_check import RULES, SPELLINGS

from .models import result_source


@pytest.mark.parametrize("name", ["crank", "slider", "massspring", "trike2", "cardan", "screw"])
def test_no_shape_is_known(name, monkeypatch, tmp_path):
    """Every element gives one shape, and the picture of all of them, numbers included, is made."""
    source = result_source(name, 0)
    scene, x = source.scene, source.x(1)
    monkeypatch.setattr(element_pictures, "PARTS", {})
    monkeypatch.setattr(element_pictures, "TOGETHER", {})
    look, pose = look_of(scene, x[None], source.settings), Pose.of(scene, x)
    drawn = [e for e in scene.elements if e.number not in source.settings.hidden]
    shapes = element_shapes(scene, pose, look)
    lines = [s for s in shapes[: len(drawn)] if isinstance(s, Line)]
    assert len([s for s in shapes[: len(drawn)] if isinstance(s, Mark)]) == len(drawn) - len(lines)
    wanted = [pose.place[[e.p - 1, e.q - 1]] for e in drawn if e.p and e.q]
    np.testing.assert_array_equal([s.points for s in lines], wanted)
    figure = draw_steps(scene, x[None], source.settings, Extras(title="", element_numbers=True, node_numbers=True))
    figure.savefig(tmp_path / "plain.png")


def test_every_setting_that_is_read_is_checked():
    """`spacar check` knows the words that the pictures use, and no others."""
    assert set(WORDS) == set(RULES) | set(SPELLINGS)


def test_curves_over_a_stroke_are_smooth_but_for_kinks():
    """A parabola to 1 % of its range, |x| to rounding, and the computed states themselves."""
    from spacar_drawing.stroke_figures import smooth

    x = np.linspace(-1.0, 1.0, 9)
    for y, error in ((1.0 - x**2, 0.01), (np.abs(x), 1e-15)):
        dense, curve = smooth(x, y)
        assert np.max(np.abs(curve - (np.abs(dense) if error < 1e-3 else 1.0 - dense**2))) <= error
        np.testing.assert_allclose(np.interp(x, dense, curve), y, atol=1e-15)
