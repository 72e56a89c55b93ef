"""Where a command reads and writes, and who is looking: the whole command line is testable in one process.

Ctrl-C that is not lost.

An exception cannot leave a destructor or the callback of a weak reference: Python prints a traceback and goes on. A
Ctrl-C that falls into one, which happens in large garbage collections, would be ignored. It is repeated soon after.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, TextIO

from spacar.errors import escaped

SOON = 0.01  # seconds: such callbacks take microseconds


@contextmanager
def lasting() -> Iterator[None]:
    """Repeat interruptions that callbacks of the interpreter swallow."""
    before = sys.unraisablehook

    def again(unraisable: Any) -> None:
        if unraisable.exc_type is not KeyboardInterrupt:
            before(unraisable)
            return
        import _thread
        import threading

        timer = threading.Timer(SOON, _thread.interrupt_main)
        timer.daemon = True
        timer.start()

    sys.unraisablehook = again
    try:
        yield
    finally:
        sys.unraisablehook = before


RED, YELLOW = "31", "33"


@dataclass(frozen=True)
class Environment:
    """The three streams and the environment variables of one call, and how much is told.

    `debug` lets unexpected errors through; `asked` has "quiet" (-q) and "verbose" (-v) once the command line is read;
    `told` has the messages so far: each is told once.
    """

    stdin: TextIO = field(default_factory=lambda: sys.stdin)
    stdout: TextIO = field(default_factory=lambda: sys.stdout)
    stderr: TextIO = field(default_factory=lambda: sys.stderr)
    variables: Mapping[str, str] = field(default_factory=lambda: os.environ)
    debug: bool = False
    asked: set[str] = field(default_factory=set)
    told: set[str] = field(default_factory=set)

    @property
    def quiet(self) -> bool:
        return "quiet" in self.asked

    @property
    def verbose(self) -> bool:
        return "verbose" in self.asked

    @property
    def output_is_terminal(self) -> bool:
        return self.stdout.isatty()

    @property
    def error_is_terminal(self) -> bool:
        return self.stderr.isatty()

    @property
    def shows_progress(self) -> bool:
        """Bars and counters: on terminals, unless quiet."""
        return self.error_is_terminal and not self.quiet

    def paint(self, text: str, colour: str) -> str:
        """`text` in a colour when standard error is a terminal and NO_COLOR (no-color.org) does not refuse."""
        refused = self.variables.get("NO_COLOR") or self.variables.get("TERM") == "dumb"
        return text if refused or not self.error_is_terminal else f"\x1b[{colour}m{text}\x1b[0m"

    def say(self, text: str) -> None:
        """One line for the user of the result: standard output."""
        print(escaped(text), file=self.stdout, flush=True)

    def wrote(self, text: object) -> None:
        """A file that was written, or a summary: a line of standard output, unless quiet."""
        if not self.quiet:
            self.say(str(text))

    def tell(self, text: str) -> None:
        """One line about the work itself: standard error. Work goes on when nobody can be told."""
        with contextlib.suppress(OSError):
            print(text, file=self.stderr, flush=True)


def open_missing_streams() -> None:
    """A process may be started without standard streams (`2>&-`): they become the null device.

    Otherwise the next file that is opened would get the number of the stream, and what is meant for the screen would
    be written into it. What the encoding of the screen does not have is written as an escape.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115 (for as long as the process)
        elif mode == "w" and isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def give_up_output() -> None:
    """Nothing more can be written to standard output (a full disk): what waits there is dropped."""
    with contextlib.suppress(OSError, ValueError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, sys.stdout.fileno())
        os.close(null)
