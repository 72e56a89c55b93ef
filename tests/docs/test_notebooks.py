"""The notebooks of the tutorial: every cell runs and prints what is stored; pictures are there and small."""

from pathlib import Path

import pytest

from .documents import in_folder, same_line
from .notebooks import Notebook, text_of

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
LARGEST = 250_000  # bytes of a file with its outputs


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_a_notebook_runs_and_shows_what_is_stored(path, tmp_path):
    notebook = Notebook(path)
    with in_folder(tmp_path):
        made = notebook.execute()
    assert not list(tmp_path.iterdir())
    for k, (cell, found) in enumerate(zip(notebook.code, made, strict=True), 1):
        wanted, got = text_of(cell["outputs"]), text_of(found)
        pairs = zip(wanted, got, strict=False)
        same = len(wanted) == len(got) and all(same_line(a, b) or "gif of" in a for a, b in pairs)
        assert same, f"cell {k} of {path.name}: run python -m tests.docs.notebooks {path}\n{got}"
        kinds = [[*output.get("data", ())] for output in found]
        assert kinds == [[*output.get("data", ())] for output in cell["outputs"]], f"cell {k} of {path.name}"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_a_notebook_is_small_and_in_the_format(path):
    """Version 4.5: every cell has an id of its own, outputs have the fields of their type."""
    content = Notebook(path).content
    assert path.stat().st_size < LARGEST
    assert (content["nbformat"], content["nbformat_minor"]) == (4, 5)
    ids = [cell["id"] for cell in content["cells"]]
    assert len(set(ids)) == len(ids)
    for cell in Notebook(path).code:
        for output in cell["outputs"]:
            fields = {"stream": {"name", "text"}, "execute_result": {"data", "metadata", "execution_count"}}
            assert set(output) == {"output_type", *fields[output["output_type"]]}


def test_every_notebook_is_on_the_page():
    page = (FOLDER.parent / "python.md").read_text(encoding="utf-8")
    assert NOTEBOOKS
    assert all(f"(notebooks/{path.name})" in page for path in NOTEBOOKS)
