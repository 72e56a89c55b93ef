"""Errors a caller can act on. Every one carries a stable short name (`code`) that the log prints in brackets."""

from dataclasses import dataclass, field
from typing import Any

LONGEST_LINE = 1000
# What code of a user may raise; a Ctrl-C passes. To readers each is an exception like others.
BY_USERS: tuple[type[Exception], ...] = (Exception, SystemExit, GeneratorExit)  # type: ignore[assignment]


def type_and_text(error: BaseException) -> str:
    """What an exception is that is not ours, in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split()).removesuffix(":")


def shown(text: str) -> str:
    """Text as it may stand on a terminal and in a log: control characters, and other signs that are not printed, are
    escaped; of a line that is too long the beginning and the end are kept."""
    if len(text) <= LONGEST_LINE and text.isprintable():
        return text
    return "\n".join(map(_line, escaped(text).split("\n")))


def escaped(text: str) -> str:
    """The text with control characters and other signs that are not printed as escapes; ends of lines and tabs stay."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in "\n\t" else ascii(c)[1:-1] for c in text)


def _line(line: str) -> str:
    if len(line) <= LONGEST_LINE:
        return line
    keep = LONGEST_LINE // 2 - 30
    return f"{line[:keep]} ... ({len(line) - 2 * keep} characters left out) ... {line[-keep:]}"


@dataclass(frozen=True, slots=True)
class Message:
    """One line about the input: `severity: file:line: KEYWORD: text` (severity error, warning or information)."""

    severity: str
    file: str
    line: int | None
    keyword: str
    text: str
    code: str = "input"

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        subject = f"{self.keyword}: " if self.keyword else ""
        return shown(f"{self.severity}: {place}: {subject}{self.text}")


class SpacarError(Exception):
    """Base of all errors that are reported without a traceback. `exit_status` follows the CLI contract."""

    exit_status = 1
    code = "failure"

    def __init__(self, text: str, code: str = "", **data: Any) -> None:
        super().__init__(shown(text))
        self.code = code or self.code
        self.data = data


class UsageError(SpacarError):
    """The call is wrong: unknown mode, missing file, unknown variable."""

    exit_status = 2
    code = "usage"


class InputError(SpacarError):
    """The input file is wrong; `messages` holds every error (and warning) that was found."""

    exit_status = 2
    code = "input"

    def __init__(self, messages: list[Message]) -> None:
        super().__init__("\n".join(str(m) for m in messages if m.severity == "error"))
        self.messages = messages


class AnalysisError(SpacarError):
    """The analysis failed; the text says what, where, at which step or time, and what to try."""


@dataclass(slots=True)
class Report:
    """Warnings and pieces of information that a run collects for its log, each said once."""

    lines: list[str] = field(default_factory=list)
    _said: set[str] = field(default_factory=set, init=False, repr=False, compare=False)

    def add(self, line: str) -> None:
        if len(self._said) != len(self.lines):  # somebody else has written
            self._said = set(self.lines)
        if line not in self._said:
            self.lines.append(line)
            self._said.add(line)
