"""The command line in this process, in an empty folder that has the example models."""

import shutil

import pytest

from tests import command_line
from tests.examples import DATA


@pytest.fixture
def call(tmp_path, monkeypatch):
    """`call("sweep", "crank", ...)` with copies of the examples."""
    for path in DATA.glob("*.dat"):
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    return command_line.call


@pytest.fixture
def deck():
    """`deck("crank", 1)`: an example model."""
    from spacar.deck import read_deck

    return lambda name, mode: read_deck(DATA / f"{name}.dat", mode)
