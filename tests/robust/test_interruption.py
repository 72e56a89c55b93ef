"""Ctrl-C that falls into a destructor is not lost."""

import subprocess
import sys

SCRIPT = """
import signal, sys, time
from spacar_cli.environment import lasting

class Swallows:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)  # Ctrl-C at this very moment
        time.sleep(0)

signal.signal(signal.SIGINT, signal.default_int_handler)
with lasting():
    try:
        Swallows()
        for _ in range(1000):
            time.sleep(0.01)
        print("went on")
    except KeyboardInterrupt:
        print("interrupted")
"""


def test_an_interruption_in_a_destructor_is_repeated() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=False, timeout=60)
    assert done.stdout == "interrupted\n"
    assert done.stderr == ""


def test_other_errors_of_destructors_are_shown() -> None:
    text = SCRIPT.replace("signal.raise_signal(signal.SIGINT)", "1 / 0").replace("range(1000)", "range(2)")
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=False, timeout=60)
    assert done.stdout == "went on\n"
    assert "ZeroDivisionError" in done.stderr
