"""Where a command reads and writes, and who is looking: the whole command line is testable in one process."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TextIO

RED, YELLOW = "31", "33"


@dataclass(frozen=True)
class Environment:
    """The three streams and the environment variables of one call; `debug` lets unexpected errors through."""

    stdin: TextIO = field(default_factory=lambda: sys.stdin)
    stdout: TextIO = field(default_factory=lambda: sys.stdout)
    stderr: TextIO = field(default_factory=lambda: sys.stderr)
    variables: Mapping[str, str] = field(default_factory=lambda: os.environ)
    debug: bool = False

    @property
    def output_is_terminal(self) -> bool:
        return self.stdout.isatty()

    @property
    def error_is_terminal(self) -> bool:
        return self.stderr.isatty()

    def paint(self, text: str, colour: str) -> str:
        """`text` in a colour when standard error is a terminal and NO_COLOR (no-color.org) does not refuse."""
        refused = self.variables.get("NO_COLOR") or self.variables.get("TERM") == "dumb"
        return text if refused or not self.error_is_terminal else f"\x1b[{colour}m{text}\x1b[0m"

    def say(self, text: str) -> None:
        """One line for the user of the result: standard output."""
        print(text, file=self.stdout, flush=True)

    def tell(self, text: str) -> None:
        """One line about the work itself: standard error."""
        print(text, file=self.stderr, flush=True)
