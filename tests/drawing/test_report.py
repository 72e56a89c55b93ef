"""The report: one file that needs nothing else, shown by a real browser."""

import re
import subprocess
from html.parser import HTMLParser

import numpy as np
import pytest
from spacar_drawing.report_page import report_page

from .conftest import RUNS, call
from .models import result_source
from .test_viewer import CHROMIUM


class Page(HTMLParser):
    """Headings, images, and whether every element was closed."""

    EMPTY = ("meta", "img", "br", "link")

    def __init__(self, text):
        super().__init__()
        self.open, self.headings, self.images = [], [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        if tag == "img":
            self.images.append(dict(attributes))
        assert tag != "script"
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("h1", "h2"):
            self.headings.append(data)


@pytest.mark.parametrize("name", [
    pytest.param(n, marks=[pytest.mark.slow] * (n in ("robotinv", "plbeam5free"))) for n in RUNS
])  # fmt: skip
def test_page_is_well_formed_and_self_contained(results, name):
    done = call("report", results / name)
    assert (done.status, done.err) == (0, "")
    text = (results / f"{name}.html").read_text("utf-8")
    page = Page(text)
    assert page.headings[:3] == [name, "Model", "Degrees of freedom"]
    assert page.images
    assert all(i["src"].startswith("data:image/png;base64,") and i["alt"] for i in page.images)
    assert not re.search(r"(https?:)?//\w+\.\w", re.sub(r'src="data:[^"]*"', "", text))
    assert "Log" in page.headings


def test_what_the_page_says(results):
    call("report", results / "crank")
    text = (results / "crank.html").read_text("utf-8")
    for part in (
        "mode 1: forward dynamics", "2 PLBEAM", "101, t = 0 to 0.1 s", "node 2, rotation", "prescribed",
        "fxtot[2,1] (N m)",
    ):  # fmt: skip
        assert part in text
    call("report", results / "plbeam5free", "--log-lines", 0)
    text = (results / "plbeam5free.html").read_text("utf-8")
    assert "0.355131" in text
    assert "<h2>Log</h2>" not in text
    call("report", results / "crank", "--plot", "x[6,1]", "-o", results / "other.html")
    assert "x[6,1] (m)" in (results / "other.html").read_text("utf-8")


def test_text_from_files_cannot_break_the_page(results):
    """A log with markup is shown, not interpreted."""
    (results / "crank.log").write_text("<script>alert(1)</script> & <b>")
    call("report", results / "crank")
    text = (results / "crank.html").read_text("utf-8")
    assert "<script" not in text
    assert "&lt;script&gt;" in text


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")
def test_a_browser_shows_the_pictures(results):
    from PIL import Image

    call("report", results / "crank")
    shot = results / "shot.png"
    command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={results / 'profile'}",
               "--window-size=950,1400", f"--screenshot={shot}", f"file://{results / 'crank.html'}"]  # fmt: skip
    subprocess.run(command, check=True, capture_output=True, timeout=60)
    with Image.open(shot) as image:
        pixels = np.asarray(image.convert("RGB"), int)
    assert pixels.shape == (1400, 950, 3)
    # the dark blue-grey of the rigid bars and the red of the drive arrow are on the page: the pictures were decoded
    for colour in ((0x3C, 0x4A, 0x57), (0xC0, 0x27, 0x2D)):
        assert np.sum(np.abs(pixels - colour).max(2) < 30) > 20


def test_symbols_have_a_picture_of_their_own(results):
    source = result_source("plbeam5", 7)
    plain, marked = (report_page(source, log_lines=0, symbols=kinds) for kinds in ((), ("loads", "reactions")))
    assert marked.count("<figure") == plain.count("<figure") + 1
    assert "Loads, reactions of step" in marked
    assert "--symbols winds: expected loads" in call.refused("report", results / "crank", "--symbols", "winds")


@pytest.mark.parametrize("asked", [[], ["e[1,2]"]])
def test_what_stays_zero_is_named_in_one_line_unless_it_was_asked_for(asked):
    section = report_page(result_source("plbeam5free", 7), asked).partition("Key results")[2].partition("<h2>")[0]
    if asked:
        assert "Zero at all steps" not in section
        assert len(re.findall(r"<tr><th>([^<]*)</th><td>", section)) == 1
    else:
        assert "Zero at all steps: " in section
        assert not re.search(r"<td>0</td></tr>", section)
