"""`spacar edit` as a user has it, in a headless Chromium; pictures of every step go to SPACAR_SHOTS when it is set."""

from __future__ import annotations

import importlib.util
import math
import os
import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from spacar_cli.editor import model_tasks

from .browsing import CHROMIUM, EditorPage, browser, served
from .story import story, story_file

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium"),
    pytest.mark.skipif(importlib.util.find_spec("playwright") is None, reason="no playwright (PyPI)"),
]
HERE = Path(__file__).parent
DATA = HERE.parents[1] / "data"


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as made:
        yield made


@pytest.fixture
def shot(tmp_path):
    """Keeps a picture of a step."""
    folder = Path(os.environ.get("SPACAR_SHOTS", tmp_path))

    def keep(page: EditorPage, name: str) -> None:
        page.page.wait_for_timeout(250)
        page.shot(folder / f"{name}.png")

    return keep


@pytest.fixture
def crank(tmp_path) -> Path:
    shutil.copy(DATA / "crank.dat", tmp_path)
    return tmp_path / "crank.dat"


def test_from_an_empty_file_to_an_animated_four_bar(chromium, tmp_path, shot):
    """The story of the tutorial: typed key by key, with a slip, a missing drive, a run, a curve."""
    path = tmp_path / "myfourbar.dat"
    with served(path) as address:
        page = EditorPage(chromium, address)
        for name in story(page):
            shot(page, name)
        assert page.data("run") == "ended 0"
        assert page.data("curves") == "x[6,1]"
        assert page.complaints == []
    assert path.read_text() == story_file()


def test_an_error_shows_at_its_line_and_goes_when_it_is_mended(chromium, crank, shot):
    with served(crank) as address:
        page = EditorPage(chromium, address)
        page.checked()
        assert page.data("errors") == "0"
        assert page.data("freedom") == "1 0 0"
        drawn = page.data("pictures")
        page.line(9)
        page.page.keyboard.press("End")
        page.page.keyboard.press("Home")
        page.page.keyboard.type("FIX 6 3 ")
        page.checked()
        shot(page, "error")
        assert page.data("errors") != "0"
        row = page.page.inner_text("#messages li.error >> nth=0")
        assert row.startswith("9: FIX 6: coordinate 3 does not exist")
        gutter = page.page.locator(".cm-gutter-lint .cm-lint-marker-error")
        assert gutter.count() == 1
        number = page.page.locator(".cm-lineNumbers .cm-gutterElement", has_text=re.compile(r"^9$"))
        assert abs(gutter.bounding_box()["y"] - number.bounding_box()["y"]) < 12
        assert page.page.inner_text("#shown") == "start position, before the error"
        assert page.data("pictures") == drawn
        for _ in range(8):
            page.page.keyboard.press("Backspace")
        page.checked()
        assert page.data("errors") == "0"
        assert gutter.count() == 0
        assert page.page.inner_text("#shown") == "start position"
        page.page.keyboard.press("Control+z")
        page.checked()
        assert page.data("errors") != "0"
        assert page.complaints == []


def test_completion_help_and_folding(chromium, crank, shot):
    with served(crank) as address:
        page = EditorPage(chromium, address)
        page.checked()
        page.line(3)
        page.page.keyboard.type("PLB")
        page.page.wait_for_selector(".cm-tooltip-autocomplete li")
        assert "planar beam element" in page.page.inner_text(".cm-tooltip-autocomplete")
        page.page.keyboard.press("ArrowDown")
        page.page.wait_for_selector(".cm-completionInfo")
        shot(page, "completion")
        assert "deformation modes" in page.page.inner_text(".cm-completionInfo").lower()
        page.page.keyboard.press("Tab")
        assert page.cursor().startswith("PLBEAM")
        page.page.keyboard.press("Shift+Home")
        page.page.keyboard.press("Delete")
        page.page.keyboard.type("FIX ")
        page.page.keyboard.press("Control+Space")
        page.page.wait_for_selector(".cm-tooltip-autocomplete li")
        page.wait("() => document.querySelectorAll('.cm-tooltip-autocomplete li').length === 7")
        numbers = page.page.locator(".cm-tooltip-autocomplete li .cm-completionLabel").all_inner_texts()
        shot(page, "numbers")
        assert numbers == ["1", "2", "3", "4", "5", "6", "7"]
        page.page.keyboard.press("Escape")
        box = page.page.locator(".cm-line", has_text="TIMESTEP").bounding_box()
        page.page.mouse.move(box["x"] + 20, box["y"] + box["height"] / 2)
        page.page.wait_for_selector(".cm-tooltip-hover pre")
        shot(page, "help")
        assert "TIMESTEP:" in page.page.inner_text(".cm-tooltip-hover pre")
        page.page.mouse.move(900, 300)
        page.page.locator(".cm-foldGutter .cm-gutterElement", has_text="⌄").first.click()
        assert page.page.locator(".cm-foldPlaceholder").count() == 1
        shot(page, "folded")
        assert page.complaints == []


