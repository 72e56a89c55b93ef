"""The two calls that everybody uses: `frames` (a stream) and `run` (a result)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from spacar.deck import Deck, read_deck
from spacar.mechanism import build
from spacar.modes import find_mode
from spacar.options import checked_options
from spacar.result import Result
from spacar.stream import Run


def frames(mode: int, source: str | Path | Deck, *, nominal: Any = None, **options: Any) -> Run:
    """Prepare an analysis: read, check and number the model; the frames come when the returned Run is iterated over.

    mode      0 to 4, 7 to 10, see MODES;  source   path of the input file, or a Deck, which is checked
              again when it was read for another mode
    nominal   mode 3 only: result of mode 2, or of modes 7 to 10
    options   override the deck for this run: atol, rtol, integrator, step, duration, n_steps, compiled (see Settings)

    Raises UsageError (unknown mode or option, wrong value of one), InputError (bad input) now; AnalysisError while
    iterating.
    """
    found = find_mode(mode)
    options, notes = checked_options(options)
    deck = source if isinstance(source, Deck) else read_deck(source, found.number)
    if deck.mode != found.number:  # its checks and its third block are those of the mode it was read for
        deck = deck.for_mode(found.number)
    prepared = Run(found, build(deck, found.number, **options), nominal=nominal)
    for note in notes:
        prepared.report.add(f"warning: {note}")
    if deck.of("RLSE", block=1):
        from spacar.kinematics.lost_stiffness import lost_stiffness

        for message in lost_stiffness(deck, prepared.mechanism):
            prepared.report.add(str(message))
    return prepared


def run(mode: int, source: str | Path | Deck, *, nominal: Any = None, **options: Any) -> Result:
    """Run an analysis to its end and keep all frames in memory. Errors as `frames`.

    mode      0 to 4, 7 to 10, see MODES;  source   path of the input file, or a Deck
    nominal   mode 3 only: result of mode 2, or of modes 7 to 10;  options   override the deck, see `frames`
    """
    return Result.collect(frames(mode, source, nominal=nominal, **options))
