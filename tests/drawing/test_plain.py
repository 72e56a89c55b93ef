"""Elements without a picture of their own: a line between the position nodes, or a mark."""

import numpy as np
import pytest
from spacar_drawing import element_pictures
from spacar_drawing.drawn_shapes import Line, Mark
from spacar_drawing.element_pictures import element_shapes
from spacar_drawing.look import look_of
from spacar_drawing.mechanism_picture import Extras, draw_steps
from spacar_drawing.scene import Pose
from spacar_drawing.settings import RULES, SPELLINGS, parse_settings

from .models import result_source


@pytest.mark.parametrize("name", ["crank", "slider", "massspring", "trike2", "cardan", "screw"])
def test_no_shape_is_known(name, monkeypatch, tmp_path):
    """Every element gives one shape, and the picture of all of them, numbers included, is made."""
    source = result_source(name, 0)
    scene, x = source.scene, source.x(1)
    monkeypatch.setattr(element_pictures, "PARTS", {})
    monkeypatch.setattr(element_pictures, "ALONG_LINES", ())
    look, pose = look_of(scene, x[None], source.settings), Pose.of(scene, x)
    drawn = [e for e in scene.elements if e.number not in source.settings.hidden]
    shapes = element_shapes(scene, pose, look)
    lines = [s for s in shapes[: len(drawn)] if isinstance(s, Line)]
    assert len([s for s in shapes[: len(drawn)] if isinstance(s, Mark)]) == len(drawn) - len(lines)
    wanted = [pose.place[[e.p - 1, e.q - 1]] for e in drawn if e.p and e.q]
    np.testing.assert_array_equal([s.points for s in lines], wanted)
    figure = draw_steps(scene, x[None], source.settings, Extras(title="", element_numbers=True, node_numbers=True))
    figure.savefig(tmp_path / "plain.png")


VALUES = {
    "element": "3", "node": "8", "shape": "LINE", "dimensions": "0.01 0.02", "section": "0.01 0.02",
    "hinge": "1 0.01 0.02", "colour": "0.1 0.2 0.3", "unit": "0.5", "switch": "0", "positive": "0.1", "real": "2",
    "number": "2",
}  # fmt: skip


@pytest.mark.parametrize("name", [*RULES, *SPELLINGS])
def test_every_setting_that_is_checked_is_read(name):
    """A setting, behind a heading where it needs one, changes the picture; a heading with a setting behind it does."""
    rule = RULES[SPELLINGS.get(name, name)]
    lines = ["TRAJECTNODE 8", *rule.groups[:1]]
    behind = [other for other, r in RULES.items() if name in r.groups]
    more = [f"{name} {VALUES.get(rule.kind, '')}", *(f"{n} {VALUES[RULES[n].kind]}" for n in behind)]
    assert parse_settings([*lines, *more]) != parse_settings(lines)


def test_curves_over_a_stroke_are_smooth_but_for_kinks():
    """A parabola to 1 % of its range, |x| to rounding, and the computed states themselves."""
    from spacar_drawing.stroke_figures import smooth

    x = np.linspace(-1.0, 1.0, 9)
    for y, error in ((1.0 - x**2, 0.01), (np.abs(x), 1e-15)):
        dense, curve = smooth(x, y)
        assert np.max(np.abs(curve - (np.abs(dense) if error < 1e-3 else 1.0 - dense**2))) <= error
        np.testing.assert_allclose(np.interp(x, dense, curve), y, atol=1e-15)
