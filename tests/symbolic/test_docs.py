"""The tutorial and the docstrings say what happens."""

import doctest
import importlib
import pkgutil
from pathlib import Path

import pytest

import spacar.symbolic

DOCS = Path(__file__).parents[2] / "docs" / "symbolic"
MODULES = [m.name for m in pkgutil.walk_packages(spacar.symbolic.__path__, "spacar.symbolic.")]


def test_tutorial():
    result = doctest.testfile(str(DOCS / "tutorial.md"), module_relative=False)
    assert result.attempted > 20
    assert result.failed == 0


@pytest.mark.parametrize("name", MODULES)
def test_docstrings(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_figures_of_the_tutorial_exist():
    text = (DOCS / "tutorial.md").read_text()
    for name in ("q1", "q4", "tip1", "tip2"):
        assert f"({name}.png)" in text
        assert (DOCS / f"{name}.png").stat().st_size > 5000
