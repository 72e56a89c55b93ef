"""Exit statuses and how an error becomes lines on standard error (input-language.md section 10, messages.md)."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

from spacar.errors import InputError, SpacarError, shown, type_and_text
from spacar_cli.environment import RED, YELLOW, Environment

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from spacar.errors import Message

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
    """Print warnings about what was read."""
    for note in notes:
        tell(environment, "warning", note)


def tell_error(environment: Environment, error: BaseException) -> ExitStatus:
    """Explain an exception on standard error and give the status to end with."""
    if isinstance(error, InputError):
        tell_messages(environment, error.messages, ("error", "warning"))
        return ExitStatus.WRONG
    if isinstance(error, SpacarError):
        tell(environment, "error", str(error))
        return ExitStatus(error.exit_status)
    if isinstance(error, OSError):
        place = f"{error.filename}: " if error.filename else ""
        tell(environment, "error", f"{place}{error.strerror or error}")
        return ExitStatus.WRONG
    if isinstance(error, MemoryError):
        tell(environment, "error", "out of memory; store fewer steps or use fewer elements")
        return ExitStatus.FAILED
    if isinstance(error, ImportError) and any(words in str(cause) for cause in _causes(error) for words in NO_ROOM):
        tell(environment, "error", "out of memory: there is no room for the libraries that are needed")
        return ExitStatus.FAILED
    text = f"internal error: {type_and_text(error)} (--debug shows where; please report it)"
    tell(environment, "error", text)
    return ExitStatus.FAILED


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    """The error, what raised it, and so on: NumPy explains an import that failed in many words of its own."""
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__
