"""`spacar check` names mistakes in the VISUALIZATION section; the settings of the reference pass."""

import pytest

MODEL = "PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nFIX 2 2\nDYNE 1\nEND HALT\nXM 2 1.\nESTIFF 1 8.\nEND END\n"


@pytest.fixture
def check(call, tmp_path):
    """What `spacar check` prints about a model with these settings in the file, or in m.spv beside it."""

    def said(settings: str, beside: bool = False) -> str:
        (tmp_path / "m.dat").write_text(MODEL + ("" if beside else f"VISUALIZATION\n{settings}\n"))
        if beside:
            (tmp_path / "m.spv").write_text(settings + "\n")
        result = call.done("check", "m")
        return result.err + result.out

    return said


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("BEEMVIS 0.1 0.1", "unknown setting 'BEEMVIS' of VISUALIZATION, not read; nearest: BEAMVIS"),
        ("LIGHT 2", "LIGHT: 2 must be 0 or 1"),
        ("LIGHT 1 TRAJECT 1", "LIGHT: a second setting 'TRAJECT' on the same line"),
        ("TRAJECTNODE 8", "node 8 does not exist"),
        ("TRUSSVIS CIRC 9 0.1", "element 9 does not exist"),
        ("TRUSSVIS RECT 0.1", "RECT needs 2 dimensions"),
        ("BEAMVIS SQUARE 0.1", "'SQUARE' is no shape"),
        ("TRANSPARENCY 1.5", "1.5 must be between 0 and 1"),
        ("VIBRATIONMODE", "0 numbers are given; expected 1 mode number"),
        ("VIBRATIONMODE 1.5", "'1.5' is no mode number"),
        ("STEPLINE 0", "0 must be positive"),
        ("ENLARGEFACTOR big", "'big' is not a number"),
        ("COLOR 0 0 1", "stands behind no heading; it belongs behind a line INITIAL"),
        ("3 4", "'3' stands where a setting is expected"),
    ],
)
def test_a_mistake_is_named_with_its_line(check, line: str, words: str) -> None:
    text = check(f"% drawing\n{line}")
    assert "warning: m.dat:12: " in text
    assert words in text
    assert "0 errors, 1 warning" in text
    beside = check(line, beside=True)
    assert "warning: m.spv:1: " in beside
    assert words in beside


def test_every_setting_of_the_reference_passes(check) -> None:
    good = """BEAMVIS 0.1 0.2
BEAMVIS RECTHOL 0.1 0.2 0.05 0.1   % comment
TRUSSVIS 1 0.1 0.1
HINGEVIS 1 0.1 0.2
BEAMPROPS 1
CROSSTYPE CIRCHOL
CROSSDIM 0.2 0.1
GRAPHICS 1
FACECOLOR 0.1 0.2 0.3
OPACITY 0.5
INITIAL
COLOR 0 0 0
DONOTDRAW 1
LIGHT 1
TRANSPERANCY 0.6
traject 1
TRAJECTNODE 1 2
STEPLINE 0.01
ENLARGEFACTOR 0.04
VIBRATIONMODE 1
BUCKLINGMODE 1"""
    assert "0 errors, 0 warnings" in check(good)
