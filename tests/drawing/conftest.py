"""A folder with results of a few examples, made once, and a way to call the command line in process."""

import shutil

import pytest

from tests.command_line import call
from tests.examples import DATA

RUNS = {
    "crank": 1, "trike3v": 0, "plbeam5free": 7, "lateral4": 8, "trike2": 0, "plbeam5": 7, "fourbar": 4, "robotinv": 2
}


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """Results of RUNS; read only."""
    folder = tmp_path_factory.mktemp("results")
    for name, mode in RUNS.items():
        shutil.copy(DATA / f"{name}.dat", folder)
        assert call(mode, folder / name, "--quiet").status == 0
    return folder


@pytest.fixture
def results(made, tmp_path):
    """A copy of the results that a test may change."""
    for file in made.iterdir():
        shutil.copy2(file, tmp_path)
    return tmp_path
