"""Finds what comments, docstrings and pages cite: "files.md section 3", "theory-system.md 2.3 (9)"."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

HOUSE = Path(__file__).resolve().parents[2]
DOCS = HOUSE / "docs"
REFERENCE = DOCS / "reference"
PLACES = (REFERENCE, DOCS, DOCS / "symbolic", HOUSE)

NAME = re.compile(r"(?<![\w/.-])(?:docs/)?(?:reference/|symbolic/)?([\w-]+\.md)\b`?\)?")
WORDS = r"(?:\s*,?\s*(?:sections?|notes?|formulas?|equations?))?"
ITEM = r"(?:\((?:\d{1,2}|[AB])\)|[kdt]\d{1,2}\b|\d+(?:\.\d+)*[ab]?(?![\w.]*\d)(?!\w))"
ITEMS = re.compile(rf"{WORDS}\s*({ITEM}(?:(?:\s*,)?(?:\s+(?:and|to|note|notes))*\s+{ITEM})*)")
BARE = re.compile(r"(?<=[\s(\[])\((\d{1,2})\)(?=[\s.,;:)\]]|-\(|$)")


@dataclass(frozen=True)
class Citation:
    """`page` as cited, and one numbered thing in it ("3.4", "(9)", "k5"), or "" for the page itself."""

    page: str
    item: str


def prose(path: Path) -> str:
    """The text of a file on one line, without comment marks."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return " ".join(re.sub(r"^\s*(#|//|/?\*+|--)\s?", "", line).strip() for line in lines)


def citations(text: str) -> Iterator[Citation]:
    """Pages named in a text, with the sections, formulas and notes that follow the name."""
    for found in NAME.finditer(text):
        yield Citation(found[1], "")
        if items := ITEMS.match(text, found.end()):
            for item in re.findall(ITEM, items[1]):
                yield Citation(found[1], item)


@cache
def numbered(page: Path) -> frozenset[str]:
    """Everything in a page that has a number: sections "2.3", formulas "(9)" at the end of a line, notes "k5"."""
    text = page.read_text(encoding="utf-8")
    sections = re.findall(r"^#+ (\d+(?:\.\d+)?[ab]?)\.? ", text, re.MULTILINE)
    formulas = re.findall(r"(\((?:\d{1,2}|[AB])\))$", text, re.MULTILINE)
    notes = re.findall(r"\*\*([kdt]\d{1,2})\*\*", text)
    return frozenset((*sections, *formulas, *notes))


def find(page: str) -> Path | None:
    return next((place / page for place in PLACES if (place / page).exists()), None)


def dangling(text: str) -> list[str]:
    """What a text cites and nobody can find."""
    wrong = []
    for c in citations(text):
        page = find(c.page)
        if page is None or (c.item and c.item not in numbered(page)):
            wrong.append(f"{c.page} {c.item}".strip())
    return wrong


def bare_formulas(text: str) -> set[str]:
    """Formula numbers without a page; from 5 on, because (1) to (4) are also lengths of vectors and node numbers."""
    return {f"({n})" for n in BARE.findall(text) if 5 <= int(n) <= 25}
