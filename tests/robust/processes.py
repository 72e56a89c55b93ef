"""Processes of the installed command, with a hand on when they are stopped."""

import atexit
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from tests.examples import DATA

SPACAR = Path(sys.executable).with_name("spacar")
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
LONG = ("--time", "1000", "--steps", "1000000")  # far longer than any test waits


def model(folder, name="crank"):
    shutil.copy(DATA / f"{name}.dat", folder)
    return folder


def start(folder, *words, **options):
    """A process that may be interrupted (tests in the background inherit that SIGINT is ignored)."""
    settings = {"cwd": folder, "env": ENVIRONMENT, "stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE,
                "stderr": subprocess.PIPE, "text": True,
                "preexec_fn": lambda: signal.signal(signal.SIGINT, signal.default_int_handler)}  # fmt: skip
    process = subprocess.Popen([str(SPACAR), *map(str, words)], **settings | options)
    atexit.register(process.kill)  # when a test fails before its end
    return process


def done(folder, *words, **options):
    """Status, standard output and standard error of a process that runs to its end."""
    process = start(folder, *words, **options)
    out, err = process.communicate(timeout=120)
    return process.returncode, out, err


def shell(folder, line):
    """A line of the shell in which `spacar` stands for the command."""
    text = line.replace("spacar", str(SPACAR), 1)
    finished = subprocess.run(["bash", "-c", text], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True,
                              timeout=120)  # fmt: skip
    return finished.returncode, finished.stdout, finished.stderr


def until(condition, process, seconds=300.0):
    """Wait until `condition` holds; an error when the process ends before."""
    deadline = time.monotonic() + seconds
    while not condition():
        if process.poll() is not None or time.monotonic() > deadline:
            raise AssertionError(process.communicate())
        time.sleep(0.01)


def grows(path, least=100_000):
    return lambda: path.exists() and path.stat().st_size > least
