"""Settings of VISUALIZATION have entries in `spacar keywords`; pictures of modes say frequency or load multiplier."""

import pytest
from spacar_drawing import report_page
from spacar_drawing.picture_source import open_source
from spacar_drawing.settings import RULES, SPELLINGS

from .conftest import call


@pytest.mark.parametrize("name", RULES)
def test_every_setting_has_an_entry(name):
    done = call("keywords", name)
    assert done.status == 0
    assert f"{name}: {RULES[name].help}" in done.out
    assert "VISUALIZATION section" in done.out
    for heading in RULES[name].groups:
        assert f"behind a line {heading}" in done.out or f"or {heading}" in done.out


def test_other_spellings():
    for given, meant in SPELLINGS.items():
        assert call("keywords", given).out == call("keywords", meant).out


def test_a_name_of_both_has_both_meanings():
    """TRAJECT of the third block, and of the pictures."""
    text = call("keywords", "traject").out
    assert text.count("TRAJECT: ") == 2


def test_a_wrong_name_finds_a_setting():
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
