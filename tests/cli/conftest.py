"""The command line inside the test process: streams that remember, terminals or not."""

from __future__ import annotations

import io
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest
from spacar_cli.environment import Environment
from spacar_cli.main import main

DATA = Path(__file__).resolve().parents[2] / "data"


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@dataclass(frozen=True)
class Outcome:
    status: int
    out: str
    err: str


@pytest.fixture
def call(tmp_path, monkeypatch):
    """`call("1", "crank", terminal=True, NO_COLOR="1")` in an empty folder that has crank.dat."""
    shutil.copy(DATA / "crank.dat", tmp_path)
    monkeypatch.chdir(tmp_path)

    def run(*words: object, terminal: bool = False, **variables: str) -> Outcome:
        stream = Terminal if terminal else io.StringIO
        env = Environment(io.StringIO(), stream(), stream(), variables)
        status = main([str(w) for w in words], env)
        return Outcome(status, env.stdout.getvalue(), env.stderr.getvalue())

    return run
