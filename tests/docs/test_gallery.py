"""The gallery shows every example of `data/`, with a picture that exists and commands that name the example."""

import re
from pathlib import Path

import pytest

from .documents import module_of

HOUSE = Path(__file__).resolve().parents[2]
DOCS = HOUSE / "docs"
FIGURES = module_of(DOCS / "figures.py")
ENTRIES = FIGURES.gallery(DOCS / "gallery.md")


def test_every_example_is_shown_once():
    models = {p.stem for p in (HOUSE / "data").rglob("*") if p.suffix in (".dat", ".toml", ".sim", ".py")}
    assert sorted(e.example for e in ENTRIES) == sorted(models)


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda e: e.example)
def test_entry(entry):
    picture = DOCS / entry.picture
    assert picture.is_file()
    if entry.commands:
        assert any(entry.example in line for line in entry.commands)
        made_here = any(line.endswith(f"-o {picture.name}") for line in entry.commands)
        assert made_here or f'savefig("{picture.name}"' in entry.script
    else:
        assert picture.parent == DOCS / "symbolic"


def test_commands_run_the_mode_that_the_page_of_figures_uses():
    """A picture that FIGURES makes for another page shows the same command there, but for size and path."""
    for entry in ENTRIES:
        if (name := Path(entry.picture).name) in FIGURES.FIGURES:
            run, draw = FIGURES.FIGURES[name]
            shown = [re.sub(r"['\"]", "", line.removeprefix("spacar ")) for line in entry.commands]
            assert shown == [run, draw.format(name)]


def test_pictures_are_small():
    """A clone carries every picture for ever: below 3.5 MB together, and no single one above 300 kB but animations."""
    sizes = {p.name: p.stat().st_size for p in DOCS.rglob("*") if p.suffix in (".png", ".gif", ".svg")}
    assert sum(sizes.values()) < 3.5e6
    assert max(s for n, s in sizes.items() if not n.endswith(".gif")) < 3e5


def test_no_picture_is_left_over():
    text = "".join(p.read_text(encoding="utf-8") for p in [HOUSE / "README.md", *DOCS.rglob("*.md")])
    assert not [p.name for p in (DOCS / "pictures").iterdir() if p.name not in text]
