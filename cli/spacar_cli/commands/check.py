"""`spacar check FILE`: read and report, run nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from spacar.errors import InputError, Message, UsageError
from spacar.modes import find_mode
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, ExitStatus, tell_error, tell_messages
from spacar_cli.input_files import PIPED, STANDARD_INPUT, input_file, parse_piped, piped_text

if TYPE_CHECKING:
    from spacar.deck import Deck
    from spacar.mechanism import Mechanism

MOST = 20  # names of degrees of freedom


@words.command("check")
@words.option("mode", "; without it every block is checked.")
@words.option("expand")
@words.option("as_json", ": all messages")
def command(environment: Environment, file: Path, mode: int | None, expand: bool, as_json: bool) -> ExitStatus:
    """Read FILE (or FILE.dat, or standard input for -) and report errors, warnings and information.

    With -v also what moves: degrees of freedom, and over- and under-constraints of the start position by name.
    Nothing is run: user functions (USERSIG, USERINP, USERTRAJ) are listed, not imported. With --expand the plain input
    goes to standard output instead of the counts; it gives the same results.
    """
    from spacar.deck import read_deck
    from spacar.mechanism.user_files import without_functions

    number = None if mode is None else find_mode(mode).number
    if expand and as_json:
        raise UsageError("--expand and --json exclude each other")
    piped = str(file) == STANDARD_INPUT
    source = PIPED if piped else input_file(file)
    text = piped_text(environment) if piped else None
    found = checked_deck(
        lambda: read_deck(source, number) if text is None else parse_piped(text, number), source, number, text
    )
    deck, status = found.deck, ExitStatus.DONE if found.error is None else ExitStatus.WRONG
    messages = found.messages + found.drawing
    if not as_json:
        if found.error is not None:
            tell_error(environment, found.error)
        else:
            tell_messages(environment, found.messages, ("warning", "information"))
        tell_messages(environment, found.drawing, ("warning",))
    severities = [m.severity for m in messages]
    if expand and deck is not None and status is ExitStatus.DONE:
        converted = "" if deck.metre == 1.0 else "; UNITS of the file is converted"
        environment.say(f"% plain statements of {source.name}, numbers in m, kg, s, N, rad{converted}")
        environment.say(deck.to_text().rstrip("\n"))
    elif as_json:
        environment.say_json({"input": str(source), "messages": [asdict(m) for m in messages]})
    else:
        counts = (f"{severities.count(s)} {s}{'s' * (severities.count(s) != 1)}" for s in ("error", "warning"))
        environment.wrote(f"{source}: {', '.join(counts)}")
        if environment.verbose and deck is not None and status is ExitStatus.DONE:
            environment.say(*freedom(without_functions(deck)))
    return status


def freedom(deck: Deck) -> list[str]:
    """Sizes and degrees of freedom of a model, and the diagnosis of its constraints (that of mode 0)."""
    from spacar.calls import frames

    run = frames(0, deck)
    n = run.mechanism.numbering
    list(run)
    names = f": {', '.join(n.q_names[:MOST])}{', ...' * (len(n.q_names) > MOST)}" if n.q_names else ""
    return [
        f"{n.nx} coordinates, {n.ne} deformations, {n.ndof} degree{'s' * (n.ndof != 1)} of freedom{names}",
        *(line for line in run.report.lines if not line.startswith("warning: ")),
    ]


@dataclass(frozen=True)
class CheckedDeck:
    """deck: None when it cannot be read; mechanism, without user functions: None with an `error`."""

    deck: Deck | None
    mechanism: Mechanism | None
    messages: list[Message]
    drawing: list[Message]  # about the settings of pictures
    error: InputError | None


def checked_deck(read: Callable[[], Deck], source: Path, mode: int | None, text: str | None) -> CheckedDeck:
    """Read a deck for a mode (None: all blocks) and build it without its user functions, which are listed.

    source  where it stands, for the settings of pictures beside it;  text  of a file that is not there. Raises
    UsageError for a file that cannot be read.
    """
    from spacar_drawing.settings_check import check_settings

    from spacar.kinematics.lost_stiffness import lost_stiffness
    from spacar.mechanism import build
    from spacar.mechanism.user_files import listed_functions, without_functions

    deck = mechanism = failure = None
    try:
        deck = read()
        messages = [*deck.messages, *listed_functions(deck)]
        # the start geometry of every element
        mechanism = build(without_functions(deck), 1 if mode is None else mode)
        messages += lost_stiffness(deck, mechanism)
    except InputError as error:
        messages, failure = list(error.messages), error
    return CheckedDeck(deck, mechanism, messages, check_settings(source, deck, text), failure)
