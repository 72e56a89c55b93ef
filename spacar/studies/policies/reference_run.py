"""The reference of a trade within a time: the ladder of tolerances, or of meshes, that `--accuracy` climbs, to JUDGE of
the target.
"""

import time

import numpy as np

from spacar.calls import frames
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError
from spacar.stream import Run
from spacar.studies.policies.mesh import MeshSearch
from spacar.studies.policies.trade import Reference
from spacar.studies.runs.record import Computed
from spacar.studies.runs.setting import Setup, Trade, variant
from spacar.studies.runs.tolerance_ladder import ToleranceLadder

JUDGE = 0.1  # error of the reference over the target


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
