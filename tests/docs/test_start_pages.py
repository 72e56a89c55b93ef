"""The four start pages: each from an empty folder to a picture, as it says."""

from pathlib import Path

import pytest

from .documents import run_document

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = sorted(DOCS.glob("start-*.md"))


def test_there_is_a_page_for_each_kind_of_user() -> None:
    assert [p.stem for p in PAGES] == ["start-control", "start-flexure", "start-python", "start-spacar"]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_a_start_page_leads_to_a_picture(page, tmp_path) -> None:
    count = run_document(page, tmp_path)
    assert count.commands >= 2
    assert list(tmp_path.glob("*.png"))
