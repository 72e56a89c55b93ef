"""The trade between speed and accuracy within a time limit: the settings that matter, the cheapest first.

    reference   two methods at REFERENCE_MARGIN of the target, and below it until they agree; Radau where explicit steps
                would be too small. With beams that can be divided: two methods from the loosest tolerance on until
                they agree to that margin; then 1, 2, 4 ... beams in the angle measure with one of them, extrapolated,
                until that is a judge
    models      of each measure the coarsest mesh whose error, with that reference integration, leaves room for the
                error of a cheaper integration
                that of rigid beams is one of them
    settings    every method of each of these models from its loosest tolerance on, until one is accurate enough:
                tighter ones are slower; in the stationary modes every mesh; then the cheapest with equations in NumPy
    stopped     a run that takes longer than the cheapest setting that is accurate enough (it cannot be recommended any
                more), or than what is left of the budget
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from shlex import quote

import numpy as np

from spacar.calls import frames
from spacar.deck.rewrite.refine import flexible_beams
from spacar.errors import AnalysisError, SpacarError
from spacar.mechanism.element_batches import by_angles
from spacar.stream import Run
from spacar.studies.policies.mesh import divisible
from spacar.studies.policies.simplification import Price, prices
from spacar.studies.policies.trade import (
    REFERENCE_MARGIN,
    REFERENCE_TOLERANCE,
    Entry,
    Reference,
    assess,
    recommend,
    reference,
    reference_setups,
)
from spacar.studies.runs.compared import row_values
from spacar.studies.runs.error_norm import amplitudes, distance
from spacar.studies.runs.rows import Row
from spacar.studies.runs.setting import Job, Setup, Trade, run_setup, variant
from spacar.studies.runs.tolerance_ladder import stiff

METHODS, STIFF_METHODS = (155, 853, 0), (595, 553)
EXPLICIT = (0, 853)  # methods of a reference that is not stiff
FINEST = {True: 64, False: 16}  # elements in the place of a beam, at most: stationary modes, motions
DEARER = 4.0  # time of a mesh over that of one half as fine, about
LOOSEST, DECADES = 1e-2, 2  # tolerances: from here to so many decades below the target
FOR_REFERENCE = 0.6  # part of the budget
JUDGE = 0.1  # error of the reference over the target, to be a judge of it
ROOM = 0.7  # of the target that the error of a mesh may take
LONGEST_PRICE = 10.0  # times the recommended setting: what is dearer saves nothing
SAME_ERROR = 0.8  # of that of the tolerance before: the error is that of the model, no smaller tolerance helps
ENOUGH = 3.0  # times the cheapest accurate mesh: one of the other measure that takes longer is not looked at

Tick = Callable[[str, float], None]
"""Called with what runs next and the longest time that is left [s]."""


@dataclass
class TradeSearch:
    """Rows of what has run, the settings that were tried in their order, the reference and its settings.

    undivided   beams that cannot be divided, with the reasons: the error of their mesh is not known
    """

    trade: Trade
    rows: list[Row] = field(default_factory=list)
    tried: list[Setup] = field(default_factory=list)
    against: list[Setup] = field(default_factory=list)
    reference: Reference | None = None
    skipped: int = 0
    undivided: dict[int, str] = field(default_factory=dict)
    begun: float = field(default_factory=time.process_time)
    budget: float = 60.0  # seconds
    tick: Tick = lambda _what, _left: None

    def left(self, part: float = 1.0) -> float:
        """Seconds of a part of the budget that are left."""
        return max(part * self.budget - (time.process_time() - self.begun), 0.1)

    def run(self, setup: Setup, limit: float, times: int) -> Row:
        """One setting; a run of `limit` seconds is stopped."""
        self.tick(" ".join(filter(None, (setup.model, setup.integration))), self.left())
        row = run_setup(Job(replace(self.trade, repeats=times), setup, limit))
        row["case"] = self.trade.key(setup)
        self.rows = [r for r in self.rows if r["case"] != row["case"]] + [row]
        return row

    def row(self, setup: Setup) -> Row | None:
        """The row of a setting that has run, else None."""
        case = self.trade.key(setup)
        return next((row for row in self.rows if row["case"] == case), None)

    def error(self, row: Row) -> float:
        """The error of a finished row, plus that of the reference."""
        assert self.reference is not None
        ref = self.reference
        return distance(row_values(row, ref.names), ref.values, ref.amplitude) + ref.error

    @property
    def entries(self) -> list[Entry]:
        """All settings that were tried."""
        assert self.reference is not None
        return assess(self.trade, self.rows, self.tried, self.reference, extrapolated=False)


def search(trade: Trade, target: float, budget: float, tick: Tick = lambda _what, _left: None) -> TradeSearch:
    """Reference, then the settings from cheap to dear, within `budget` seconds. Raises UsageError, and AnalysisError
    when the reference cannot be computed in its part of the budget."""
    found = TradeSearch(trade, budget=budget, tick=tick)
    run = frames(trade.mode, trade.deck, **trade.options)
    beams, found.undivided = divisible(run)
    hard = not trade.stationary and stiff(run)
    if beams:
        models = _mesh_reference(found, target, hard)
    else:
        models = [(Setup(), hard)]
        _reference(found, target, STIFF_METHODS if hard else (853, 155))
    ladders = _ladders(trade, [*_rigid(trade), *models], target)
    best = _climb(found, ladders, target)
    _without_compiler(found, target, best)
    return found


def _rigid(trade: Trade) -> list[tuple[Setup, bool]]:
    """The model with rigid beams, where it has flexible ones and can do without."""
    setup = Setup(beams="rigid")
    try:
        moves = _run_of(trade, setup).mechanism.numbering.nkddof
    except SpacarError:
        return []
    return [] if trade.stationary and not moves else [(setup, False)]


def _reference(found: TradeSearch, target: float, methods: Sequence[int]) -> None:
    """Find the reference on the mesh of the file."""
    trade = found.trade
    for smaller in (1.0, 1e-2, 1e-4):  # a motion that magnifies errors needs more
        found.against = reference_setups(trade, (1,), smaller * target, methods)
        for setup in found.against:
            found.run(setup, found.left(FOR_REFERENCE), 1)
        found.reference = ref = reference(trade, found.rows, found.against)
        if ref.error <= JUDGE * target or found.left(FOR_REFERENCE / 2) < 1.0:
            return


def _mesh_reference(found: TradeSearch, target: float, hard: bool) -> list[tuple[Setup, bool]]:
    """Finer and finer meshes until their extrapolation is a judge; the models whose mesh is good enough, each with
    whether it is stiff. Raises AnalysisError when not even two meshes could be computed."""
    trade = found.trade
    how = None if trade.stationary else _integration(found, target, STIFF_METHODS if hard else EXPLICIT)
    chain: list[Setup] = []
    n, kinds = 1, {}
    while n <= FINEST[trade.stationary]:
        setup = Setup(n, measure="angle")
        if how is not None:
            hard = kinds[n] = hard or stiff(_run_of(trade, setup))  # finer meshes are stiffer
            setup = how.on(setup, hard)
        row = found.row(setup) or found.run(setup, found.left(FOR_REFERENCE), 1)
        if row["status"] != "done":
            if len(chain) < 2:
                raise AnalysisError(f"the reference could not be computed: {row['reason']}", "study.reference")
            break
        chain.append(setup)
        last = DEARER * row["seconds"] > found.left(FOR_REFERENCE)
        if len(chain) > 2 or (len(chain) == 2 and last):
            found.against = chain[-3:]
            found.reference = reference(trade, found.rows, found.against, None if how is None else how.known)
            if found.reference.error <= JUDGE * target:
                break
        if last:
            break
        n *= 2
    if found.reference is None:
        raise AnalysisError("the reference needs two meshes at least, and more budget (--budget)", "study.reference")
    return _models(found, target, chain, kinds, how)


@dataclass(frozen=True)
class ReferenceIntegration:
    """How the meshes of a reference are integrated: method (Radau where a mesh is stiff) and tolerance.

    known   twice its error on the coarsest mesh, and how that error is known, in words
    """

    code: int
    tolerance: float
    known: tuple[float, str]

    def on(self, setup: Setup, hard: bool) -> Setup:
        code = STIFF_METHODS[0] if hard and self.code not in STIFF_METHODS else self.code
        return replace(setup, integrator=code, tolerance=self.tolerance)


def _integration(found: TradeSearch, target: float, methods: Sequence[int]) -> ReferenceIntegration:
    """The faster of two methods, a tenth of the loosest tolerance at which they agree on the mesh of the file to
    REFERENCE_MARGIN of the target. Raises AnalysisError."""
    tolerance, agreed = LOOSEST, False
    while True:
        pair = [Setup(measure="angle", integrator=code, tolerance=tolerance) for code in methods]
        rows = [found.run(setup, found.left(FOR_REFERENCE), 1) for setup in pair]
        failed = next((row for row in rows if row["status"] != "done"), None)
        if failed is not None and (agreed or tolerance <= REFERENCE_TOLERANCE or found.left(FOR_REFERENCE) < 1.0):
            raise AnalysisError(f"the reference could not be computed: {failed['reason']}", "study.reference")
        if failed is None:
            one, other = (np.array(row["values"]) for row in rows)
            error = distance(one, other, amplitudes(one, stationary=False))
            text = f"methods {methods[0]} and {methods[1]} at tolerance {tolerance:.3g} differ by {error:.2e}"
            if agreed or tolerance <= REFERENCE_TOLERANCE:
                faster = min(zip(rows, methods, strict=True), key=lambda pair: float(pair[0]["seconds"]))[1]
                return ReferenceIntegration(faster, tolerance, (2.0 * error, text))
            agreed = error <= REFERENCE_MARGIN * target
        tolerance = max(0.1 * tolerance, REFERENCE_TOLERANCE)


def _models(
    found: TradeSearch, target: float, chain: Sequence[Setup], kinds: dict[int, bool],
    how: ReferenceIntegration | None,
) -> list[tuple[Setup, bool]]:  # fmt: skip
    """The coarsest mesh of each measure that is good enough; in the stationary modes all meshes up to there."""
    trade = found.trade
    rows = {s.elements: found.row(s) or {} for s in chain}
    errors = {n: found.error(row) for n, row in rows.items()}
    enough = next((n for n, e in errors.items() if e <= ROOM * target), None)
    enough = enough or next((n for n, e in errors.items() if e <= target), None)
    if how is None:
        meshes = [n for n in errors if n <= (enough or max(errors))]
        return [(Setup(n, measure="angle"), False) for n in meshes] + [(Setup(n), False) for n in _doubled(trade)]
    if enough is None:
        return []
    models = [(Setup(enough, measure="angle"), kinds[enough])]
    if set(flexible_beams(trade.deck)) <= by_angles(trade.deck):
        return models
    hard = False
    for n in _doubled(trade):
        setup = Setup(n)
        hard = hard or stiff(_run_of(trade, setup))
        row = found.run(how.on(setup, hard), ENOUGH * rows[enough]["seconds"], 1)
        if row["status"] != "done":
            break
        if found.error(row) <= ROOM * target:
            models.append((setup, hard))
            break
    return models


def _doubled(trade: Trade) -> list[int]:
    return [2**k for k in range(FINEST[trade.stationary].bit_length())]


def _run_of(trade: Trade, setup: Setup) -> Run:
    options = trade.options | ({"beams": setup.measure} if setup.measure else {})
    return frames(trade.mode, variant(trade.deck, setup), **options)


def _climb(found: TradeSearch, ladders: list[list[Setup]], target: float) -> float:
    """Run the settings of all ladders in turn, each from its loosest on; the time of the best that is good enough."""
    trade, best = found.trade, np.inf
    known: dict[int | None, float] = {}  # last errors of the rigid model, by method
    while ladders and found.left() > 0.1:
        setup = ladders[0].pop(0)
        row = found.run(setup, min(found.left(), best * trade.repeats), trade.repeats)
        found.tried.append(setup)
        if row["status"] == "done":
            error = found.error(row)
            if error <= target:
                best = min(best, row["seconds"])
            of_model = setup.beams == "rigid" and not error < SAME_ERROR * known.get(setup.integrator, np.inf)
            known[setup.integrator] = error
            if error <= target or row["seconds"] > best or of_model:
                ladders[0].clear()
        elif "stopped after" in str(row["reason"]):
            ladders[0].clear()
        ladders = [ladder for ladder in (*ladders[1:], ladders[0]) if ladder]  # all methods in turn
    found.skipped = sum(map(len, ladders))
    return best


def _without_compiler(found: TradeSearch, target: float, best: float) -> None:
    """The cheapest setting with equations in NumPy, unless the user has chosen, or there is no other engine."""
    trade = found.trade
    entry = recommend(found.entries, target, found.reference) if found.reference else None
    if entry is None or entry.setup is None or trade.stationary or "compiled" in trade.options or found.left() <= 0.1:
        return
    setup = replace(entry.setup, general=True)
    found.run(setup, min(found.left(), best * trade.repeats), trade.repeats)
    found.tried.append(setup)


def unneeded(found: TradeSearch, target: float, tick: Tick = lambda _what, _left: None) -> list[Price]:
    """What the recommended setting could do without, as far as the budget goes; empty when none is recommended."""
    ref = found.reference
    assert ref is not None
    best = recommend(found.entries, target, ref)
    if best is None or best.setup is None:
        return []
    end = found.begun + found.budget

    def left() -> float:
        return min(end - time.process_time(), LONGEST_PRICE * best.seconds)

    return list(prices(found.trade, best.setup, ref, left, lambda what: tick(f"without {what}", left())))


def _ladders(trade: Trade, models: Sequence[tuple[Setup, bool]], target: float) -> list[list[Setup]]:
    """Settings of each method and model from cheap to dear; of each measure of beams in the stationary modes."""
    if trade.stationary:
        measures = dict.fromkeys(model.measure for model, _ in models)
        return [[model for model, _ in models if model.measure == m] for m in measures]
    flexible = bool(flexible_beams(trade.deck))
    lowest = int(np.floor(np.log10(target))) - DECADES
    tolerances = [10.0**k for k in range(int(np.log10(LOOSEST)), max(lowest, -12) - 1, -1)]
    ladders = []
    for model, hard in models:
        codes: Iterable[int] = (*STIFF_METHODS, *METHODS) if hard else (*METHODS, 595) if flexible else METHODS
        ladders += [[replace(model, integrator=code, tolerance=t) for t in tolerances] for code in codes]
    return ladders


def run_options(trade: Trade, setup: Setup) -> dict[str, str | int | float]:
    """The options of `spacar.run` for a setting."""
    options: dict[str, str | int | float] = {}
    if setup.elements != 1:
        options["elements"] = setup.elements
    if setup.beams == "rigid":
        options["rigid_beams"] = True
    if setup.measure:
        options["beams"] = setup.measure
    if setup.integrator is not None:
        options["integrator"] = setup.integrator
    if setup.tolerance is not None:
        settings = frames(trade.mode, trade.deck, **trade.options).mechanism.settings
        ratio = settings.atol / settings.rtol if settings.rtol > 0.0 else 1.0
        options |= {"rtol": setup.tolerance, "atol": setup.tolerance * ratio}
    if setup.general or trade.options.get("compiled") is False:
        options["compiled"] = False
    return options | {name: trade.options[name] for name in ("duration", "n_steps") if name in trade.options}


def command_line(trade: Trade, setup: Setup, name: str) -> str:
    """The run of this setting as words for the shell."""
    flags = {"duration": "--time", "n_steps": "--steps"}
    words = ["spacar", str(trade.mode), quote(name)]
    for option, value in run_options(trade, setup).items():
        if option == "compiled":
            words.append("--general")
        elif option == "rigid_beams":
            words.append("--rigid")
        else:
            words += [flags.get(option, f"--{option}"), f"{value:.3g}" if option in ("rtol", "atol") else str(value)]
    return " ".join(words)
