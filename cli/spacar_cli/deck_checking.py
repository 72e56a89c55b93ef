"""What `spacar check` and `spacar edit` say about a file: messages of reading, building and drawing; runs nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from spacar.errors import InputError, Message

if TYPE_CHECKING:
    from spacar.deck import Deck
    from spacar.mechanism import Mechanism


@dataclass(frozen=True)
class CheckedDeck:
    """deck: None when it cannot be read; mechanism, without user functions: None with an `error`."""

    deck: Deck | None = None
    mechanism: Mechanism | None = None
    messages: list[Message] = field(default_factory=list)
    drawing: list[Message] = field(default_factory=list)  # about the settings of pictures
    error: InputError | None = None


def checked_deck(read: Callable[[], Deck], source: Path, mode: int | None, text: str | None = None) -> CheckedDeck:
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
