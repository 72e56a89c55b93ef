"""The trade between speed and accuracy within a time limit: the settings that matter, the cheapest first.

    reference   two methods at REFERENCE_MARGIN of the target, and below until they agree; Radau where explicit steps
                would be too small
    settings    every method from its loosest tolerance on, until one is accurate enough: tighter ones are slower
    stopped     a run that takes longer than the cheapest setting that is accurate enough (it cannot be recommended any
                more), or than what is left of the budget
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from spacar.calls import frames
from spacar.deck.finer import flexible_beams, refine
from spacar.errors import SpacarError
from spacar.studies.accuracy import stiff
from spacar.studies.error_norm import distance
from spacar.studies.rows import Row
from spacar.studies.trade import (
    Job,
    Reference,
    Setup,
    Trade,
    assess,
    recommend,
    reference,
    reference_setups,
    run_setup,
)
from spacar.studies.unneeded import Price, prices

METHODS, STIFF_METHODS = (155, 853, 0), (595, 553)
MESHES = (1, 2, 4, 8)  # elements in the place of a beam, stationary modes
LOOSEST, DECADES = 1e-2, 2  # tolerances: from here to so many decades below the target
FOR_REFERENCE = 0.6  # of the budget
JUDGE = 0.1  # error of the reference over the target, to be a judge of it

Tick = Callable[[str, float], None]
"""Is told what runs next, and the time to go at most [s]."""


@dataclass
class TradeSearch:
    """Rows of what has run, the settings that were tried in their order, the reference and its settings."""

    trade: Trade
    rows: list[Row] = field(default_factory=list)
    tried: list[Setup] = field(default_factory=list)
    against: list[Setup] = field(default_factory=list)
    reference: Reference | None = None
    skipped: int = 0
    end: float = 0.0  # of the budget, on the clock of time.perf_counter


def search(trade: Trade, target: float, budget: float, tick: Tick = lambda _what, _left: None) -> TradeSearch:
    """Reference, then the settings from cheap to dear, within `budget` seconds. Raises UsageError, and AnalysisError
    when the reference cannot be computed in its part of the budget."""
    begun = time.perf_counter()
    found = TradeSearch(trade, end=begun + budget)

    def left(part: float = 1.0) -> float:
        return max(part * budget - (time.perf_counter() - begun), 0.1)

    def run(setup: Setup, limit: float, times: int) -> Row:
        tick(" ".join(filter(None, (setup.model, setup.integration))), left())
        row = run_setup(Job(replace(trade, repeats=times), setup, limit))
        row["case"] = trade.key(setup)
        found.rows.append(row)
        return row

    hard = not trade.stationary and stiff(frames(trade.mode, trade.deck, **trade.options))
    ladders = _ladders(trade, target, hard)
    meshes = sorted({s.elements for ladder in ladders for s in ladder})
    methods = STIFF_METHODS if hard else (853, 155)
    for smaller in (1.0, 1e-2, 1e-4):  # a motion that magnifies errors needs more
        found.against = reference_setups(trade, meshes, smaller * target, methods)
        for setup in found.against:
            run(setup, left(FOR_REFERENCE), 1)
        found.reference = ref = reference(trade, found.rows, found.against)
        if trade.stationary or ref.error <= JUDGE * target or left(FOR_REFERENCE / 2) < 1.0:
            break
    best = np.inf
    while ladders and left() > 0.1:
        setup = ladders[0].pop(0)
        row = run(setup, min(left(), best * trade.repeats), trade.repeats)
        found.tried.append(setup)
        if row["status"] == "done":
            error = distance(np.array(row["values"]), ref.values, ref.amplitude) + ref.error
            if error <= target:
                best = min(best, row["seconds"])
            if error <= target or row["seconds"] > best:
                ladders[0].clear()
        elif "stopped after" in str(row["reason"]):
            ladders[0].clear()
        ladders = [ladder for ladder in (*ladders[1:], ladders[0]) if ladder]  # all methods in turn
    found.skipped = sum(map(len, ladders))
    return found


def unneeded(found: TradeSearch, target: float, tick: Tick = lambda _what, _left: None) -> list[Price]:
    """What the recommended setting could do without, as far as the budget goes; without one nothing."""
    ref = found.reference
    assert ref is not None
    best = recommend(assess(found.trade, found.rows, found.tried, ref), target, ref)
    if best is None or best.setup is None:
        return []

    def left() -> float:
        return found.end - time.perf_counter()

    return list(prices(found.trade, best.setup, ref, left, lambda what: tick(f"without {what}", left())))


def _ladders(trade: Trade, target: float, hard: bool) -> list[list[Setup]]:
    """Settings of each method from cheap to dear; of each measure of beams in the stationary modes."""
    flexible = bool(flexible_beams(trade.deck))
    if trade.stationary:
        meshes = MESHES if flexible and _divisible(trade) else (1,)
        return [[Setup(n, measure=m) for n in meshes] for m in (("", "angle") if flexible else ("",))]
    lowest = int(np.floor(np.log10(target))) - DECADES
    tolerances = [10.0**k for k in range(int(np.log10(LOOSEST)), max(lowest, -12) - 1, -1)]
    codes: Iterable[int] = (*STIFF_METHODS, *METHODS) if hard else (*METHODS, 595) if flexible else METHODS
    return [[Setup(integrator=code, tolerance=t) for t in tolerances] for code in codes]


def _divisible(trade: Trade) -> bool:
    try:
        refine(trade.deck, 2)
    except SpacarError:
        return False
    return True


def run_options(trade: Trade, setup: Setup) -> dict[str, str | int | float]:
    """The options of `spacar.run` for a setting; a finer mesh is none of them."""
    options: dict[str, str | int | float] = {}
    if setup.measure:
        options["beams"] = setup.measure
    if setup.integrator is not None:
        options["integrator"] = setup.integrator
    if setup.tolerance is not None:
        settings = frames(trade.mode, trade.deck, **trade.options).mechanism.settings
        ratio = settings.atol / settings.rtol if settings.rtol > 0.0 else 1.0
        options |= {"rtol": setup.tolerance, "atol": setup.tolerance * ratio}
    return options | {name: trade.options[name] for name in ("duration", "n_steps") if name in trade.options}


def command_line(trade: Trade, setup: Setup, name: str) -> str:
    """The run of this setting as words for the shell; a finer mesh, which no option makes, is said after it."""
    flags = {"duration": "--time", "n_steps": "--steps"}
    words = ["spacar", str(trade.mode), name]
    for option, value in run_options(trade, setup).items():
        words += [flags.get(option, f"--{option}"), f"{value:.3g}" if option in ("rtol", "atol") else str(value)]
    line = " ".join(words)
    return line if setup.elements == 1 else f"{line}   (with {setup.elements} elements in the place of each beam)"
