"""The trade between speed and accuracy within a time limit: the settings that matter, the cheapest first.

    reference   the ladder of tolerances or of meshes that `--accuracy` climbs, to JUDGE of the target
    models      of each measure the coarsest mesh whose error leaves room for that of the integration; in the stationary
                modes every mesh up to there; the model with rigid beams
    settings    every method of each of these models from its loosest tolerance on, until one is accurate enough:
                tighter ones are slower; then the cheapest without what it can do without
                (`spacar.studies.policies.simplification`), and with equations in NumPy
    stopped     a run that takes longer than the cheapest setting that is accurate enough (it cannot be recommended any
                more), or than its part of what is left of the budget

Where the reference does not reach the target within its part of the budget, the goal is what it reached.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from spacar.calls import frames
from spacar.deck.rewrite.refine import flexible_beams
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError, SpacarError
from spacar.integrators.methods import AUTOMATIC
from spacar.mechanism.element_batches import by_angles
from spacar.stream import Run
from spacar.studies.policies.mesh import MeshSearch, divisible, measured
from spacar.studies.policies.trade import Entry, Reference, assess, recommend, row_error
from spacar.studies.runs.result_quantities import distance
from spacar.studies.runs.rows import Row
from spacar.studies.runs.setting import Job, Setup, Trade, run_setup, variant
from spacar.studies.runs.tolerance_ladder import Computed, ToleranceLadder

JUDGE = 0.1  # error of the reference over the target
METHODS = (AUTOMATIC, 155, 853, 0, 595, 553)  # the first of them gives the others their limit of time
FINEST = {True: 64, False: 16}  # elements in the place of a beam, at most: stationary modes, motions
LOOSEST, DECADES = 1e-2, 2  # tolerances: from here to so many decades below the target
FOR_REFERENCE, FOR_MODELS, FOR_SETTINGS = 0.6, 0.7, 0.9  # parts of the budget, from its begin
UNKNOWN = 0.1  # error of a reference of which nothing follows
ROOM = 0.7  # of the target that the error of a mesh, or of the reference, may take
SAME_ERROR = 0.8  # of that of the tolerance before: the error is that of the model, no smaller tolerance helps
ENOUGH = 3.0  # times the cheapest accurate mesh: one of the other measure that takes longer is not looked at

Tick = Callable[[str, float], None]
"""Called with what runs next and the longest time that is left [s]."""


@dataclass
class TradeSearch:
    """Rows of what has run, the settings that were tried in their order, and the reference.

    goal        the error that is asked of the settings: the target, or what the reference allows
    undivided   beams that cannot be divided, with the reasons: the error of their mesh is not known
    """

    trade: Trade
    target: float
    reference: Reference
    rows: list[Row] = field(default_factory=list)
    tried: list[Setup] = field(default_factory=list)
    goal: float = np.inf
    skipped: int = 0
    undivided: dict[int, str] = field(default_factory=dict)
    begun: float = field(default_factory=time.process_time)
    budget: float = 60.0  # seconds
    tick: Tick = lambda _what, _left: None

    def left(self, part: float = 1.0) -> float:
        """Seconds of a part of the budget that are left."""
        return _left(part * self.budget, self.begun)

    def run(self, setup: Setup, limit: float, times: int | None = None) -> Row:
        """One setting; a run of `limit` seconds, or of all that are left, is stopped."""
        self.tick(" ".join(filter(None, (setup.model, setup.integration))), self.left())
        row = run_setup(Job(replace(self.trade, repeats=times or self.trade.repeats), setup, min(self.left(), limit)))
        row["case"] = self.trade.key(setup)
        self.rows = [r for r in self.rows if r["case"] != row["case"]] + [row]
        return row

    def error(self, row: Row) -> float:
        """The error of a finished row, plus that of the reference; inf when it lacks what counts."""
        return row_error(row, self.reference, self.trade)[0] + self.reference.error

    @property
    def entries(self) -> list[Entry]:
        """All settings that were tried."""
        return assess(self.trade, self.rows, self.tried, self.reference, extrapolated=False)

    @property
    def best(self) -> Entry | None:
        """The cheapest setting that reaches the goal; the most accurate one where none does."""
        found = recommend(self.entries, self.goal, self.reference)
        finished = [e for e in self.entries if np.isfinite(e.error)]
        return found or min(finished, key=lambda e: e.error, default=None)

    def climb(self, ladders: list[list[Setup]], best: float = np.inf, part: float = FOR_SETTINGS) -> float:
        """Run the settings of all ladders in turn, each from its loosest on; the time of the best that is good enough,
        `best` where none is faster than that."""
        known: dict[tuple[str, int | None], float] = {}  # last errors of rigid models, by method
        while ladders and self.left(part) > 0.1:
            setup = ladders[0].pop(0)
            limit = best * self.trade.repeats if best < np.inf else self.left(part) / len(ladders)
            row = self.run(setup, limit)
            self.tried.append(setup)
            if row["status"] == "done":
                error, kind = self.error(row), (setup.beams, setup.integrator)
                if error <= self.goal:
                    best = min(best, row["seconds"])
                of_model = setup.beams != "flexible" and not error < SAME_ERROR * known.get(kind, np.inf)
                known[kind] = error
                if error <= self.goal or row["seconds"] > best or of_model:
                    ladders[0].clear()
            elif row["stopped"]:
                ladders[0].clear()
            ladders = [ladder for ladder in (*ladders[1:], ladders[0]) if ladder]  # all methods in turn
        self.skipped += sum(map(len, ladders))
        return best

    def ladders(self, models: Sequence[Setup]) -> list[list[Setup]]:
        """Settings of each method and model from cheap to dear; of each measure of beams in the stationary modes."""
        if self.trade.stationary:
            measures = dict.fromkeys((model.measure, model.beams) for model in models)
            return [[model for model in models if (model.measure, model.beams) == m] for m in measures]
        lowest = int(np.floor(np.log10(self.goal))) - DECADES
        tolerances = [10.0**k for k in range(int(np.log10(LOOSEST)), max(lowest, -12) - 1, -1)]
        return [
            [replace(model, integrator=code, tolerance=t) for t in tolerances] for code in METHODS for model in models
        ]


def _left(seconds: float, begun: float) -> float:
    """Of so many seconds of this process since `begun`, at least 0.1."""
    return max(seconds - (time.process_time() - begun), 0.1)


def search(trade: Trade, target: float, budget: float, tick: Tick = lambda _what, _left: None) -> TradeSearch:
    """Reference, then the settings from cheap to dear, within `budget` seconds. Raises UsageError, and AnalysisError
    when the reference cannot be computed in its part of the budget, or to an error of UNKNOWN."""
    begun = time.process_time()
    run = frames(trade.mode, trade.deck, **trade.options)
    beams, undivided = divisible(run)
    if beams and not trade.stationary and (why := massless(trade)):
        beams, undivided = (), undivided | dict.fromkeys(beams, why)
    left = _left(FOR_REFERENCE * budget, begun)
    tick("the reference", left)
    ref, meshes = reference(trade, run, beams, target, left)
    error = ref.error
    if error > UNKNOWN:
        text = f"the reference reaches an error of {error:.2g} of the motion in its time only ({ref.text});"
        raise AnalysisError(f"{text} more --budget, a shorter --time, or the --variable that counts", "study.reference")
    goal = target if error <= ROOM * target else 2.0 * error
    found = TradeSearch(trade, target, ref, goal=goal, undivided=undivided, begun=begun, budget=budget, tick=tick)
    flexible = _models(found, meshes) if meshes else [Setup(measure=measured(run) if beams else "")]
    found.climb(found.ladders([*_rigid(trade), *flexible]))
    return found


def _rigid(trade: Trade) -> list[Setup]:
    """The model with rigid beams, where it has flexible ones and can do without."""
    setup = Setup(beams="rigid")
    try:
        moves = run_of(trade, setup).mechanism.numbering.nkddof
    except SpacarError:
        return []
    return [] if trade.stationary and not moves else [setup]


def _models(found: TradeSearch, meshes: Sequence[Computed]) -> list[Setup]:
    """The coarsest mesh of each measure that is good enough, else the finest; in the stationary modes all meshes up to
    there."""
    trade, ref = found.trade, found.reference
    errors = {}
    for mesh in meshes:
        at = [mesh.found.names.index(name) for name in ref.names]
        n = max(mesh.pieces.values())
        errors[n] = distance(mesh.found.values[at], ref.values, ref.amplitude) + ref.error
    enough = next((n for n, e in errors.items() if e <= ROOM * found.goal), None)
    enough = enough or next((n for n, e in errors.items() if e <= found.goal), max(errors))
    doubled = [2**k for k in range(FINEST[trade.stationary].bit_length())]
    if trade.stationary:
        return [Setup(n, measure="angle") for n in errors if n <= enough] + [Setup(n) for n in doubled]
    models = [Setup(enough, measure="angle")]
    if set(flexible_beams(trade.deck)) <= by_angles(trade.deck):
        return models
    its = next(mesh for mesh in meshes if max(mesh.pieces.values()) == enough).attempt
    for n in doubled:
        setup = Setup(n, integrator=its.integrator, tolerance=its.tolerance)
        row = found.run(setup, min(max(ENOUGH * its.seconds, 0.1), found.left(FOR_MODELS)), 1)
        if row["status"] != "done":
            break
        if found.error(row) <= ROOM * found.goal:
            return [*models, Setup(n)]
    return models


def reference(
    trade: Trade, run: Run, beams: tuple[int, ...], target: float, seconds: float
) -> tuple[Reference, list[Computed]]:
    """The reference, and the meshes from coarse to fine that it was extrapolated from: none where the time is enough
    for the mesh of the user only, whose error is not known then.

    Raises AnalysisError when there is no reference within the time.
    """
    target, end = JUDGE * target, time.process_time() + seconds
    if not beams:
        last, before = ToleranceLadder(run, trade.variables, end=end).climb(target)
        return _of(last, f"methods {before.attempt} and {last.attempt} differ by {last.attempt.difference:.2e}"), []
    study = MeshSearch(run, beams, trade.variables, end=end)
    result = study.refined(target)
    if result.rows is None:
        return _of(study.meshes[0], f"the error of the mesh is not known, as {result.way} (--budget)"), []
    finest, own = result.finest.found, study.meshes[0].found.names
    rows = [i for i, name in enumerate(finest.names) if np.isfinite(finest.amplitude[i]) and name in own]
    names = tuple(finest.names[i] for i in rows)
    found = Reference(result.rows.values[rows], finest.amplitude[rows], result.estimate, result.way, names)
    return found, [mesh for mesh in study.meshes if len(set(mesh.pieces.values())) == 1]


def _of(run: Computed, text: str) -> Reference:
    return Reference(run.found.values, run.found.amplitude, run.error, text, run.found.names)


def massless(trade: Trade) -> str:
    """Why divided beams do not move, such as parts without inertia against torsion; empty where they do."""
    evaluator = Dynamics(run_of(trade, Setup(2)).mechanism)
    try:
        evaluator.rhs(0.0, evaluator.start())
    except AnalysisError as error:
        return str(error)
    return ""


def run_of(trade: Trade, setup: Setup) -> Run:
    """The run of a model, at its own settings of the integration."""
    options = trade.options | ({"beams": setup.measure} if setup.measure else {})
    return frames(trade.mode, variant(trade.deck, setup), **options)
