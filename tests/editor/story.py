"""What the tutorial tells of `spacar edit`: a four-bar written by a new user; a test acts it, figures.py draws it."""

import re
from collections.abc import Iterator
from pathlib import Path

from .browsing import EditorPage, browser, served

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial.md"


def story_file() -> str:
    """The input file as the tutorial shows it."""
    found = re.search(r"<!-- file: myfourbar\.dat -->\n```text\n(.*?)```", TUTORIAL.read_text("utf-8"), re.S)
    assert found is not None
    return found[1]


def typed(page: EditorPage, text: str) -> None:
    """As a user types; Enter ends a line whatever is proposed."""
    for line in text.splitlines():
        page.page.keyboard.type(line)
        page.page.keyboard.press("Enter")


def stopped_at(page: EditorPage, step: int) -> None:
    """The picture that plays stops, and shows a step."""
    page.page.click("#play")
    page.page.evaluate("step => { const s = document.querySelector('#step'); s.value = step;"
                       "s.dispatchEvent(new Event('input')); }", step)  # fmt: skip


def story(page: EditorPage) -> Iterator[str]:
    """Acts in a page of a file that is not there; the name of a picture after every step."""
    lines = story_file().splitlines()
    drives = [n for n, line in enumerate(lines, 1) if line.startswith("INPUTX")]
    undriven = [line for n, line in enumerate(lines, 1) if n not in drives]
    page.checked()
    yield "edit-new.png"
    page.page.click(".cm-content")
    page.page.keyboard.press("Control+a")
    page.page.keyboard.press("Delete")
    typed(page, "\n".join(undriven).replace("FIX 9", "FIX 9 3"))
    page.checked()
    told = page.page.inner_text("#messages li.error >> nth=0")
    assert told.startswith("8: FIX 9: coordinate 3 does not exist"), (told, page.text())
    page.page.mouse.move(640, 700)
    yield "edit-error.png"
    page.line(8)
    for key in ("End", "Backspace", "Backspace"):
        page.page.keyboard.press(key)
    page.checked()
    assert page.data("freedom").split()[1:] == ["0", "1"]
    page.page.click("#freedom button:has-text('free motion 1')")
    page.wait("() => document.body.dataset.shown === 'free motion'")
    stopped_at(page, 3)
    yield "edit-free.png"
    for n in drives:
        page.line(n)
        typed(page, lines[n - 1])
    page.checked()
    assert page.data("freedom").split() == ["1", "0", "0"]
    page.page.click("#modes button[data-mode='1']")
    page.wait("() => (document.body.dataset.run || '').startsWith('ended')")
    stopped_at(page, 30)  # where the panel does not cover the node
    page.page.mouse.click(*page.place(6))
    page.page.click("#picked tr[data-asked='x[6,1]']")
    page.wait("() => document.body.dataset.curves === 'x[6,1]'")
    page.page.mouse.move(640, 560)
    yield "edit-plays.png"


def draw_story(path: Path) -> None:
    """The picture of one step, which the name tells, in a folder of its own."""
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder, served(Path(folder) / "myfourbar.dat") as address, browser() as chromium:
        page = EditorPage(chromium, address, 1100, 640)
        for name in story(page):
            if name == path.name:
                page.page.wait_for_timeout(300)
                page.shot(path)
                return
