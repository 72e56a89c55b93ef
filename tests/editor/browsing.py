"""`spacar edit` and a headless Chromium for tests and for the pictures of the documentation."""

import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
ARGUMENTS = (
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)  # fmt: skip
PATIENCE = 240_000  # milliseconds that a step may take on a busy machine: nothing depends on it but a failure


@contextmanager
def served(path: Path, *words: str) -> Iterator[str]:
    """The address that `spacar edit FILE --no-browser` (or the other words) prints, while it runs."""
    command = [sys.executable, "-m", "spacar_cli.main", *(words or ("edit",)), path.name, "--no-browser"]
    with subprocess.Popen(command, cwd=path.parent, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            yield process.stdout.readline().split()[-1]
        finally:
            process.terminate()


@contextmanager
def browser() -> Iterator[Any]:
    """A Chromium of its own."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        try:
            yield made
        finally:
            made.close()


class EditorPage:
    """The page as a user has it: `page` is that of playwright; `complaints` what the browser said against it."""

    def __init__(self, chromium: Any, address: str, width: int = 1280, height: int = 800) -> None:
        self.page = chromium.new_page(viewport={"width": width, "height": height})
        self.page.set_default_timeout(PATIENCE)
        self.complaints: list[str] = []
        self.page.on("console", lambda m: self.complaints.append(m.text) if m.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.goto(address)
        self.page.wait_for_selector("body[data-state=ready]")

    def data(self, name: str) -> str:
        """What the page says of itself."""
        return str(self.page.evaluate("name => document.body.dataset[name]", name))

    def wait(self, condition: str, argument: object = None) -> None:
        """Until a condition in JavaScript holds."""
        self.page.wait_for_function(condition, arg=argument)

    def checked(self) -> None:
        """Until the text as it stands is checked and drawn, and its freedoms are counted."""
        self.wait("() => !spacarPage.busy()")

    def line(self, number: int) -> None:
        """The cursor at the beginning of a line."""
        self.page.evaluate("n => spacarPage.goTo(spacarPage.view.state.doc.line(n).from)", number)

    def cursor(self) -> str:
        """The line that the cursor is in."""
        return str(self.page.evaluate(
            "() => spacarPage.view.state.doc.lineAt(spacarPage.view.state.selection.main.head).text"
        ))  # fmt: skip

    def text(self) -> str:
        return str(self.page.evaluate("() => spacarPage.text()"))

    def write(self, text: str) -> None:
        """Replace the whole text."""
        self.page.evaluate("text => spacarPage.change(text)", text)

    def place(self, node: int) -> tuple[float, float]:
        """Where a node is in the window [px]."""
        x, y = self.page.evaluate("node => spacarPage.results.place(node)", node)
        return float(x), float(y)

    def shot(self, path: Path) -> None:
        self.page.screenshot(path=str(path))
