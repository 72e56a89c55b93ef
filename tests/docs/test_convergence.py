"""The page on failures: its headings are words of the program, its codes exist, its examples fail as it says."""

import re
import shutil
from functools import cache
from pathlib import Path

from .documents import run_document

HOUSE = Path(__file__).resolve().parents[2]
PAGE = HOUSE / "docs" / "convergence.md"
TEXT = PAGE.read_text(encoding="utf-8")


@cache
def program() -> str:
    """The text of the core, its pieces of messages joined."""
    paths = sorted((HOUSE / "spacar").rglob("*.py"))
    return re.sub(r'"\s*\n\s*f?"', "", "\n".join(p.read_text(encoding="utf-8") for p in paths))


def test_the_headings_are_messages():
    headings = re.findall(r"^### (.+)$", TEXT, re.MULTILINE)
    missing = [h for h in headings if h not in program()]
    assert len(headings) >= 15
    assert not missing


def test_every_section_has_a_code_that_exists():
    sections = re.split(r"^### ", TEXT, flags=re.MULTILINE)[1:]
    for section in sections:
        code = re.search(r"`\[([\w.-]+)\]`", section)
        assert code is not None, section.splitlines()[0]
        assert f'"{code[1]}"' in program(), code[1]


def test_failures_of_position_and_statics_are_on_the_page():
    named = set(re.findall(r'"((?:position|statics)\.[a-z-]+)"', program()))
    assert len(named) >= 4
    assert not {code for code in named if f"`[{code}]`" not in TEXT}


def test_the_examples_run(tmp_path):
    shutil.copytree(HOUSE / "data", tmp_path / "data")
    count = run_document(PAGE, tmp_path)
    assert count.commands >= 15