def test_picking_goes_both_ways(chromium, crank, shot):
    with served(crank) as address:
        page = EditorPage(chromium, address)
        page.checked()
        page.page.mouse.click(*page.place(6))
        assert page.cursor().startswith("X 6 0.45")
        assert "6 (7)" in page.page.inner_text("#picked")
        assert page.page.evaluate("() => document.querySelector('#panel').className") == "left"  # 6 is at the right
        shot(page, "picked-node")
        (x, y), (u, v) = page.place(3), page.place(6)
        page.page.mouse.click(0.5 * (x + u), 0.5 * (y + v))
        assert page.cursor().startswith("PLBEAM 2")
        assert "PLBEAM 2" in page.page.inner_text("#picked")
        page.line(3)
        assert page.data("chosen") == "element 1"
        page.line(7)
        assert page.data("chosen") == "node 6"
        page.wait("() => document.querySelector('#picked').innerText.includes('6 (7)')")
        assert page.complaints == []


def test_the_release_button_makes_an_over_constrained_four_bar_run(chromium, tmp_path, shot):
    path = tmp_path / "spatial_fourbar.dat"
    shutil.copy(HERE / path.name, path)
    with served(path) as address:
        page = EditorPage(chromium, address)
        page.checked()
        shot(page, "over-constrained")
        assert page.data("freedom").split()[1] == "3"
        page.page.click("#freedom button:has-text('Release what keeps')")
        page.wait("() => spacarPage.text().includes('RLSE 3 2 5 6')")
        page.checked()
        assert page.data("freedom").split()[1:] == ["0", "0"]
        shot(page, "released")
        page.page.click("#modes button[data-mode='1']")
        page.wait("() => (document.body.dataset.run || '').startsWith('ended')")
        assert page.data("run") == "ended 0"
        assert "RLSE 3 2 5 6" in path.read_text()
        shot(page, "four-bar-plays")
        first = page.page.inner_text("#time")
        page.wait("first => document.querySelector('#time').innerText !== first", first)
        assert page.complaints == []


def test_a_run_plays_with_log_and_curves(chromium, crank, shot):
    with served(crank) as address:
        page = EditorPage(chromium, address)
        page.checked()
        page.page.click("#modes button[data-mode='1']")
        page.wait("() => (document.body.dataset.run || '').startsWith('ended')")
        assert page.page.inner_text("#told").startswith("mode 1 done, 101 steps")
        assert page.page.inner_text("#shown") == "result"
        page.page.click("#play")  # pause
        page.page.mouse.click(*page.place(6))
        row = page.page.locator("#picked tr[data-asked='x[6,1]']").bounding_box()
        page.page.click("#play")
        page.page.mouse.move(row["x"] + 9, row["y"] + 9)
        page.page.mouse.down()
        page.wait("now => document.querySelector('#time').innerText !== now", page.page.inner_text("#time"))
        page.page.mouse.up()  # the pictures went on between the two
        page.wait("() => document.body.dataset.curves === 'x[6,1]'")
        page.page.click("#play")
        shot(page, "curves")
        assert page.page.locator("#plots canvas").count() == 1
        page.page.click("nav button[data-tab='log']")
        shot(page, "log")
        assert "forward dynamics" in page.page.inner_text("#log").lower()
        page.page.click("nav button[data-tab='freedom']")
        page.page.click("#modes button[data-mode='0']")
        page.wait("() => document.querySelector('#told').textContent.startsWith('mode 0 done')")
        assert page.complaints == []


def test_a_run_can_be_aborted_and_keeps_its_results(chromium, crank, shot):
    crank.write_text(crank.read_text().replace("TIMESTEP 0.1 100", "TIMESTEP 2000. 200000"))
    with served(crank) as address:
        page = EditorPage(chromium, address)
        page.checked()
        page.page.click("#modes button[data-mode='1']")
        page.wait("() => document.querySelector('#progress').value > 0")
        shot(page, "progress")
        page.page.click("#abort")
        page.wait("() => (document.body.dataset.run || '').startsWith('ended')")
        shot(page, "aborted")
        assert page.data("run") == "ended 130"
        assert page.page.inner_text("#told").startswith("aborted")
        assert page.page.inner_text("#shown") == "result"
        assert crank.with_suffix(".sbd.part").exists() or crank.with_suffix(".sbd").exists()


