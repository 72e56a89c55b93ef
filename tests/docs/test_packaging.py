"""What a user and an archive see of the package: one version, types, classifiers, a citation that is well formed."""

import doctest
import re
from importlib import metadata
from importlib.resources import files
from pathlib import Path

import pytest

import spacar

HOUSE = Path(__file__).resolve().parents[2]
CITATION = (HOUSE / "CITATION.cff").read_text(encoding="utf-8")


def test_the_version_stands_in_one_place():
    """`spacar/__init__.py` has it; the build reads it there, and the citation, which no tool makes, must agree."""
    project = (HOUSE / "pyproject.toml").read_text(encoding="utf-8")
    assert not re.search(r'^version = "', project, re.MULTILINE)
    assert re.search(r'^path = "spacar/__init__.py"$', project, re.MULTILINE)
    assert re.findall(r"^version: (\S+)$", CITATION, re.MULTILINE) == [spacar.__version__]
    assert metadata.version("spacar") == spacar.__version__


def test_the_changelog_has_this_version_and_what_comes_next():
    heads = re.findall(r"^## (\S+)", (HOUSE / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert heads[0] == "Unreleased"
    assert heads[1] == spacar.__version__


@pytest.mark.parametrize("package", ["spacar", "spacar_formats", "spacar_cli", "spacar_drawing"])
def test_packages_are_typed(package):
    assert (files(package) / "py.typed").is_file()


def test_the_citation_has_what_the_format_demands():
    """Citation File Format 1.2.0: these five keys are required."""
    keys = set(re.findall(r"^([a-z-]+):", CITATION, re.MULTILINE))
    assert {"cff-version", "message", "title", "authors", "type"} <= keys


# Every public name has a docstring with an example that runs beside the example models.
@pytest.mark.parametrize("name", spacar.__all__)
def test_the_example_of_a_public_name(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HOUSE)
    text = getattr(spacar, name).__doc__
    test = doctest.DocTestParser().get_doctest(text, {}, name, None, 0)
    assert test.examples, f"{name} has no example"
    assert doctest.DocTestRunner().run(test).failed == 0
