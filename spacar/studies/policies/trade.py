"""The rows of a trade against a reference: which settings that has, how good it is, the errors of all others.

The reference is computed by two methods at a tight tolerance, and by four meshes when meshes are compared, which are
extrapolated (`spacar.studies.runs.mesh_ladder`); what is known of its error counts as error of every other setting.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError, UsageError
from spacar.integrators.methods import METHODS
from spacar.studies.runs.compared import GENERAL, row_values
from spacar.studies.runs.mesh_ladder import extrapolate
from spacar.studies.runs.result_quantities import distance
from spacar.studies.runs.rows import Row
from spacar.studies.runs.setting import Setup, Trade

REFERENCE_METHODS = (853, 0)
REFERENCE_TOLERANCE = 1e-12  # smallest
REFERENCE_MARGIN = 0.01  # tolerance of the reference / smallest error that is looked at


class Entry(NamedTuple):
    """A setup with its cost and error; nan and a reason when it failed. `estimate`: its own estimate of the error."""

    setup: Setup | None
    label: tuple[str, str]  # model, integration
    error: float
    seconds: float
    rhs: int | None
    reason: str = ""
    estimate: float | None = None


class Reference(NamedTuple):
    """Values (variables, times), their estimated error in the norm of the study, and how both came about; names of the
    variables (none: all that a row has, in its order)."""

    values: Array
    amplitude: Array
    error: float
    text: str
    names: tuple[str, ...] = ()


def reference_setups(
    trade: Trade, elements: Sequence[int], smallest: float, methods: Sequence[int] = REFERENCE_METHODS
) -> list[Setup]:
    """Setups of the reference: two methods at a tight tolerance, and four meshes when meshes are compared.

    `smallest` error (or tolerance) of the study; the reference gets a hundredth of it. Raises UsageError.
    """
    if len(set(methods)) != 2 or not all(c in METHODS and METHODS[c].variable_step for c in methods):
        raise UsageError("the reference takes two different methods with variable step", "usage.trade")
    tight = max(REFERENCE_MARGIN * smallest, REFERENCE_TOLERANCE)
    several = len(set(elements)) > 1 or trade.stationary
    coarsest = -(-max(elements) // 4)
    meshes = [k * coarsest for k in (8, 4, 2, 1)] if several else [elements[0]]
    if trade.stationary:
        return [Setup(mesh) for mesh in meshes]
    first, *others = [Setup(mesh, integrator=methods[0], tolerance=tight) for mesh in meshes]
    return [first, replace(first, integrator=methods[1]), *others]


def reference(trade: Trade, rows: Sequence[Row], wanted: Sequence[Setup]) -> Reference:
    """The reference of the rows of `wanted` and its estimated error: two methods on one of the meshes, two or three
    meshes, each twice as fine as the one before. Raises AnalysisError."""
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
    if not trade.stationary:
        tight = next(s.tolerance for s in wanted)
        of_mesh = ([s for s in good if s.elements == n] for n in meshes)
        pair = next((setups for setups in of_mesh if len({s.integrator for s in setups}) > 1), None)
        if pair is None:
            text = "only one of the two methods reached the reference; choose a shorter time"
            raise AnalysisError(text, "study.reference")
        one, other = (row_values(good[s], names) for s in pair[:2])
        error = distance(one, other, amplitude)
        codes = " and ".join(str(s.integrator) for s in pair[:2])
        words.append(f"methods {codes} at tolerance {tight:.3g} differ by {error:.2e}")
    if len(meshes) > 1:
        seen = ", ".join(map(str, meshes))
        result = extrapolate(values, amplitude)
        best, last = result.values, result.error
        how = f"which differ by {last:.2e}"
        if len(meshes) > 2:
            how = f"variables extrapolated: {result.orders()}, estimated error {last:.2e}"
        error += last
        words.append(f"meshes {seen} elements a beam, {how}")
    return Reference(best, amplitude, error, "; ".join(words), names)


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
            entries.append(Entry(setup, label, np.nan, np.nan, None, str(row["reason"])))
            continue
        values[setup] = row_values(row, ref.names), row["seconds"]
        error, reason = row_error(row, ref, trade)
        entries.append(Entry(setup, label, error, row["seconds"], row["rhs"] or None, reason))
    if trade.stationary and extrapolated:
        entries += _extrapolated(values, ref)
    return entries


def row_error(row: Row, ref: Reference, trade: Trade) -> tuple[float, str]:
    """The error of a finished row; inf, and why, when it lacks what counts: a frequency, a load multiplier, a variable
    that the user named. A node that it does not have is no loss."""
    values = row_values(row, ref.names)
    there = np.asarray(np.isfinite(values).all(axis=1))
    lost = [name for name, has in zip(ref.names, there.tolist(), strict=False) if not has]
    if not there.any() or any(word in name for name in lost for word in GENERAL):
        return np.inf, "it has not all frequencies or load multipliers of the finer meshes"
    if lost and trade.named:
        return np.inf, f"it has no {lost[0]}"
    return distance(values[there], ref.values[there], ref.amplitude[there]), ""


def _extrapolated(values: dict[Setup, tuple[Array, float]], ref: Reference) -> list[Entry]:
    entries = []
    for setup in values:
        chain = [replace(setup, elements=k * setup.elements) for k in (1, 2, 4)]
        if setup.beams == "rigid" or not all(s in values for s in chain):
            continue
        result = extrapolate([values[s][0] for s in chain], ref.amplitude)
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
