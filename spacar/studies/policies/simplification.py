"""What a model could do without, with its price: the same run without one thing, its error and its time.

    rigid beams      all, and each one by itself: their dynamic deformations fixed
    linear strain    LDEFORM for every flexible beam
    planar           planar elements for a spatial model in the x-y plane
    merged nodes     pairs of alike beams in one line as one
    transfer output  OUTLEVEL 0 0, where the file asks for transfer functions

All with the mesh, measure and integration of the cheapest setting, against the reference of the study. What is not
needed is left out, one after the other; the methods are tried again on the model that is left, which may have lost its
fastest vibrations. It is recommended where it saves time.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from shlex import quote
from typing import Any

import numpy as np

from spacar.deck import Deck
from spacar.deck.rewrite.refine import flexible_beams
from spacar.errors import SpacarError
from spacar.studies.policies.budget import Tick, TradeSearch, search
from spacar.studies.policies.trade import Entry
from spacar.studies.runs.setting import Setup, Trade, setup_options, variant

MOST_BEAMS = 6  # of a model whose beams are looked at one by one
LONGEST = 10.0  # times the cheapest setting: what is dearer saves nothing
# options of a run in the order in which they are told
WRITTEN = ("elements", "rigid_beams", "beams", "integrator", "rtol", "atol", "compiled", "duration", "n_steps")
SAVED = 0.95  # time over that of the cheapest setting, at most, of what is left out


@dataclass(frozen=True)
class Price:
    """A variation: its error in the norm of the study [amplitudes], its time and that of the setting itself [s], and
    how it is written."""

    what: str
    how: str
    error: float
    seconds: float
    instead: float

    def line(self, target: float) -> str:
        times = f"{self.seconds:.3g} s instead of {self.instead:.3g} s"
        if self.error <= target:
            return f"not needed for {target:.3g}: {self.what}; without, error {self.error:.2e}, {times}: {self.how}"
        if not np.isfinite(self.error):
            return f"needed: {self.what}; without, it has not all frequencies or load multipliers"
        return f"needed: {self.what}; without, error {self.error:.2e}, {times}"


def cheapest(
    trade: Trade, target: float, budget: float, tick: Tick = lambda _what, _left: None
) -> tuple[TradeSearch, list[Price]]:
    """The search of all settings within `budget` seconds, and the prices of what the cheapest one has. Raises as
    `search` does."""
    found = search(trade, target, budget, tick)
    prices = simplify(found)
    without_compiler(found)
    return found, prices


def simplify(found: TradeSearch) -> list[Price]:
    """The prices of what the cheapest setting has, as far as the budget goes; `found` is searched on without what is
    not needed."""
    best, ref = found.best, found.reference
    if best is None or best.setup is None:
        return []
    prices: list[Price] = []
    simpler: list[tuple[float, Setup]] = []
    for what, how, setup in variations(found.trade, best.setup):
        if found.left() <= 0.1:
            return prices
        row = found.run(setup, LONGEST * best.seconds * found.trade.repeats)
        if row["status"] == "done":
            price = Price(what, how, found.error(row) - ref.error, row["seconds"], best.seconds)
            prices.append(price)
            if price.error + ref.error <= found.goal:
                simpler.append((price.seconds, setup))
    chosen = best.setup
    for _, setup in sorted(simpler, key=lambda one: one[0]):
        both = _both(chosen, setup, best.setup)
        row = found.run(both, LONGEST * best.seconds * found.trade.repeats)
        if row["status"] == "done" and found.error(row) <= found.goal:
            chosen = both
            if row["seconds"] < SAVED * best.seconds:
                found.tried.append(both)
    if chosen is not best.setup and not found.trade.stationary:
        model = replace(chosen, integrator=None, tolerance=None)
        ladders = [[s for s in ladder if s != chosen] for ladder in found.ladders([model])]
        found.climb([ladder for ladder in ladders if ladder], SAVED * best.seconds, 1.0)
    return prices


def without_compiler(found: TradeSearch) -> None:
    """The cheapest setting with equations in NumPy, unless the user has chosen, or there is no other engine."""
    best, trade = found.best, found.trade
    if best is None or best.setup is None or trade.stationary or "compiled" in trade.options or found.left() <= 0.1:
        return
    setup = replace(best.setup, general=True)
    found.run(setup, best.seconds * trade.repeats)
    found.tried.append(setup)


def variations(trade: Trade, setup: Setup) -> Iterator[tuple[str, str, Setup]]:
    """What it is, how it is written, and the setting without it; those that this model has."""
    deck, found = trade.deck, []
    beams = [n for n, modes in flexible_beams(deck).items() if "DYNE" in modes.values()]
    if beams and setup.beams == "flexible":
        found.append(("flexible beams", f"leave out DYNE {_list(beams)}", replace(setup, beams="rigid")))
        for beam in beams if MOST_BEAMS >= len(beams) > 1 else ():
            single = replace(setup, beams=f"rigid {beam}")
            found.append((f"the flexibility of beam {beam}", f"leave out DYNE {beam}", single))
        linear, merged = replace(setup, strain="linear"), replace(setup, merged=True)
        found.append(("second-order terms of the deformations", f"LDEFORM {_list(beams)}", linear))
        found.append(("nodes between beams in one line", "one beam in the place of two", merged))
    found.append(("motion out of the plane", "planar elements", replace(setup, planar=True)))
    if any(v for s in deck.of("OUTLEVEL") for v in s.values if isinstance(v, int)):
        found.append(("transfer functions in the output", "OUTLEVEL 0 0", replace(setup, transfer=False)))
    for what, how, simpler in found:
        try:
            variant(deck, simpler)
        except SpacarError:
            continue
        yield what, how, simpler


def _both(chosen: Setup, other: Setup, given: Setup) -> Setup:
    """Without what `chosen` and `other` leave out of `given`."""
    changed = {name: value for name, value in vars(other).items() if value != vars(given)[name]}
    if "beams" in changed and "rigid" not in (chosen.beams, other.beams):
        numbers = {*chosen.beams.split()[1:], *other.beams.split()[1:]}
        changed["beams"] = " ".join(["rigid", *sorted(numbers, key=int)])
    return replace(chosen, **changed)


def _list(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers))


def simpler_deck(trade: Trade, best: Entry | None) -> Deck | None:
    """The model of a setting that options cannot make from the file; None where they can."""
    setup = None if best is None else best.setup
    if setup is None:
        return None
    names = ("beams", "strain", "planar", "merged", "transfer")
    plain = Setup(**{name: value for name, value in vars(setup).items() if name in names})
    return None if plain in (Setup(), Setup(beams="rigid")) else variant(trade.deck, plain)


def run_options(trade: Trade, setup: Setup) -> dict[str, str | int | float]:
    """The options of `spacar.run` for a setting, on the model of the file or on `simpler_deck`."""
    options = setup_options(trade, setup)
    if setup.elements != 1 and setup.beams != "rigid":
        options["elements"] = setup.elements
    if setup == replace(setup, beams="rigid", strain="full", planar=False, merged=False, transfer=True):
        options["rigid_beams"] = True
    return {name: options[name] for name in WRITTEN if name in options and (name, options[name]) != ("compiled", True)}


def command_line(mode: int, options: dict[str, Any], name: str) -> str:
    """The run with these options as words for the shell."""
    flags = {"duration": "--time", "n_steps": "--steps"}
    words = ["spacar", str(mode), quote(name)]
    for option, value in options.items():
        if option == "compiled":
            words.append("--general")
        elif option == "rigid_beams":
            words.append("--rigid")
        else:
            words += [flags.get(option, f"--{option}"), f"{value:.3g}" if option in ("rtol", "atol") else str(value)]
    return " ".join(words)
