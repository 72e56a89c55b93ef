"""The walk of one run in the developer guide: a newcomer meets few files, and the picture shows those of today."""

from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path

import pytest

from spacar.compiled.library import unavailable

HOUSE = Path(__file__).resolve().parents[2]


@pytest.mark.skipif(unavailable() is not None, reason="the walk is that of a run in C")
@pytest.mark.parametrize(("words", "most"), [("1 crank", 70), ("7 plbeam5", 80)])
def test_a_run_passes_through_few_files(words, most, tmp_path, monkeypatch):
    spec = importlib.util.spec_from_file_location("walk", HOUSE / "docs" / "walk.py")
    walk = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(walk)
    mode, name = words.split()
    shutil.copy(HOUSE / "data" / f"{name}.dat", tmp_path)
    monkeypatch.chdir(tmp_path)
    files = walk.files_of_a_run([mode, name, "--quiet"])
    assert (tmp_path / f"{name}.sbd").is_file()
    assert 40 < len(files) <= most
    if name == "crank":
        image = pytest.importorskip("PIL.Image")
        with image.open(HOUSE / "docs" / "pictures" / "walk.png") as picture:
            assert picture.text["Description"].splitlines() == files, "python docs/figures.py docs/pictures walk.png"
