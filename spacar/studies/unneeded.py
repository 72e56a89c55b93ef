"""What a model could do without, with its price: the same run without one thing, its error and its time.

    rigid beams      all, and each one by itself: their dynamic deformations fixed
    linear strain    LDEFORM for every flexible beam
    merged nodes     pairs of alike beams in one line as one (`spacar.studies.coarser`)
    transfer output  OUTLEVEL 0 0, where the file asks for transfer functions
    engine           the same equations in NumPy

and what it would gain by the other measure of beams and by two beams in the place of each, which tells the error of the
mesh that the others share. All with the integration of a chosen setting, against the reference of the study.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from spacar.deck import Deck
from spacar.deck.finer import divisible_beams, flexible_beams, refine
from spacar.errors import SpacarError
from spacar.modes import find_mode
from spacar.studies.coarser import merged
from spacar.studies.error_norm import distance
from spacar.studies.models import linear_strain, rigid
from spacar.studies.trade import Reference, Setup, Trade, setup_options, timed_values, variant

MOST_BEAMS = 6  # that are looked at one by one
FINER = "two beams in the place of each, angle measure"


@dataclass(frozen=True)
class Price:
    """A variation: its error in the norm of the study [amplitudes], its time [s] and how it is written.

    `finer`: it is no simplification; its difference is the error of the mesh of the model.
    """

    what: str
    how: str
    error: float
    seconds: float
    finer: bool = False

    def line(self, target: float, seconds: float) -> str:
        """A sentence; `seconds` of the setting itself."""
        times = f"{self.seconds:.3g} s instead of {seconds:.3g} s"
        if self.finer:
            if self.error <= target:
                return f"the mesh is fine enough: {self.what} changes the result by {self.error:.2e} ({times})"
            return (
                f"the mesh is too coarse for {target:.3g}: {self.what} changes the result by {self.error:.2e} ({times})"
            )
        if self.error <= target:
            return f"not needed for {target:.3g}: {self.what}; without, error {self.error:.2e}, {times}: {self.how}"
        return f"needed: {self.what}; without, error {self.error:.2e}, {times}"


def prices(
    trade: Trade, setup: Setup, ref: Reference, left: Callable[[], float], tick: Callable[[str], None] = lambda _: None
) -> Iterator[Price]:
    """Every variation that the model has and that runs, while time is `left()` [s]."""
    base = variant(trade.deck, setup)
    options = setup_options(trade, setup, base)
    for what, how, make, extra in _variations(trade, base):
        if left() <= 0.0:
            return
        tick(what)
        try:
            values, seconds = timed_values(trade, setup, make(base), options | extra, left())
        except SpacarError:
            continue  # not of this model, or it does not move without it
        there = np.isfinite(values).all(axis=1)
        if not there.any():
            continue
        error = distance(values[there], ref.values[there], ref.amplitude[there])
        yield Price(what, how, error, seconds, what == FINER)


Variation = tuple[str, str, Callable[[Deck], Deck], dict[str, Any]]


def _variations(trade: Trade, deck: Deck) -> Iterator[Variation]:
    beams = [n for n, modes in flexible_beams(deck).items() if "DYNE" in modes.values()]

    def same(d: Deck) -> Deck:
        return d

    if beams:
        yield "flexible beams", f"leave out DYNE {', '.join(map(str, beams))}", rigid, {}
        if 1 < len(beams) <= MOST_BEAMS:
            for beam in beams:
                one = _rigid_one(beam)
                yield f"the flexibility of beam {beam}", f"leave out DYNE {beam}", one, {}
        yield "second-order terms of the deformations", f"LDEFORM {', '.join(map(str, beams))}", linear_strain, {}
        yield "nodes between beams in one line", "one beam in the place of two", lambda d: merged(d)[0], {}
    if any(v for s in deck.of("OUTLEVEL") for v in s.values if isinstance(v, int)):
        yield "transfer functions in the output", "OUTLEVEL 0 0", same, {"log_level": 0, "sbd_level": 0}
    if divisible_beams(deck)[0]:
        yield FINER, "--accuracy", lambda d: refine(d, 2), {"beams": "angle"}
    if find_mode(trade.mode).integrated and trade.options.get("compiled", True):
        yield "the compiled engine", "--general", same, {"compiled": False}


def _rigid_one(beam: int) -> Callable[[Deck], Deck]:
    return lambda deck: rigid(deck, (beam,))
