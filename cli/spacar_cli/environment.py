"""Where a command reads and writes, and who is looking: the whole command line is testable in one process.

An error becomes lines on standard error and an exit status (input-language.md section 10, messages.md). An exception
cannot leave a destructor or the callback of a weak reference: Python prints a traceback and goes on. A Ctrl-C that
falls into one, which happens in large garbage collections, would be ignored. It is repeated soon after. Compiled code
of a library may turn a Ctrl-C into an error of its own (pybind11 does): an unexpected error behind one is an
interruption.
"""

import contextlib
import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import Any, TextIO

from click import Abort

from spacar.errors import InputError, Message, SpacarError, escaped, shown, type_and_text

SOON = 0.01  # seconds: such callbacks take microseconds


@contextmanager
def lasting() -> Iterator[Callable[[], bool]]:
    """Repeat interruptions that callbacks of the interpreter swallow; yields whether there was one."""
    before, handler = sys.unraisablehook, signal.getsignal(signal.SIGINT)
    interrupted = False

    def interrupt(number: int, frame: Any) -> None:
        nonlocal interrupted
        interrupted = True
        assert callable(handler)
        handler(number, frame)

    def again(unraisable: Any) -> None:
        if unraisable.exc_type is not KeyboardInterrupt:
            before(unraisable)
            return
        import _thread

        timer = threading.Timer(SOON, _thread.interrupt_main)
        timer.daemon = True
        timer.start()

    sys.unraisablehook = again
    ours = callable(handler) and threading.current_thread() is threading.main_thread()
    if ours:
        signal.signal(signal.SIGINT, interrupt)
    try:
        yield lambda: interrupted
    finally:
        sys.unraisablehook = before
        if ours:
            signal.signal(signal.SIGINT, handler)


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
    def shows_progress(self) -> bool:
        """Bars and counters: on terminals, unless quiet."""
        return self.stderr.isatty() and not self.quiet

    def paint(self, text: str, colour: str) -> str:
        """`text` in a colour when standard error is a terminal and NO_COLOR (no-color.org) does not refuse."""
        refused = self.variables.get("NO_COLOR") or self.variables.get("TERM") == "dumb"
        return text if refused or not self.stderr.isatty() else f"\x1b[{colour}m{text}\x1b[0m"

    def say(self, *lines: str) -> None:
        """Lines for the user of the result: standard output."""
        for line in lines:
            print(escaped(line), file=self.stdout, flush=True)

    def say_json(self, record: object) -> None:
        import json

        self.say(json.dumps(record))

    def wrote(self, *lines: object) -> None:
        """Files that were written, or a summary: lines of standard output, unless quiet."""
        if not self.quiet:
            self.say(*map(str, lines))

    def progress(self, text: str) -> None:
        """A line that the next one replaces, where bars are shown; "" takes it away."""
        if self.shows_progress:
            print(f"\r\x1b[K{text}", end="", file=self.stderr, flush=True)

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


MOST_LINES = 20
NO_ROOM = ("failed to map", "Cannot allocate", "cannot allocate", "cannot create shared object")


class ExitStatus(IntEnum):
    """What a process says when it ends."""

    DONE = 0
    FAILED = 1  # the analysis failed
    WRONG = 2  # wrong usage or bad input: nothing was analysed
    INTERRUPTED = 130


def tell_messages(environment: Environment, messages: Sequence[Message], severities: tuple[str, ...]) -> None:
    """Print the messages of these severities in this order, at most 20, then how many are left."""
    chosen = [m for severity in severities for m in messages if m.severity == severity]
    for message in chosen[:MOST_LINES]:
        tell(environment, message.severity, str(message).removeprefix(f"{message.severity}: "))
    if len(chosen) > MOST_LINES:
        environment.tell(f"... and {len(chosen) - MOST_LINES} more")


def tell(environment: Environment, severity: str, text: str) -> None:
    """`severity: text`, once; further lines of a long explanation are indented below the first. Quiet: errors only."""
    if severity != "error" and (environment.quiet or f"{severity}: {text}" in environment.told):
        return
    environment.told.add(f"{severity}: {text}")
    first, *rest = shown(text).splitlines() or [""]
    colour = {"error": RED, "warning": YELLOW}.get(severity)
    label = environment.paint(f"{severity}:", colour) if colour else f"{severity}:"
    environment.tell("\n".join([f"{label} {first}", *(f"  {line}" for line in rest)]))


def tell_notes(environment: Environment, notes: Iterable[str]) -> None:
    for note in notes:
        tell(environment, "warning", note)


def told_path(environment: Environment, name: str, kind: str | None = None) -> Path:
    """Where a result file is; its warnings are told. Raises UsageError."""
    from spacar_formats.locate import notes, open_result

    with open_result(name, kind) as file:
        tell_notes(environment, notes(file))
        return file.path


def _chain(error: BaseException) -> list[BaseException]:
    """An error and its causes: NumPy explains an import that failed in many words of its own."""
    chain = [error]
    while (cause := chain[-1].__cause__ or chain[-1].__context__) and cause not in chain:
        chain.append(cause)
    return chain


def tell_error(environment: Environment, error: BaseException) -> ExitStatus:
    """Explain an exception on standard error and give the status to end with."""
    if isinstance(error, InputError):
        tell_messages(environment, error.messages, ("error", "warning"))
        return ExitStatus.WRONG
    status = ExitStatus.FAILED
    if isinstance(error, SpacarError):
        text, status = str(error), ExitStatus(error.exit_status)
    elif isinstance(error, OSError):
        place = f"{error.filename}: " if error.filename else ""
        text, status = f"{place}{error.strerror or error}", ExitStatus.WRONG
    elif isinstance(error, KeyboardInterrupt | Abort):
        text, status = "interrupted", ExitStatus.INTERRUPTED
    elif isinstance(error, MemoryError):
        text = "out of memory; store fewer steps or use fewer elements"
    elif isinstance(error, ImportError) and any(words in str(e) for e in _chain(error) for words in NO_ROOM):
        text = "out of memory: there is no room for the libraries that are needed"
    else:
        text = f"internal error: {type_and_text(error)} (--debug shows where; please report it)"
    tell(environment, "error", text)
    return status
