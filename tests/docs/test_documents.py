"""The documents for people: every command and number is run, every link leads somewhere."""

import ast
import re
import shlex
import shutil
from functools import cache
from pathlib import Path

import click
import pytest
from spacar_cli.main import program

from .documents import blocks, broken_links, module_of, run_document, same_line

HOUSE = Path(__file__).resolve().parents[2]
DOCS = HOUSE / "docs"
PAGES = [HOUSE / "README.md", HOUSE / "CONTRIBUTING.md", HOUSE / "CHANGELOG.md", *sorted(DOCS.rglob("*.md"))]


@pytest.mark.parametrize(
    ("page", "data", "commands", "numbers"),
    [
        ("docs/tutorial.md", "", 40, 100),
        ("README.md", "data", 8, 5),  # in a folder that looks like a clone
        ("docs/python.md", "data", 40, 20),
        pytest.param("docs/simulation.md", ".", 16, 0, marks=pytest.mark.slow),
        ("docs/studies.md", ".", 3, 0),
        ("docs/flexures.md", ".", 10, 60),
        ("docs/sensitivity.md", "", 3, 1),
        ("docs/convergence.md", "data", 15, 10),
    ],
)
def test_what_a_page_shows(page, data, commands, numbers, tmp_path):
    if data:
        shutil.copytree(HOUSE / "data", tmp_path / data, dirs_exist_ok=True)
    count = run_document(HOUSE / page, tmp_path)
    assert count.commands >= commands
    assert count.numbers >= numbers
    assert numbers or count.commands == commands
    if "tutorial" in page:
        assert count.files == ["mycrank.dat", "guide.dat", "flexible.dat", "myfourbar.dat"]


