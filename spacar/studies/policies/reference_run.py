"""The reference of a trade within a time: the ladder of tolerances, or of meshes, that `--accuracy` climbs, to JUDGE of
the target. Where vibrations that the implicit methods pass over keep that from it, once more with explicit ones.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from spacar.calls import frames
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError
from spacar.stream import Run
from spacar.studies.policies.mesh import MeshSearch
from spacar.studies.policies.trade import Reference
from spacar.studies.runs.record import Computed
from spacar.studies.runs.setting import Setup, Trade, variant
from spacar.studies.runs.tolerance_ladder import EXPENSIVE, ToleranceLadder

STEPS = (EXPENSIVE, 30 * EXPENSIVE)  # of stability, up to which methods are explicit, one after the other
JUDGE, ENOUGH = 0.1, 0.3  # error of the reference over the target: asked for, and enough to be a judge
LEAST = 1.0  # seconds that must be left for the second


def best_reference(
    trade: Trade, run: Run, beams: tuple[int, ...], target: float, left: Callable[[], float]
) -> tuple[Reference, list[Computed]]:
    """The reference, and the meshes from coarse to fine that it was extrapolated from; `left` is the time for it [s].

    Raises AnalysisError when there is none within the time.
    """
    best: tuple[Reference, list[Computed]] | None = None
    for steps in STEPS:
        try:
            found = _reached(trade, run, beams, JUDGE * target, time.process_time() + left(), steps)
        except AnalysisError:
            if best is None:
                raise
            break
        if best is None or found[0].error < best[0].error:
            best = found
        if best[0].error <= ENOUGH * target or trade.stationary or left() < LEAST:
            break
    assert best is not None
    return best


def _reached(
    trade: Trade, run: Run, beams: tuple[int, ...], target: float, end: float, steps: float
) -> tuple[Reference, list[Computed]]:
    """With explicit methods up to so many steps, up to the processor time `end`. Raises AnalysisError."""
    if not beams:
        last, before = ToleranceLadder(run, trade.variables, end=end, most_steps=steps).climb(target)
        text = f"methods {before.attempt} and {last.attempt} differ by {last.attempt.difference:.2e}"
        return Reference(last.found.values, last.found.amplitude, last.error, text, last.found.names), []
    study = MeshSearch(run, beams, trade.variables, end=end, most_steps=steps)
    result = study.refined(target)
    if result.rows is None:
        text = f"the reference needs two meshes at least, and more budget (--budget): {result.way}"
        raise AnalysisError(text, "study.reference")
    finest, own = result.finest.found, study.meshes[0].found.names
    rows = [i for i, name in enumerate(finest.names) if np.isfinite(finest.amplitude[i]) and name in own]
    names = tuple(finest.names[i] for i in rows)
    found = Reference(result.rows.values[rows], finest.amplitude[rows], result.estimate, result.way, names)
    return found, [mesh for mesh in study.meshes if len(set(mesh.pieces.values())) == 1]


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
