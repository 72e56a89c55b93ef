"""The command line in this process, in an empty folder that has the example models."""

from __future__ import annotations

import io
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest
from spacar_cli.environment import Environment
from spacar_cli.main import main

DATA = Path(__file__).resolve().parents[2] / "data"


@dataclass(frozen=True)
class Outcome:
    status: int
    out: str
    err: str


@pytest.fixture
def call(tmp_path, monkeypatch):
    """`call("sweep", "crank", ...)` with copies of the examples."""
    for path in DATA.glob("*.dat"):
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)

    def run(*words: object) -> Outcome:
        env = Environment(io.StringIO(), io.StringIO(), io.StringIO(), {})
        status = main([str(w) for w in words], env)
        return Outcome(status, env.stdout.getvalue(), env.stderr.getvalue())

    return run


@pytest.fixture
def deck():
    """`deck("crank", 1)`: an example model."""
    from spacar.deck import read_deck

    return lambda name, mode: read_deck(DATA / f"{name}.dat", mode)
