"""The VISUALIZATION section: both spellings and generations of input-language.md section 2."""

from spacar_drawing.settings import SectionShape, parse_settings, read_settings

from tests.examples import DATA


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
