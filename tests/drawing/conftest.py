"""A folder with results of a few examples, made once, and a way to call the command line in process."""

from __future__ import annotations

import io
import shutil
from dataclasses import dataclass

import pytest
from spacar_cli.environment import Environment
from spacar_cli.main import main

from .models import DATA

RUNS = {
    "crank": 1, "trike3v": 0, "plbeam5free": 7, "lateral4": 8, "trike2": 0, "plbeam5": 7, "fourbar": 4, "robotinv": 2
}


@dataclass(frozen=True)
class Done:
    """What one command line left behind."""

    status: int
    out: str
    err: str


def call(*arguments: object, terminal: bool = False) -> Done:
    out, err = io.StringIO(), io.StringIO()
    if terminal:
        err.isatty = lambda: True  # type: ignore[method-assign]
    status = main([str(a) for a in arguments], Environment(io.StringIO(), out, err, {}))
    return Done(status, out.getvalue(), err.getvalue())


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
