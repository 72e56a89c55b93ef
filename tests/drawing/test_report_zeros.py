"""The page leaves out tables of zeros and says so; what was asked for is shown."""

import re

from spacar_drawing.report_page import report_page

from .models import result_source


def rows(page):
    section = page.partition("Key results")[2].partition("<h2>")[0]
    return section, re.findall(r"<tr><th>([^<]*)</th><td>", section)


def test_what_stays_zero_is_named_in_one_line():
    source = result_source("plbeam5free", 7)
    section, _ = rows(report_page(source))
    assert "Zero at all steps: " in section
    assert not re.search(r"<td>0</td></tr>", section)


def test_what_was_asked_for_is_shown():
    source = result_source("plbeam5free", 7)
    section, found = rows(report_page(source, ["e[1,2]"]))
    assert "Zero at all steps" not in section
    assert len(found) == 1
