"""Functions for worker processes, importable there."""

import os
import signal
import time
from pathlib import Path


def double_or_die(case: int) -> int:
    """Twice the number; the process is killed at 3."""
    if case == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return 2 * case


def note_and_wait(path: str) -> None:
    """Write the number of this process, then take far too long."""
    with Path(path).open("a") as file:
        file.write(f"{os.getpid()}\n")
    time.sleep(60)
