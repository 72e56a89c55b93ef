"""The two calls that everybody uses: `frames` (a stream) and `run` (a result)."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

from spacar.deck import Deck, read_deck
from spacar.errors import UsageError
from spacar.mechanism import Settings, build
from spacar.modes import find_mode
from spacar.result import Result
from spacar.stream import Run

POSITIVE = ("atol", "rtol", "step", "duration", "n_steps")
LARGEST = {"rtol": 1.0, "n_steps": 10**15}  # an error of 100 %; times that still differ


def frames(mode: int, source: str | Path | Deck, *, nominal: Any = None, **options: Any) -> Run:
    """Prepare an analysis: read, check and number the model; the frames come when the returned Run is iterated over.

    `options` override the deck for this run: atol, rtol, integrator, step, duration, n_steps, compiled (see Settings).
    Raises UsageError (unknown mode), InputError (bad input) now; AnalysisError while iterating.
    """
    found = find_mode(mode)
    _check_options(options)
    deck = source if isinstance(source, Deck) else read_deck(source, found.number)
    prepared = Run(found, build(deck, found.number, **options), nominal=nominal)
    if deck.of("RLSE", block=1):
        from spacar.kinematics.lost_stiffness import lost_stiffness

        for message in lost_stiffness(deck, prepared.mechanism):
            prepared.report.add(str(message))
    return prepared


def run(mode: int, source: str | Path | Deck, *, nominal: Any = None, **options: Any) -> Result:
    """Run an analysis to its end and keep all frames in memory. Arguments and errors as `frames`."""
    return Result.collect(frames(mode, source, nominal=nominal, **options))


def _check_options(options: dict[str, Any]) -> None:
    """Raises UsageError for an unknown option, or for a tolerance, step or duration that is not positive."""
    known = [f.name for f in fields(Settings)]
    for name, value in options.items():
        if name not in known:
            raise UsageError(f"there is no option '{name}'; the options are {', '.join(known)}", "usage.option")
        if name in POSITIVE and value is not None:
            if not 0 < value < float("inf"):
                raise UsageError(f"the option {name} = {value!r} must be positive and finite", "usage.option")
            if value > LARGEST.get(name, value):
                raise UsageError(f"the option {name} = {value!r} is at most {LARGEST[name]:g}", "usage.option")
