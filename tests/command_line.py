"""The command line in the process of a test: streams that remember, terminals or not."""

from __future__ import annotations

import io
from typing import NamedTuple

from spacar_cli.environment import Environment
from spacar_cli.main import main


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


class Outcome(NamedTuple):
    status: int
    out: str
    err: str


def call(*words: object, stdin: str = "", terminal: bool = False, **variables: str) -> Outcome:
    """`call("1", "crank", terminal=True, NO_COLOR="1")`: one command line with its own streams and variables."""
    stream = Terminal if terminal else io.StringIO
    env = Environment(io.StringIO(stdin), stream(), stream(), variables)
    return Outcome(main([str(w) for w in words], env), env.stdout.getvalue(), env.stderr.getvalue())
