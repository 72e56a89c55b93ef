"""`--accuracy`: the error of a result, estimated while it is computed, and kept below what is asked for.

Of the integration by `spacar.studies.runs.tolerance_ladder`, of the mesh by `spacar.studies.policies.mesh`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.frame import Frame
from spacar.stream import AccuracyRequest, Run
from spacar.studies.policies.mesh import MeshSearch, divisible, undivided
from spacar.studies.runs.quantities import quantity
from spacar.studies.runs.tolerance_ladder import SMALL, Attempt, Computed, ToleranceLadder


@dataclass(frozen=True)
class Accuracy:
    """What is known of the error of a result, in amplitudes. `run.header["accuracy"]`.

    target    that was asked for; None: the error is only measured
    estimate  of the error of the frames, nan when there is none
    until     time up to which the target is met [s], None when it is met throughout or not asked for
    pieces    beams in the place of each beam of the model in the result; empty: the mesh is that of the model
    cost      processor time of all runs over that of the last one;  way  how the estimate came about, in words
    """

    target: float | None
    estimate: float
    cost: float
    way: str
    until: float | None = None
    attempts: tuple[Attempt, ...] = ()
    pieces: dict[int, int] = field(default_factory=dict)
    runs: int = 1  # of all meshes

    @property
    def met(self) -> bool | None:
        """Is the target met? None without one."""
        return None if self.target is None else bool(self.estimate <= self.target)

    def record(self) -> dict[str, Any]:
        """Plain numbers and words, for JSON."""
        known = np.isfinite(self.estimate)
        return {
            "target": self.target, "estimate": self.estimate if known else None, "met": self.met, "until": self.until,
            "cost": self.cost, "way": self.way, "runs": [vars(a) for a in self.attempts],
            "pieces": {str(beam): n for beam, n in self.pieces.items()},
        }  # fmt: skip

    def lines(self) -> list[str]:
        """For the log; a warning when the target is missed."""
        known = f"{self.estimate:.2e} of the amplitudes" if np.isfinite(self.estimate) else "not known"
        found = f"estimated error of the result: {known} ({self.way})"
        if self.runs > 1:
            found += f"; {self.runs} runs, {self.cost:.2g} times the time of the last one"
        if self.target is None:
            return [f"information: {found}"]
        if self.met:
            return [f"information: accuracy {self.target:.3g} is met, {found}"]
        till = f"; it is met until t = {self.until:.6g} s" if self.until else ""
        return [f"warning: accuracy {self.target:.3g} is not met, {found}{till}"]


def frames(run: Run) -> Iterator[Sequence[Frame]]:
    """Frames with `xerr`, and `header["accuracy"]`, of a run whose accuracy is asked for. Raises as its mode does."""
    request = run.accuracy or AccuracyRequest()
    variables = tuple(quantity(v) for v in request.variables)
    beams, reasons = divisible(run) if request.mesh else ((), {})
    if beams:
        yield from _of_meshes(run, MeshSearch(run, beams, variables), reasons)
    elif not run.mode.stationary and run.mechanism.settings.duration and run.mechanism.numbering.nkddof:
        yield from _of_tolerances(run, ToleranceLadder(run, variables))
    else:
        estimate, way = 0.0, "nothing is integrated"
        if run.mode.stationary:
            estimate, way = (np.nan, undivided(reasons)) if reasons else (0.0, "there are no flexible beams to refine")
        run.header["accuracy"] = found = Accuracy(request.target, estimate, 1.0, way)
        if run.mode.stationary:
            _tell(run, found.lines())
        yield from replace(run, accuracy=None, report=run.report, header=run.header).blocks()


def _of_tolerances(run: Run, ladder: ToleranceLadder) -> Iterator[Sequence[Frame]]:
    """Modes 1 and 4 on the mesh of the user."""
    target = run.accuracy.target if run.accuracy else None
    shown, before = ladder.measured() if target is None else ladder.climb(target)
    difference = shown.attempt.difference or 0.0
    way, until = f"method {shown.attempt} against method {before.attempt} differ by {difference:.2e}", None
    if target is not None and shown.error > target:
        away = (np.abs(shown.found.values - before.found.values) / shown.found.amplitude[:, None]).max(axis=0) > target
        settings = run.mechanism.settings
        first = int(np.argmax(away)) - 1 if away.any() else 0
        until = max(first, 0) * (settings.duration or 0.0) / max(settings.n_steps, 1)
        way += "; more accuracy is not to be had: the tolerance is at the limit of rounding"
        if shown.error > SMALL:
            way += ", the motion magnifies small changes (chaos)"
    bars = np.maximum.accumulate(np.abs(shown.x - before.x), axis=0)
    bars *= shown.error / difference if difference > 0.0 else 1.0
    attempts = tuple(ladder.attempts)
    cost = sum(a.seconds for a in attempts) / max(shown.attempt.seconds, 1e-9)
    found = Accuracy(target, float(shown.error), float(cost), way, until, attempts, runs=len(attempts))
    yield from _shown(run, found, shown, shown.frames, bars)


def _of_meshes(run: Run, search: MeshSearch, reasons: dict[int, str]) -> Iterator[Sequence[Frame]]:
    """Stationary modes and motions with the error of the mesh."""
    target = run.accuracy.target if run.accuracy else None
    found = search.measured() if target is None or run.mode.third else search.refined(target)
    own, last = search.meshes[0], found.finest
    cost = sum(m.attempt.seconds for m in search.meshes) / max(last.attempt.seconds, 1e-9)
    pieces = {} if found.frames is own.frames else {b: n for b, n in last.pieces.items() if n > 1}
    way = found.way + (f"; without {undivided(reasons)}" if reasons else "")
    attempts = () if run.mode.stationary else tuple(search.attempts)
    record = Accuracy(target, found.estimate, float(cost), way, None, attempts, pieces, len(search.meshes))
    note = "information: matrices of the linearized equations (m0, k0 ...) and transfer functions are those of the"
    note += " mesh of the model; coordinates, stresses, eigenvalues and load multipliers those of the refined one"
    notes = [note] if pieces and run.mode.linearized else []
    yield from _shown(run, record, own, found.frames, found.bars, *notes)


def _shown(
    run: Run, found: Accuracy, own: Computed, kept: Sequence[Frame] | None, bars: Array, *notes: str
) -> Iterator[Sequence[Frame]]:
    """Report, header and frames; those of mode 4, or that were not kept, are computed with the settings that were
    chosen."""
    run.header["accuracy"] = found
    run.mechanism, run.n_frames = own.run.mechanism, len(bars)
    lines = own.run.report.lines
    if kept is None or (run.mode.integrated and run.mode.linearized):
        kept_or_made: Iterator[Frame] = iter(replace(run, accuracy=None, mechanism=run.mechanism))
        lines = []  # it reports itself
    else:
        run.header |= own.run.header
        kept_or_made = iter(kept)
    _tell(run, [*lines, *found.lines(), *notes])
    for frame, error in zip(kept_or_made, bars, strict=True):
        frame.xerr = error
        yield (frame,)


def _tell(run: Run, lines: Sequence[str]) -> None:
    for line in lines:
        run.report.add(line)
