"""The VISUALIZATION section: both spellings and generations of input-language.md section 2."""

import numpy as np
import pytest
from spacar_drawing import element_pictures, report_page
from spacar_drawing.drawn_shapes import Line, Mark
from spacar_drawing.element_pictures import element_shapes
from spacar_drawing.look import look_of
from spacar_drawing.mechanism_picture import Extras, draw_steps
from spacar_drawing.picture_source import open_source
from spacar_drawing.scene import Pose
from spacar_drawing.settings import RULES, SPELLINGS, SectionShape, parse_settings, read_settings

from tests.examples import DATA

from .conftest import call
from .models import result_source


def lines(text):
    return parse_settings(text.strip().splitlines())


def test_old_style():
    s = lines("""
        BEAMVIS 0.01 0.1
        BEAMVIS RECTHOL 3 4 0.02 0.03 0.01 0.02   % elements 3 and 4
        beamvis circ 7 0.05
        BEAMVIS LINE 9
        TRUSSVIS CIRC 0.02
        HINGEVIS 1 0.01 0.03
        LIGHT 0
        TRANSPARENCY 0.6
        TRAJECT 1
        TRAJECTNODE 8
        STEPLINE 0.01
        ENLARGEFACTOR 0.04
        VIBRATIONMODE 2
        BUCKLINGMODE 3
    """)
    assert s.section(1, "beam") == SectionShape("RECT", (0.01, 0.1))
    assert s.section(3, "beam") == s.section(4, "beam") == SectionShape("RECTHOL", (0.02, 0.03, 0.01, 0.02))
    assert s.section(7, "beam") == SectionShape("CIRC", (0.05,))
    assert s.section(9, "beam") == SectionShape("LINE")
    assert s.section(5, "truss") == SectionShape("CIRC", (0.02,))
    assert s.hinges == {1: (0.01, 0.03)}
    assert (s.light, s.opacity, s.traces, s.step_line) == (False, 0.6, (8,), 0.01)
    assert (s.enlarge, s.vibration_mode, s.buckling_mode) == (0.04, 2, 3)


def test_new_style():
    s = lines("""
        BEAMPROPS 1 2 3
          CROSSTYPE RECT
          CROSSDIM 0.04 0.0005
        BEAMPROPS 4
          CROSSTYPE CIRC
          CROSSDIM 0.01
        GRAPHICS 1 2
          FACECOLOR 0.1 0.5 0.9
          OPACITY 0.4
        INITIAL
          COLOR 0.5 0.5 0.5
        DONOTDRAW 12 13
    """)
    assert s.section(2, "beam") == SectionShape("RECT", (0.04, 0.0005))
    assert s.section(4, "beam") == SectionShape("CIRC", (0.01,))
    assert s.section(5, "beam") is None
    assert s.colour(1) == (0.1, 0.5, 0.9)
    assert s.colour(3) is None
    assert (s.opacity_of(2), s.opacity_of(3)) == (0.4, 1.0)
    assert s.initial_colour == (0.5, 0.5, 0.5)
    assert s.hidden == {12, 13}


def test_other_spelling_unknown_and_broken_lines_are_no_errors():
    s = lines("""
        TRANSPERANCY 0.9
        SOMETHINGNEW 1 2 3
        BEAMVIS RECT 0.01
        CROSSDIM
        BEAMVIS -1 0.1
        HINGEVIS 1
        # a comment
    """)
    assert s.opacity == 0.9
    assert s.beams == {}
    assert s.hinges == {}


def test_traject_0_switches_the_paths_off():
    assert lines("TRAJECT 0\nTRAJECTNODE 8").traces == ()
    assert lines("TRAJECTNODE 8").traces == (8,)


def test_read_from_the_input_file_or_the_file_beside_it(tmp_path):
    assert read_settings(DATA / "robotinv.dat").traces == (8,)
    model = tmp_path / "m.dat"
    model.write_text("PLTRUSS 1 1 2\nEND END\n")
    (tmp_path / "m.spv").write_text("VISUALIZATION\nLIGHT 0\n")
    assert read_settings(model).light is False
    model.write_text("PLTRUSS 1 1 2\nEND END\nVISUALIZATION\nLIGHT 1\n")
    assert read_settings(model).light is True  # the section of the input file comes first
    assert read_settings(tmp_path / "none.dat").light is True


# Settings of VISUALIZATION have entries in `spacar keywords`; pictures of modes say frequency or load multiplier.
@pytest.mark.parametrize("name", RULES)
def test_every_setting_has_an_entry(name):
    done = call("keywords", name)
    assert done.status == 0
    assert f"{name}: {RULES[name].help}" in done.out
    assert "VISUALIZATION section" in done.out
    for heading in RULES[name].groups:
        assert f"behind a line {heading}" in done.out or f"or {heading}" in done.out


def test_names_of_settings():
    """Other spellings; TRAJECT is one of the third block and of the pictures; a wrong name finds a setting."""
    for given, meant in SPELLINGS.items():
        assert call("keywords", given).out == call("keywords", meant).out
    assert call("keywords", "traject").out.count("TRAJECT: ") == 2
    assert "nearest: ENLARGEFACTOR" in call.refused("keywords", "ENLARGFACTOR")


@pytest.mark.parametrize(("name", "words"), [("plbeam5free", " Hz, "), ("lateral4", "load multiplier ")])
def test_modes_of_the_report_say_their_number_in_the_picture(name, words, results, monkeypatch):
    titles = []
    monkeypatch.setattr(
        report_page, "html_figure", lambda figure, *_: titles.append(figure.axes[0].get_title(loc="left")) or ""
    )
    report_page.report_page(open_source(results / name), log_lines=0)
    modes = [t for t in titles if "mode" in t]
    assert len(modes) == report_page.MOST_MODES
    assert all(words in t for t in modes)


# Elements without a picture of their own: a line between the position nodes, or a mark.
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
