"""The chapter on flexures: every command and number in it is run."""

import shutil
from pathlib import Path

from .documents import run_document

HOUSE = Path(__file__).resolve().parents[2]


def test_flexures_page(tmp_path):
    for name in ("leafguide.dat", "crosshingew.dat"):
        shutil.copy(HOUSE / "data" / name, tmp_path)
    count = run_document(HOUSE / "docs" / "flexures.md", tmp_path)
    assert count.commands >= 10
    assert count.numbers >= 60