def test_a_file_changed_by_another_program_is_noticed(chromium, crank, shot):
    with served(crank) as address:
        page = EditorPage(chromium, address)
        page.checked()
        page.line(1)
        page.page.keyboard.type("% mine ")
        crank.write_text("% theirs\n" + crank.read_text())
        page.page.wait_for_selector("#warning:not([hidden])")
        shot(page, "changed-elsewhere")
        with page.page.expect_response("**/call/save"):
            page.page.click("#save")
        assert crank.read_text().startswith("% theirs")
        page.page.click("#second")  # keep mine
        page.page.click("#save")
        page.wait("() => document.querySelector('#saved').textContent === 'saved'")
        assert crank.read_text().startswith("% mine")
        crank.write_text("% theirs again\n" + crank.read_text())
        page.page.wait_for_selector("#warning:not([hidden])")
        page.page.click("#first")  # read it
        page.wait("() => spacarPage.text().startsWith('% theirs again')")


LATE_SAVE = """() => {
  const { fetch } = window;
  let states = 0;
  window.fetch = async (name, given) => {
    const answer = await fetch(name, given);
    if (name === "call/state") states++;
    if (name === "call/save") for (const now = states; states < now + 2;) await new Promise((go) => setTimeout(go, 20));
    return answer;
  };
}"""


def test_a_save_of_our_own_is_no_change_by_another_program(chromium, crank):
    """Also where questions about the file are answered before the save is."""
    with served(crank) as address:
        page = EditorPage(chromium, address)
        page.checked()
        page.page.evaluate(LATE_SAVE)
        page.line(1)
        page.page.keyboard.type("% mine ")
        page.page.click("#save")
        page.wait("() => document.querySelector('#saved').textContent === 'saved'")
        assert page.page.is_hidden("#warning")
        assert crank.read_text().startswith("% mine")


def many_beams(n: int) -> str:
    """A chain of n flexible spatial beams."""
    places = [f"X {2 * i + 1} {0.01 * i:.4f} 0 {0.2 * math.sin(0.02 * i):.6f}" for i in range(n + 1)]
    beams = [f"BEAM {i + 1} {2 * i + 1} {2 * i + 2} {2 * i + 3} {2 * i + 4} 0 1 0" for i in range(n)]
    classes = ["FIX 1", "FIX 2", *(f"DYNE {i + 1}" for i in range(n)), "END", "HALT"]
    dynamics = [f"EM {i + 1} 0.1 1e-6\nESTIFF {i + 1} 1e5 10 10 10" for i in range(n)]
    return "\n".join([*beams, *places, *classes, *dynamics, "TIMESTEP 1 10", "END", "END", ""])


KEYS = """async () => {
  for (let i = 0; i < 25; i++) {
    const { view } = spacarPage, at = view.state.doc.line(4000).from;
    view.dispatch({ changes: { from: at, insert: "%" }, selection: { anchor: at + 1 }, userEvent: "input.type" });
    view.contentDOM.getBoundingClientRect();
    await new Promise((done) => setTimeout(done, 30));
  }
}"""


def test_two_thousand_beams_while_typing(chromium, tmp_path, shot):
    """A key stroke is answered in 50 ms, check and picture in 1 s, of processor time: the page's and the server's."""
    path = tmp_path / "many.dat"
    path.write_text(many_beams(2000))
    with served(path) as address:
        page = EditorPage(chromium, address)
        page.checked()
        session = page.page.context.new_cdp_session(page.page)
        session.send("Performance.enable", {"timeDomain": "threadTicks"})

        def seconds() -> float:
            found = session.send("Performance.getMetrics")["metrics"]
            return float({row["name"]: row["value"] for row in found}["TaskDuration"])

        begun = seconds()
        page.page.evaluate(KEYS)
        key = (seconds() - begun) / 25
        page.checked()
        page.line(4000)
        drawn, begun = int(page.data("pictures")), seconds()
        page.page.keyboard.type("%")
        page.checked()
        look = seconds() - begun
        assert int(page.data("pictures")) == drawn + 1
        shot(page, "many")
        assert page.complaints == []
    model_tasks.answered("picture", {"text": many_beams(1), "file": str(path)})  # imports
    begun = time.process_time()
    for task in ("check", "picture"):
        assert "result" in model_tasks.answered(task, {"text": path.read_text(), "file": str(path)})
    behind = time.process_time() - begun
    print(f"key stroke {key:.3f} s; check and picture {look:.2f} s in the page, {behind:.2f} s behind it")
    assert key < 0.05
    assert look + behind < 1.0


def test_watching_follows_another_editor(chromium, crank, shot):
    with served(crank, "view", "--watch") as address:
        page = EditorPage(chromium, address)
        page.checked()
        shot(page, "watch")
        assert not page.page.is_visible("#editor")
        crank.write_text(crank.read_text().replace("FIX 6 2", "FIX 6 9"))
        page.page.wait_for_selector("#messages li.error")
        shot(page, "watch-error")
        crank.write_text(crank.read_text().replace("FIX 6 9", "FIX 6 2").replace("X 3 0.15", "X 3 0.20"))
        page.page.wait_for_selector("#messages li.fine")
        page.checked()
        assert int(page.data("pictures")) == 2
        assert page.complaints == []
