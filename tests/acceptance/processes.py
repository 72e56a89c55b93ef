"""Real processes of the installed command, and one process that runs many command lines."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from spacar_cli.environment import Environment
from spacar_cli.main import main

DATA = Path(__file__).resolve().parents[2] / "data"
SPACAR = Path(sys.executable).with_name("spacar")
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1"}

MANY = """
import io, json, sys
from spacar_cli.environment import Environment
from spacar_cli.main import main
done = []
for words in json.load(sys.stdin):
    out, err = io.StringIO(), io.StringIO()
    status = main(words, Environment(io.StringIO(), out, err, {}))
    done.append([status, out.getvalue(), err.getvalue()])
json.dump(done, sys.stdout)
"""


@dataclass(frozen=True)
class Done:
    """How a command line ended."""

    status: int
    out: str
    err: str


def spacar(*words: object, folder: Path, **variables: str) -> Done:
    """One process."""
    done = subprocess.run(
        [str(SPACAR), *map(str, words)], cwd=folder, capture_output=True, text=True, stdin=subprocess.DEVNULL,
        timeout=120, env=ENVIRONMENT | variables,
    )  # fmt: skip
    return Done(done.returncode, done.stdout, done.stderr)


def prepare(folder: Path, name: str = "crank", mode: int = 1) -> None:
    """A run in this process, for a test that is about what comes after it."""
    streams = Environment(io.StringIO(), io.StringIO(), io.StringIO(), {})
    assert main([str(mode), str(folder / name)], streams) == 0, streams.stderr.getvalue()


def many(lines: list[list[str]], folder: Path) -> list[Done]:
    """All command lines in one process, each with its own streams."""
    done = subprocess.run(
        [sys.executable, "-c", MANY], cwd=folder, input=json.dumps(lines), capture_output=True, text=True,
        timeout=120, env=ENVIRONMENT,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return [Done(*row) for row in json.loads(done.stdout)]
