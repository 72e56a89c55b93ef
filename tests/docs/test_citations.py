"""Every citation in code, tests and pages leads somewhere: sections, formulas, links, the manual and the paper."""

import re
from functools import cache
from pathlib import Path

import pytest

from .citations import DOCS, HOUSE, REFERENCE, Citation, bare_formulas, citations, dangling, find, numbered, prose

PAPER_EQUATIONS, PAPER_TABLES = 22, 19
NAMED = re.compile(r"\b[Tt]he (?:original )?(manual|paper)\b")
PAGES = sorted(DOCS.rglob("*.md"))
ROOMS = ("spacar", "formats", "cli", "tests", "benchmarks", "data", "docs")


@cache
def sources() -> list[Path]:
    """Code that people read: Python and C, without what a generator writes and without hidden folders."""
    found = [p for room in ROOMS for suffix in ("py", "c", "dat", "sim") for p in (HOUSE / room).rglob(f"*.{suffix}")]
    return sorted(p for p in found if "generated" not in p.parts and p.parts[-2:] != ("docs", "test_citations.py"))


@cache
def lines(path: Path) -> str:
    return prose(path)


@cache
def cited(path: Path) -> list[Citation]:
    return list(citations(lines(path)))


def relative(path: Path) -> str:
    return str(path.relative_to(HOUSE))


def test_the_finder_sees_what_is_wrong():
    """Ways to cite that occur, with one wrong number each; else the other tests would pass for the wrong reason."""
    for good, bad in (
        ("theory-system.md section 2.3 gives", "theory-system.md section 2.9 gives"),
        ("(theory-system.md (12), (13)).", "(theory-system.md (12), (33))."),
        ("theory-planar.md 3.1 (3) to (5)", "theory-planar.md 3.1 (3) to (55)"),
        ("reference/files.md sections 4, 5, 6, 9).", "reference/files.md sections 4, 5, 6, 19)."),
        ("`symbolic.md`, sections 3.2, 3.3, 4.2.", "`symbolic.md`, sections 3.2, 3.3, 4.9."),
        ("input-language.md notes d5 and d12; index", "input-language.md notes d5 and d99; index"),
        ("files.md 3", "filez.md 3"),
    ):
        assert dangling(good) == []
        assert len(dangling(bad)) >= 1, bad


def test_citations_in_code():
    wrong = {relative(p): found for p in sources() if (found := dangling(lines(p)))}
    assert not wrong


def test_code_cites_the_reference():
    """The house has some 180 citations with a page name; far fewer would mean that the finder has gone blind."""
    assert sum(find(c.page) is not None and find(c.page).parent == REFERENCE for p in sources() for c in cited(p)) > 300


def test_formulas_without_a_page_belong_to_a_page_that_the_file_cites():
    wrong = {}
    for p in sources():
        bare = bare_formulas(lines(p))
        pages = {page for c in cited(p) if (page := find(c.page))}
        known = set().union(*map(numbered, pages)) if pages else set()
        if NAMED.search(lines(p)):
            known |= {f"({n})" for n in range(1, PAPER_EQUATIONS + 1)}
        if lost := bare - known:
            wrong[relative(p)] = sorted(lost)
    assert not wrong


def test_the_manual_and_the_paper_lead_to_the_bibliography():
    """In the file itself, or said once for its room: in the `__init__.py` or `conftest.py` beside it."""
    wrong = []
    for p in sources():
        if NAMED.search(lines(p)):
            near = [p, p.parent / "__init__.py", p.parent / "conftest.py"]
            if not any(q.exists() and "bibliography.md" in lines(q) for q in near):
                wrong.append(relative(p))
    assert not wrong


def test_pages_that_name_manual_or_paper_link_to_the_bibliography():
    naming = [p for p in PAGES if p.name != "bibliography.md" and NAMED.search(p.read_text(encoding="utf-8"))]
    link = re.compile(r"bibliography\.md|\]\((\.\./)?(reference/)?index\.md\)")
    assert not [relative(p) for p in naming if not link.search(p.read_text(encoding="utf-8"))]


@pytest.mark.parametrize("page", PAGES, ids=relative)
def test_sections_that_pages_cite(page):
    assert not dangling(page.read_text(encoding="utf-8"))


def test_tables_and_equations_of_the_paper():
    """The paper has 22 equations and 19 tables."""
    text = " ".join(lines(p) for p in sources() if "symbolic" in p.parts)
    cited = re.findall(r"\btables? ((?:\d+(?:, | and | to )?)+)", text)
    tables = [int(n) for numbers in cited for n in re.findall(r"\d+", numbers)]
    assert tables
    assert max(tables) <= PAPER_TABLES


def test_nothing_in_the_reference_is_unsettled():
    """No marks of doubt: open points stand in decisions.md, each with what this program does."""
    mark = re.compile(r"\[\?[^\]]*\]?|\[P\b[^\]]*\]?")
    assert not {p.name: found for p in PAGES if (found := mark.findall(p.read_text(encoding="utf-8")))}
