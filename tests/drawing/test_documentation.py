"""Every option of the drawing commands is in docs/drawing.md, and every picture there is made by docs/figures.py."""

import re
from importlib import import_module
from pathlib import Path

import click
import pytest

from tests.docs.documents import module_of

DOCS = Path(__file__).parents[2] / "docs"
TEXT = (DOCS / "drawing.md").read_text("utf-8")


@pytest.mark.parametrize("name", ["draw", "visual", "plot", "report", "view"])
def test_every_option_is_documented(name):
    command = import_module(f"spacar_cli.commands.{name}").command
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            assert parameter.help, parameter.name
            for flag in (*parameter.opts, *parameter.secondary_opts):
                assert f"`{flag}" in TEXT or f" {flag}" in TEXT, flag


def test_every_setting_is_documented():
    source = (DOCS.parent / "cli" / "spacar_drawing" / "settings.py").read_text("utf-8")
    for word in set(re.findall(r'"([A-Z]{5,})"', source)) - {"FACECOLOUR", "COLOUR", "TRUSSPROPS"}:
        assert word in TEXT, word


def test_pictures_exist_and_are_made_by_the_script():
    figures = module_of(DOCS / "figures.py")
    shown = set(re.findall(r"\(pictures/([\w.-]+)\)", TEXT))
    assert shown <= set(figures.FIGURES) | set(figures.DRAWN)
    assert {p.name for p in (DOCS / "pictures").iterdir()} == figures.pictures()
    models = {run.split()[1] for run, _ in figures.FIGURES.values()} - {"square"}
    assert all((figures.DATA / f"{m}.dat").is_file() for m in models)


def test_the_python_example_runs(tmp_path, monkeypatch):
    code = re.search(r"## From Python\n\n```python\n(.*?)```", TEXT, re.S).group(1)
    monkeypatch.chdir(tmp_path)
    exec(code.replace("data/crank.dat", str(DOCS.parent / "data" / "crank.dat")), {})
    assert (tmp_path / "crank.png").is_file()
