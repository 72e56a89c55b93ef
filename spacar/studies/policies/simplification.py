"""What a model could do without, with its price: the same run without one thing, its error and its time.

    rigid beams      all, and each one by itself: their dynamic deformations fixed
    linear strain    LDEFORM for every flexible beam
    merged nodes     pairs of alike beams in one line as one, when they need not be divided
    transfer output  OUTLEVEL 0 0, where the file asks for transfer functions

All with the mesh, measure and integration of a chosen setting, against the reference of the study.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from spacar.deck import Deck
from spacar.deck.rewrite.coarser import merged
from spacar.deck.rewrite.refine import divisible_beams, flexible_beams
from spacar.deck.rewrite.simpler import linear_strain, rigid
from spacar.errors import SpacarError
from spacar.studies.policies.trade import Reference
from spacar.studies.runs.compared import GENERAL
from spacar.studies.runs.error_norm import distance
from spacar.studies.runs.setting import Setup, Trade, setup_options, timed_values, variant

MOST_BEAMS = 6  # of a model whose beams are looked at one by one


@dataclass(frozen=True)
class Price:
    """A variation: its error in the norm of the study [amplitudes], its time [s] and how it is written."""

    what: str
    how: str
    error: float
    seconds: float

    def line(self, target: float, seconds: float) -> str:
        """A sentence; `seconds` of the setting itself."""
        times = f"{self.seconds:.3g} s instead of {seconds:.3g} s"
        if self.error <= target:
            return f"not needed for {target:.3g}: {self.what}; without, error {self.error:.2e}, {times}: {self.how}"
        if not np.isfinite(self.error):
            return f"needed: {self.what}; without, it has not all frequencies or load multipliers"
        return f"needed: {self.what}; without, error {self.error:.2e}, {times}"


def prices(
    trade: Trade, setup: Setup, ref: Reference, left: Callable[[], float], tick: Callable[[str], None] = lambda _: None
) -> Iterator[Price]:
    """Every variation that the model has and that runs, while time is `left()` [s]."""
    base = variant(trade.deck, setup)
    options = setup_options(trade, setup, base)
    for what, how, make, extra in _variations(trade, setup):
        if left() <= 0.0:
            return
        tick(what)
        try:
            deck = make(trade.deck)
            deck = variant(deck, setup) if divisible_beams(deck)[0] else deck
            values, seconds = timed_values(trade, setup, deck, options | extra, left(), ref.names)
        except SpacarError:
            continue  # the model has no such variation, or cannot be computed with it
        there = np.asarray(np.isfinite(values).all(axis=1))
        if not there.any():
            continue
        error = distance(values[there], ref.values[there], ref.amplitude[there])
        lost = [name for name, has in zip(ref.names, there.tolist(), strict=False) if not has]
        if any(word in name for name in lost for word in GENERAL):
            error = np.inf  # a missing node is no loss, a missing frequency is one
        yield Price(what, how, error, seconds)


Variation = tuple[str, str, Callable[[Deck], Deck], dict[str, Any]]


def _variations(trade: Trade, setup: Setup) -> Iterator[Variation]:
    deck = trade.deck
    beams = [n for n, modes in flexible_beams(deck).items() if "DYNE" in modes.values()]

    def same(d: Deck) -> Deck:
        return d

    if beams and setup.beams != "rigid":
        yield "flexible beams", f"leave out DYNE {', '.join(map(str, beams))}", rigid, {}
        if 1 < len(beams) <= MOST_BEAMS:
            for beam in beams:
                one = _rigid_one(beam)
                yield f"the flexibility of beam {beam}", f"leave out DYNE {beam}", one, {}
        yield "second-order terms of the deformations", f"LDEFORM {', '.join(map(str, beams))}", linear_strain, {}
        if setup.elements == 1:
            yield "nodes between beams in one line", "one beam in the place of two", lambda d: merged(d)[0], {}
    if any(v for s in deck.of("OUTLEVEL") for v in s.values if isinstance(v, int)):
        yield "transfer functions in the output", "OUTLEVEL 0 0", same, {"log_level": 0, "sbd_level": 0}


def _rigid_one(beam: int) -> Callable[[Deck], Deck]:
    return lambda deck: rigid(deck, (beam,))