def test_readme_names_targets_that_exist():
    targets = re.findall(r"^([\w-]+):", (HOUSE / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE)
    named = re.findall(r"\bmake ([\w-]+)", (HOUSE / "README.md").read_text(encoding="utf-8"))
    assert {"crank", "test"} <= set(named) <= set(targets)


def shown_commands() -> list[tuple[str, str]]:
    """(page, line) of the command lines that pages show without running them; those with placeholders are left out."""
    lines = []
    for page in PAGES:
        for block in blocks(page):
            if block.language in ("", "sh", "text"):
                text = block.text.replace("\\\n", " ")
                found = re.findall(r"^(spacar .*?)(?: +#.*| {3,}\S.*| {4,}.*)?$", text, flags=re.MULTILINE)
                placeholder = re.compile(r"\[-|\w\|\w|\b(FILE|MODEL|NAME)\b|\.\.\.")
                lines += [(page.name, line) for line in found if not placeholder.search(line)]
    return lines


def test_shown_commands_are_commands_with_these_options():
    """Parsed as the shell and click do; the pages that show results run their commands besides."""
    shown = shown_commands()
    assert len(shown) > 100
    for page, line in shown:
        name, *words = shlex.split(line)[1:]
        command = program.get_command(click.Context(program), name)
        assert command is not None, f"{page}: {line}"
        try:
            command.make_context(name, words)
        except click.UsageError as error:
            raise AssertionError(f"{page}: {line}: {error.format_message()}") from error


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links(page):
    assert not broken_links(page)


@pytest.mark.parametrize("folder", [DOCS, DOCS / "reference"], ids=["docs", "reference"])
def test_every_page_is_in_its_index(folder):
    text = (folder / "index.md").read_text(encoding="utf-8")
    assert not [p.name for p in folder.glob("*.md") if p.name != "index.md" and f"]({p.name})" not in text]


@pytest.mark.parametrize(
    ("expected", "got", "same"),
    [
        ("x = 1.0 m", "x  =  1.000001 m", True),
        ("x = 1.0 m", "x = 1.001 m", False),
        ("node 3 x", "node 4 x", False),
        ("-5062.5", "-5062.50000001", True),
        ("a 1", "b 1", False),
        ("e2 0", "e2 -1e-12", True),
    ],
)
def test_the_comparison_of_printed_lines(expected, got, same):
    assert same_line(expected, got) == same


def test_every_block_of_the_pages_is_of_a_known_kind():
    kinds = {"console", "python", "matlab", "sh", "text", "make", "toml", ""}
    for page in PAGES:
        assert {b.language for b in blocks(page)} <= kinds, page


def test_modules_and_tests_that_are_named_exist():
    """`spacar/...` in back quotes is a path, `folder/file.py::name` a test."""
    bad = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for path in re.findall(r"`((?:spacar|formats|cli|tests|benchmarks|data)/[\w./-]*)`", text):
            bad += [f"{page.name}: {path}"] * (not (HOUSE / path).exists())
        for file, name in re.findall(r"`(?:tests/)?([\w/]+\.py)::(\w+)`", text):
            source = HOUSE / "tests" / file
            known = source.exists() and f"def {name}(" in source.read_text(encoding="utf-8")
            bad += [f"{page.name}: {file}::{name}"] * (not known)
    assert not bad, "\n".join(bad)


def test_every_page_is_in_the_contents_of_the_site():
    """Each once. A page that is in no list lets `make docs` fail, which needs packages that a test run has not."""
    text = (DOCS / "conf.py").read_text(encoding="utf-8")
    [table] = re.findall(r"^CONTENTS = (\{.*?^\})", text, re.MULTILINE | re.DOTALL)
    listed = [page for pages in ast.literal_eval(table).values() for page in pages]
    pages = [p.relative_to(DOCS).with_suffix("").as_posix() for p in DOCS.rglob("*.md")]
    top = [page for page in listed if page.startswith("/")]
    assert sorted(listed) == sorted([*top, *(page for page in pages if page != "index")])


# The four start pages: each from an empty folder to a picture, as it says.
START_PAGES = sorted(DOCS.glob("start-*.md"))


def test_there_is_a_page_for_each_kind_of_user() -> None:
    assert [p.stem for p in START_PAGES] == ["start-control", "start-flexure", "start-python", "start-spacar"]


@pytest.mark.parametrize("page", START_PAGES, ids=lambda p: p.stem)
def test_a_start_page_leads_to_a_picture(page, tmp_path) -> None:
    count = run_document(page, tmp_path)
    assert count.commands >= 2
    assert list(tmp_path.glob("*.png"))


# The gallery shows every example of `data/`, with a picture that exists and commands that name the example.
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


# The page on failures: its headings are words of the program, its codes exist.
TEXT = (DOCS / "convergence.md").read_text(encoding="utf-8")


@cache
def core_text() -> str:
    """The text of the core, its pieces of messages joined."""
    paths = sorted((HOUSE / "spacar").rglob("*.py"))
    return re.sub(r'"\s*\n\s*f?"', "", "\n".join(p.read_text(encoding="utf-8") for p in paths))


def test_the_headings_are_messages():
    headings = re.findall(r"^### (.+)$", TEXT, re.MULTILINE)
    missing = [h for h in headings if h not in core_text()]
    assert len(headings) >= 15
    assert not missing


def test_every_section_has_a_code_that_exists():
    for section in re.split(r"^### ", TEXT, flags=re.MULTILINE)[1:]:
        code = re.search(r"`\[([\w.-]+)\]`", section)
        assert code is not None, section.splitlines()[0]
        assert f'"{code[1]}"' in core_text(), code[1]


def test_failures_of_position_and_statics_are_on_the_page():
    named = set(re.findall(r'"((?:position|statics)\.[a-z-]+)"', core_text()))
    assert len(named) >= 4
    assert not {code for code in named if f"`[{code}]`" not in TEXT}


# docs/limits.md is made by docs/limits.py: every limit of the program with its present number.
LIMITS_PAGE = (DOCS / "limits.md").read_text(encoding="utf-8")
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
    assert rows(LIMITS_PAGE) == rows(now), MAKE


def test_a_limit_is_found(tmp_path, monkeypatch) -> None:
    """A constant with its comment, and no divisor that shall not be zero."""
    source = tmp_path / "x.py"
    source.write_text("A = 1e-9  # rounding\nB = 1e-300\nC = 2.0\n")
    monkeypatch.setattr(LIMITS, "HOUSE", tmp_path)
    found = list(LIMITS.limits(source))
    assert found == [("x.py", "A", "1e-09", "rounding")]
