"""Real processes of the installed command, and one process that runs many command lines."""

import json
import os
import subprocess
import sys
from pathlib import Path

from tests.command_line import Outcome, call

SPACAR = Path(sys.executable).with_name("spacar")
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1"}

MANY = """
import json, sys
from tests.command_line import call
json.dump([call(*words) for words in json.load(sys.stdin)], sys.stdout)
"""


def spacar(*words: object, folder: Path, **variables: str) -> Outcome:
    """One process."""
    done = subprocess.run(
        [str(SPACAR), *map(str, words)], cwd=folder, capture_output=True, text=True, stdin=subprocess.DEVNULL,
        timeout=120, env=ENVIRONMENT | variables,
    )  # fmt: skip
    return Outcome(done.returncode, done.stdout, done.stderr)


def prepare(folder: Path, name: str = "crank", mode: int = 1) -> None:
    """A run in this process, for a test that is about what comes after it."""
    call.done(mode, folder / name)


def many(lines: list[list[str]], folder: Path) -> list[Outcome]:
    """All command lines in one process, each with its own streams."""
    done = subprocess.run(
        [sys.executable, "-c", MANY], cwd=folder, input=json.dumps(lines), capture_output=True, text=True,
        timeout=120, env=ENVIRONMENT,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return [Outcome(*row) for row in json.loads(done.stdout)]
