"""One door for models: a path, a Deck or a Model becomes a checked deck; every call that takes a model goes through."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from spacar.deck import Deck, read_deck
from spacar.errors import UsageError

if TYPE_CHECKING:
    from spacar.deck.mode_blocks import Purpose
    from spacar.deck.model import Model

Source: TypeAlias = "str | os.PathLike[str] | Deck | Model"


def deck_of(source: Source, mode: Purpose) -> Deck:
    """The checked deck of a path, a Model or a Deck, for a mode (as `read_deck`).

    Raises UsageError for anything else and for a file that cannot be read, InputError for a wrong model.
    """
    if isinstance(source, str | os.PathLike):
        return read_deck(Path(source), mode)
    if isinstance(source, Deck):
        # its checks and its third block are those of the mode it was read for
        return source if source.mode == mode else source.for_mode(mode)
    if callable(getattr(source, "deck", None)):  # a Model, which is not imported to ask for it
        return source.deck(mode)
    text = f"a model is the path of an input file, a Deck or a Model, not {source!r:.60} ({type(source).__name__})"
    raise UsageError(text, "usage.model")


def has_interval(deck: Deck) -> bool:
    """Does mode 1 suit a model, because it has a time interval? Else mode 7 does."""
    return bool(deck.of("TIMESTEP", block=2))
