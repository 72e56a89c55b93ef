"""Speed against accuracy: one model with many settings of mesh and integration, timed and compared with a reference.

A `Setup` is one way to compute the same thing. Every setup is run (the reference ones too) to a row with the values of
the chosen variables at the output times, its median processor time and the number of its right-hand sides; `assess`
turns rows into errors, in the norm of `spacar.studies.error_norm` with amplitudes of the reference.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.calls import frames
from spacar.deck import Deck
from spacar.deck.finer import refine, refine_divisible
from spacar.errors import AnalysisError, UsageError
from spacar.integrators.methods import METHODS
from spacar.mechanism import build
from spacar.modes import find_mode
from spacar.options import integrator
from spacar.result import Result
from spacar.studies.compared import aligned, compared, real_series, row_values
from spacar.studies.error_norm import distance
from spacar.studies.models import linear_strain, rigid
from spacar.studies.perturbation import perturbation, require_perturbation
from spacar.studies.quantities import Quantity, quantity
from spacar.studies.richardson import extrapolate, extrapolate_rows
from spacar.studies.rows import Row, key
from spacar.studies.sweep import explain

MOST_VARIABLES = 600  # that are compared when the user names none
LONG = 1.0  # seconds, after which a run with a limit is not repeated: its time is known well enough
REFERENCE_METHODS = (853, 0)
REFERENCE_TOLERANCE = 1e-12  # smallest
REFERENCE_MARGIN = 0.01  # tolerance of the reference / smallest error that is looked at


@dataclass(frozen=True)
class Setup:
    """One way to compute. `elements` per beam of the file; beams flexible or rigid; strain full or linear (LDEFORM).

    `integrator`, `tolerance` (relative; the absolute one keeps its ratio of ERROR) of variable step codes, `substeps`
    per output step of fixed step codes; None in the stationary modes. `method` full, or perturbation (with `substeps`).
    """

    elements: int = 1
    beams: str = "flexible"
    strain: str = "full"
    integrator: int | None = None
    tolerance: float | None = None
    substeps: int | None = None
    method: str = "full"
    measure: str = ""  # of the deformations of beams, "angle" or "sine"; "": that of the file
    general: bool = False  # equations in NumPy where they could be in C

    @property
    def model(self) -> str:
        """Model in words."""
        if self.beams == "rigid":
            return "rigid beams"
        text = "as given" if self.elements == 1 else f"{self.elements} elements a beam"
        text += f", {self.measure} measure" if self.measure else ""
        return f"{text}, linear strain" if self.strain == "linear" else text

    @property
    def integration(self) -> str:
        """Integration in words; empty in the stationary modes."""
        if self.method == "perturbation":
            return f"perturbation, {self.substeps} steps an output"
        if self.integrator is None:
            return ""
        how = f"tol {self.tolerance:.3g}" if self.substeps is None else f"{self.substeps} steps an output"
        return f"{self.integrator} {how}" + (", general" if self.general else "")


@dataclass(frozen=True)
class Trade:
    """The question: a checked deck in a mode, variables, repeats of the timing, options of `spacar.run`.

    Without variables, in the stationary modes only, it is about what `spacar.studies.result_quantities` says:
    coordinates and reactions of the nodes of the deck, the lowest frequencies and load multipliers.
    """

    mode: int
    deck: Deck
    variables: tuple[Quantity, ...]
    repeats: int = 3
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def stationary(self) -> bool:
        return find_mode(self.mode).stationary

    def key(self, setup: Setup) -> str:
        """What tells the row of this setup from others."""
        asked = [v.text for v in self.variables]
        return key(self.deck.sha256, self.mode, asked, self.repeats, sorted(self.options.items()), asdict(setup))


@dataclass(frozen=True)
class Job:
    """A setup on its way to a process."""

    trade: Trade
    setup: Setup
    limit: float | None = None  # seconds; a run that takes longer is stopped and has failed


@dataclass(frozen=True)
class Entry:
    """A setup with its cost and error; nan and a reason when it failed. `estimate`: its own estimate of the error."""

    setup: Setup | None
    label: tuple[str, str]  # model, integration
    error: float
    seconds: float
    rhs: int | None
    reason: str = ""
    estimate: float | None = None


@dataclass(frozen=True)
class Reference:
    """Values (variables, times), their estimated error in the norm of the study, and how both came about; names of the
    variables (none: all that a row has, in its order)."""

    values: Array
    amplitude: Array
    error: float
    text: str
    names: tuple[str, ...] = ()


def default_variables(mode: int, deck: Deck) -> tuple[Quantity, ...]:
    """All coordinates that the motion determines: calculable, dynamic, kinematic; none in the stationary modes, where
    more counts than coordinates. Raises UsageError when too many."""
    if find_mode(mode).stationary:
        return ()
    n = build(deck, mode).numbering
    given = {*range(n.x_class["fixed"].stop), *range(n.x_class["input"].start, n.x_class["input"].stop)}
    names = [n.x_owner(i) for i in range(n.nx) if i not in given]
    if not 0 < len(names) <= MOST_VARIABLES:
        text = f"the model has {len(names)} free coordinates; choose with --variable, for instance 'x[3,1]'"
        raise UsageError(text, "study.trade")
    return tuple(quantity(f"x[{node},{c}]") for node, c in names)


def setups(
    trade: Trade, integrators: Sequence[int], tolerances: Sequence[float], substeps: Sequence[int],
    elements: Sequence[int] = (1,), rigid_too: bool = False, linear_too: bool = False,
    perturbation_too: bool = False,
) -> list[Setup]:  # fmt: skip
    """Every model with every integration (stationary modes: every model). Raises UsageError for models or methods that
    do not exist."""
    models = [Setup(n) for n in elements]
    models += [Setup(n, strain="linear") for n in elements] if linear_too else []
    models += [Setup(beams="rigid")] if rigid_too else []
    for n in elements:
        refine(trade.deck, n) if n != 1 else None
    for model in models:
        variant(trade.deck, model)
    if trade.stationary:
        if perturbation_too:
            raise UsageError("the perturbation method is for mode 1", "study.perturbation")
        return models
    found = []
    for model in models:
        for wanted in integrators:
            code, _ = integrator(wanted, "integrator")
            if METHODS[code].variable_step:
                found += [replace(model, integrator=code, tolerance=tol) for tol in tolerances]
            else:
                found += [replace(model, integrator=code, substeps=k) for k in substeps]
        if perturbation_too and model.beams == "flexible":
            require_perturbation(variant(trade.deck, model), **trade.options)
            found += [replace(model, substeps=k, method="perturbation") for k in substeps]
    return found


def reference_setups(
    trade: Trade, elements: Sequence[int], smallest: float, methods: Sequence[int] = REFERENCE_METHODS
) -> list[Setup]:
    """Setups of the reference: two methods at a tight tolerance, and three meshes when meshes are compared.

    `smallest` error (or tolerance) of the study; the reference gets a hundredth of it. Raises UsageError.
    """
    if len(set(methods)) != 2 or not all(c in METHODS and METHODS[c].variable_step for c in methods):
        raise UsageError("the reference takes two different methods with variable step", "usage.trade")
    tight = max(REFERENCE_MARGIN * smallest, REFERENCE_TOLERANCE)
    codes = [None] if trade.stationary else list(methods)
    finest = 4 * -(-2 * max(elements) // 4)
    meshes = [finest, finest // 2, finest // 4] if len(set(elements)) > 1 or trade.stationary else [elements[0]]
    found = []
    for mesh in meshes:
        for code in codes[: 2 if mesh == meshes[0] else 1]:
            tolerance = None if code is None else tight
            found.append(Setup(mesh, integrator=code, tolerance=tolerance))
    return found


def variant(deck: Deck, setup: Setup) -> Deck:
    """The model of a setup. Raises UsageError when the deck has no such variant."""
    if setup.beams == "rigid":
        return rigid(deck)
    if setup.strain == "linear":
        deck = linear_strain(deck)
    return refine_divisible(deck, setup.elements)[0] if setup.elements != 1 else deck


def run_setup(job: Job) -> Row:
    """Run one setup as often as wanted, to a row; a failure is a row with its reason."""
    trade, setup = job.trade, job.setup
    row: Row = {"case": trade.key(setup), **asdict(setup), "status": "failed"}
    try:
        deck = variant(trade.deck, setup)
        options = setup_options(trade, setup, deck)
        seconds = []
        for _ in range(trade.repeats):
            begun = time.process_time()
            result = _run(trade, setup, deck, options, job.limit)
            seconds.append(time.process_time() - begun)
            if job.limit is not None and ((len(seconds) + 1) * seconds[-1] > job.limit or sum(seconds) > LONG):
                break
        found = compared(trade.deck, trade.mode, trade.variables, result)
        row["names"], row["values"] = list(found.names), found.values.tolist()
        row["amplitude"] = [a if np.isfinite(a) else None for a in found.amplitude]
        row["seconds"] = float(np.median(seconds))
        row["rhs"] = int(sum(f.statistics.get("rhs", 0) for f in result.frames))
        row["status"] = "done"
    except Exception as error:
        row["reason"] = explain(error)
    return row


def timed_values(
    trade: Trade, setup: Setup, deck: Deck, options: dict[str, Any], limit: float, names: Sequence[str] = ()
) -> tuple[Array, float]:
    """The variables (variables, times) of one model with these options, and its time [s], the least of three runs.
    Rows of variables that this model does not have are nan; `names` as in `Reference`. Raises SpacarError.
    """
    seconds: list[float] = []
    while not seconds or (len(seconds) < min(trade.repeats, 3) and sum(seconds) < 0.5 * limit):
        begun = time.process_time()
        result = _run(trade, setup, deck, options, limit)
        seconds.append(time.process_time() - begun)
    if not trade.variables:
        found = compared(trade.deck, trade.mode, trade.variables, result)
        return aligned(dict(zip(found.names, found.values, strict=True)), names, len(result.frames)), min(seconds)
    values = np.full((len(trade.variables), len(result.frames)), np.nan)
    for row, variable in zip(values, trade.variables, strict=True):
        with suppress(UsageError):
            row[:] = real_series(variable, result)
    return values, min(seconds)


def _run(trade: Trade, setup: Setup, deck: Deck, options: dict[str, Any], limit: float | None = None) -> Result:
    if setup.method == "perturbation":
        return perturbation(deck, setup.substeps or 1, **options)
    run = frames(trade.mode, deck, **options)
    if limit is None:
        return Result.collect(run)
    end = time.process_time() + limit
    found = []
    for frame in run:
        found.append(frame)
        if time.process_time() > end and len(found) != run.n_frames:
            at = f"at t = {frame.t:.6g}"
            text = f"stopped after {limit:.3g} s {at}: a cheaper setting is better, or the budget is used"
            raise AnalysisError(text, "study.stopped")
    return Result(run.mechanism, trade.mode, tuple(found), tuple(run.report.lines), dict(run.header))


def setup_options(trade: Trade, setup: Setup, deck: Deck) -> dict[str, Any]:
    """Options of the run of a setup."""
    options = dict(trade.options)
    if setup.measure:
        options["beams"] = setup.measure
    if setup.general:
        options["compiled"] = False
    if setup.integrator is not None:
        given = build(deck, trade.mode, **options).settings
        options["integrator"] = setup.integrator
        if setup.tolerance is not None:
            ratio = given.atol / given.rtol if given.rtol > 0.0 else 1.0
            options |= {"rtol": setup.tolerance, "atol": setup.tolerance * ratio}
        elif given.duration is not None:
            options["step"] = given.duration / given.n_steps / (setup.substeps or 1)
    return options


def reference(
    trade: Trade, rows: Sequence[Row], wanted: Sequence[Setup], integration: tuple[float, str] | None = None
) -> Reference:
    """The reference of the rows of `wanted` and its estimated error: two methods on one of the meshes (unless the error
    of the `integration` is given, and how it is known), two or three meshes, each twice as fine as the one before.

    Raises AnalysisError.
    """
    by_key = {row["case"]: row for row in rows}
    found = [(s, by_key.get(trade.key(s))) for s in wanted]
    good = {s: row for s, row in found if row is not None and row["status"] == "done"}
    meshes = sorted({s.elements for s in wanted})
    first = {n: next((row for s, row in good.items() if s.elements == n), None) for n in meshes}
    finest = first[meshes[-1]]
    if finest is None or any(row is None for row in first.values()):
        reasons = [str(row["reason"]) for _, row in found if row is not None and row.get("reason")]
        raise AnalysisError(f"the reference could not be computed: {'; '.join(reasons)}", "study.reference")
    names = tuple(name for name in finest["names"] if all(name in row["names"] for row in first.values() if row))
    values = [row_values(row, names) for row in first.values() if row is not None]
    best = values[-1]
    scale = dict(zip(finest["names"], finest["amplitude"], strict=True))
    amplitude = np.array([np.inf if scale[name] is None else scale[name] for name in names])
    error, words = 0.0, []
    if integration is not None:
        error, text = integration
        words.append(text)
    elif not trade.stationary:
        tight = next(s.tolerance for s in wanted)
        pair = next(([s for s in good if s.elements == n] for n in meshes if _methods(good, n) > 1), None)
        if pair is None:
            text = "only one of the two methods reached the reference; choose a shorter time"
            raise AnalysisError(text, "study.reference")
        one, other = (row_values(good[s], names) for s in pair[:2])
        error = distance(one, other, amplitude)
        codes = " and ".join(str(s.integrator) for s in pair[:2])
        words.append(f"methods {codes} at tolerance {tight:.3g} differ by {error:.2e}")
    if len(meshes) > 1:
        seen = ", ".join(map(str, meshes))
        if len(meshes) == 2:
            last = distance(values[-1], values[-2], amplitude)
            how = f"which differ by {last:.2e}"
        else:
            coarse, middle, fine = values[-3:]
            result = extrapolate_rows(coarse, middle, fine, amplitude)
            best, last = result.values, float(result.errors.max(initial=0.0))
            orders = [int(np.sum(result.order == p)) for p in (4, 2, 0)]
            told = zip(orders, ("with order 4", "with order 2", "not"), strict=True)
            how = f"variables extrapolated: {', '.join(f'{k} {how}' for k, how in told if k)}, "
            how += f"estimated error {last:.2e}"
            if len(set(result.order.tolist())) == 1 and result.order.all():  # an order that all share is no accident
                whole = extrapolate(coarse, middle, fine, amplitude)
                best, last, how = whole.values, whole.error, whole.text
        error += last
        words.append(f"meshes {seen} elements a beam, {how}")
    return Reference(best, amplitude, error, "; ".join(words), names)


def _methods(good: Mapping[Setup, Row], elements: int) -> int:
    return len({s.integrator for s in good if s.elements == elements})


def assess(
    trade: Trade, rows: Sequence[Row], wanted: Sequence[Setup], ref: Reference, extrapolated: bool = True
) -> list[Entry]:
    """Entries of the setups, and (`extrapolated`) in the stationary modes of every three meshes n, 2n, 4n of them."""
    by_key = {row["case"]: row for row in rows}
    entries = []
    values: dict[Setup, tuple[Array, float]] = {}
    for setup in wanted:
        row = by_key[trade.key(setup)]
        label = (setup.model, setup.integration)
        if row["status"] != "done":
            entries.append(Entry(setup, label, float("nan"), float("nan"), None, str(row["reason"])))
            continue
        found = row_values(row, ref.names)
        values[setup] = found, row["seconds"]
        rhs, error = row["rhs"] or None, distance(found, ref.values, ref.amplitude)
        reason = "it has not all frequencies or load multipliers of the finer meshes" if np.isnan(error) else ""
        entries.append(Entry(setup, label, error, row["seconds"], rhs, reason))
    if trade.stationary and extrapolated:
        entries += _extrapolated(values, ref)
    return entries


def _extrapolated(values: dict[Setup, tuple[Array, float]], ref: Reference) -> list[Entry]:
    entries = []
    for setup in values:
        chain = [replace(setup, elements=k * setup.elements) for k in (1, 2, 4)]
        if setup.beams == "rigid" or not all(s in values for s in chain):
            continue
        coarse, middle, fine = (values[s][0] for s in chain)
        result = extrapolate(coarse, middle, fine, ref.amplitude)
        label = f"{', '.join(str(s.elements) for s in chain)} elements a beam, extrapolated"
        label += f", {setup.measure} measure" if setup.measure else ""
        label += ", linear strain" if setup.strain == "linear" else ""
        cost = sum(values[s][1] for s in chain)
        error = distance(result.values, ref.values, ref.amplitude)
        entries.append(Entry(None, (label, ""), error, cost, None, estimate=result.error))
    return entries


def recommend(entries: Sequence[Entry], target: float, ref: Reference) -> Entry | None:
    """The cheapest entry whose error, together with that of the reference, is within the target."""
    good = [e for e in entries if e.error + ref.error <= target]
    return min(good, key=lambda e: e.seconds, default=None)
