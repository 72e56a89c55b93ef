"""The command line in the process of a test: streams that remember, terminals or not."""

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


class CommandLine:
    """`call("1", "crank", terminal=True, NO_COLOR="1")`: one command line with its own streams and variables."""

    def __init__(self, *first: str) -> None:
        self.first = first

    def __call__(self, *words: object, stdin: str = "", terminal: bool = False, **variables: str) -> Outcome:
        stream = Terminal if terminal else io.StringIO
        env = Environment(io.StringIO(stdin), stream(), stream(), variables)
        return Outcome(main([str(w) for w in (*self.first, *words)], env), env.stdout.getvalue(), env.stderr.getvalue())

    def done(self, *words: object, **given: object) -> Outcome:
        """A command that succeeds."""
        outcome = self(*words, **given)
        assert outcome.status == 0, (words, outcome.err)
        return outcome

    def refused(self, *words: object, status: int = 2, **given: object) -> str:
        """What a command that fails says on standard error; 2: wrong use or input, 1: the analysis."""
        outcome = self(*words, **given)
        assert outcome.status == status, (words, outcome)
        assert "Traceback" not in outcome.err
        assert status == 1 or words[0] == "check" or outcome.out == ""
        return outcome.err


call = CommandLine()
