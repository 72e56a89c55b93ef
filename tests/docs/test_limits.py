"""docs/limits.md is made by docs/limits.py: every limit of the program with its present number."""

import re
from pathlib import Path

from .documents import module_of

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = (DOCS / "limits.md").read_text(encoding="utf-8")
MAKE = "run: python docs/limits.py > docs/limits.md"
LIMITS = module_of(DOCS / "limits.py")


def rows(text: str) -> set[tuple[str, str, str]]:
    """File, name and number; comments may change without the page."""
    files = re.split(r"^- `(.*)`\n", text, flags=re.MULTILINE)[1:]
    limit = re.compile(r"^  - `(.+?)` ([^:\n]+)", re.MULTILINE)
    return {(file, *found) for file, part in zip(files[::2], files[1::2], strict=True) for found in limit.findall(part)}


def test_the_page_has_the_limits_of_the_program() -> None:
    now = LIMITS.page()
    assert len(rows(now)) > 100
    assert rows(PAGE) == rows(now), MAKE


def test_a_limit_is_found(tmp_path, monkeypatch) -> None:
    """A constant with its comment, and no divisor that shall not be zero."""
    source = tmp_path / "x.py"
    source.write_text("A = 1e-9  # rounding\nB = 1e-300\nC = 2.0\n")
    monkeypatch.setattr(LIMITS, "HOUSE", tmp_path)
    found = list(LIMITS.limits(source))
    assert found == [("x.py", "A", "1e-09", "rounding")]
