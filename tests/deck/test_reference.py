"""docs/keywords.md is the page that the table makes, and the table is complete."""

import re
from pathlib import Path

import pytest

from spacar.deck.keyword_table import KEYWORDS
from spacar.deck.reference import markdown
from spacar.deck.table_types import BlockKind

PAGE = Path(__file__).parents[2] / "docs" / "keywords.md"
LANGUAGE = (Path(__file__).parents[2] / "docs" / "reference" / "input-language.md").read_text(encoding="utf-8")
# block -> sections of the reference that say which keywords it has
SECTIONS = {
    BlockKind.KINEMATICS: ("3", "4.1", "4.2"), BlockKind.DYNAMICS: ("5.1", "5.2", "5.3", "5.4", "5.5", "5.6"),
    BlockKind.TRAJECTORY: ("6", "7"), BlockKind.LINEARIZATION: ("8",), BlockKind.SIMULATION: ("9",),
}  # fmt: skip


def documented(section: str) -> set[str]:
    """Keywords of a section: words in bold, and the list of section 9."""
    text = re.split(rf"^#+ {re.escape(section)}\.? .*$", LANGUAGE, flags=re.MULTILINE)[1]
    text = re.split(r"^#", text, flags=re.MULTILINE)[0]
    cells = re.findall(r"\*\*([A-Z, ]+)\*\*", text)
    if section == "9":
        cells.append(text.split(" as in ")[0])
    return {word for cell in cells for word in re.findall(r"[A-Z]+", cell)}


def test_page_is_up_to_date() -> None:
    assert PAGE.read_text(encoding="utf-8") == markdown(), "run: python -m spacar.deck.reference > docs/keywords.md"


@pytest.mark.parametrize("block", list(BlockKind), ids=lambda b: b.name)
def test_all_keywords_are_there(block: BlockKind) -> None:
    """Every keyword that the reference documents is in the table; the table may have more (new elements, say)."""
    wanted = set().union(*map(documented, SECTIONS[block]))
    assert len(wanted) >= 8
    assert wanted <= {name for name, b in KEYWORDS if b is block}


@pytest.mark.parametrize("keyword", list(KEYWORDS.values()), ids=lambda k: f"{k.block.name}-{k.name}")
def test_variants_are_consistent(keyword) -> None:
    for variant in keyword.variants:
        assert variant.counts == tuple(sorted(variant.counts))
        assert variant.counts[-1] == len(variant.parameters)
        assert all(p.meaning and p.kind in ("integer", "real", "name") for p in variant.parameters)
    assert keyword.help
