"""The error of the result of modes 1 and 4, estimated while it is computed, and kept below what is asked for.

The error is that of `spacar.studies.error_norm` over the free coordinates, or over chosen expressions. It is estimated
from two runs u, v of different methods, so that they do not share an error: |u - v| = |e_u - e_v| is about the error of
the worse one, and bounds that of the better one. With the error of step control in proportion to the tolerance
(Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", section II.4) the next tolerance follows from the
last estimate. What is gained by it is trusted only to its square root, and only when the differences fall; two errors
that happen to be alike are found by the difference before, reduced in proportion to the tolerances. With
d_k = |u_k - u_(k-1)| and g_k = tau_k / tau_(k-1):

    e_k = max(d_k max(0.01, sqrt(g_k)), d_(k-1) g_(k-1) g_k)  where d_k < d_(k-1);    otherwise e_k = d_k

The next tolerance is the largest for which this will be MARGIN of the target if d_(k+1) is d_k g_k.

The absolute error of a run is its tolerance times the largest motion of lengths or of rotations, the smaller one, or
times the ratio of ERROR, whatever is less. The first run tells how large these are; when its absolute error turns out
to be more than SMALLEST of them it is made again.

Explicit methods, 0 in turn with 853, are taken while the highest frequency of the
model allows it: rho T / STABLE steps, rho the largest eigenvalue of the start state. Beyond EXPENSIVE steps it is 553
and then 595 (Radau of orders 5 and 9). Both damp vibrations that they do not resolve, so they could err alike: three
runs at least are demanded of them, over which the differences must fall.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError
from spacar.forward.driver import has_forces
from spacar.forward.extent import Extent
from spacar.frame import Frame
from spacar.integrators.methods import AUTOMATIC, METHODS
from spacar.linearization.state_jacobian import state_jacobian
from spacar.mechanism import Mechanism
from spacar.modes import find_mode
from spacar.stream import AccuracyRequest, Run
from spacar.studies.error_norm import amplitudes, distance
from spacar.studies.quantities import Quantity, quantity
from spacar.studies.result_quantities import assessed, free_coordinates

EXPLICIT, STIFF = (0, 853), (553, 595)
STABLE = 5.0  # h rho at which method 853 leaves its region of stability on the imaginary axis, about
EXPENSIVE = 10_000  # steps of stability beyond which implicit methods are taken
LARGEST_JACOBIAN = 600  # states; above, its eigenvalues take longer than a short run, and implicit methods are taken
LOOSEST, TIGHTEST = 1e-3, 2e-13  # tolerances that are tried; with looser ones two errors may be alike by chance
FIRST = 10.0  # tolerance of the first run over the target (a step of mechanisms errs by a hundredth of ERROR)
GAIN = 4.0  # of the second tolerance over the first
SMALLEST = 0.1  # absolute error of the first run over tolerance times motion, above which it says nothing
MARGIN = 0.5  # of the target that the next run aims at
FURTHEST = 1e-4  # tolerance of the next run over the last one, at least
TRUSTED = 0.01  # least estimate over the last difference, however fast the differences fall
STALLED, SMALL = 0.3, 1e-4  # differences below SMALL that fall by less than STALLED are rounding
KEPT = 2**28  # bytes of frames that are held in memory; of more, the last run is made twice
UNRESOLVED = 1e-8  # relative tolerance of the run that checks another one with fixed steps


@dataclass(frozen=True)
class Attempt:
    """One run: method, its relative ERROR (None: fixed steps), what it cost, its difference from the one before."""

    integrator: int
    tolerance: float | None
    rhs: int
    seconds: float
    difference: float | None = None
    reason: str = ""  # why it failed


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
    runs: int = 0  # of all meshes; 0: as many as there are attempts

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
        runs = self.runs or len(self.attempts)
        if runs > 1:
            found += f"; {runs} runs, {self.cost:.2g} times the time of the last one"
        if self.target is None:
            return [f"information: {found}"]
        if self.met:
            return [f"information: accuracy {self.target:.3g} is met, {found}"]
        till = f"; it is met until t = {self.until:.6g} s" if self.until else ""
        return [f"warning: accuracy {self.target:.3g} is not met, {found}{till}"]


@dataclass
class Computed:
    """The values of a run: variables (variables, times), coordinates x (times, nx), and its frames where they fit."""

    run: Run
    attempt: Attempt
    values: Array
    x: Array
    frames: list[Frame] | None


@dataclass
class Search:
    """Runs of one model with several methods and tolerances.

    `view`: frame and its number to the frame whose values count, of the mechanism `shown`; None: frames as they are.
    `hold`: keep the frames whatever their size.
    """

    run: Run
    variables: tuple[Quantity, ...]
    attempts: list[Attempt] = field(default_factory=list)
    view: Callable[[Frame, int], Frame] | None = None
    shown: Mechanism | None = None
    hold: bool = False
    ratio: float | None = None  # of the absolute error over the tolerance, that the motion asks for
    coarse: bool = False  # the last run had one that was much larger

    def compute(self, integrator: int, tolerance: float | None) -> Computed:
        """One run in mode 1; `tolerance` None: with the settings of the file. Raises AnalysisError."""
        mechanism = self.run.mechanism
        settings = mechanism.settings
        if tolerance is not None:
            ratio = settings.atol / settings.rtol if settings.rtol > 0.0 else 1.0
            ratio = ratio if self.ratio is None else min(ratio, self.ratio)
            atol = tolerance * ratio
            settings = replace(settings, integrator=integrator, rtol=tolerance, atol=atol, step=None)
        run = Run(find_mode(1), replace(mechanism, settings=settings))
        begun = time.process_time()
        rhs, frames, x = 0, [], []
        held = self.hold or bool(self.variables) or _size(run) <= KEPT
        try:
            for i, computed in enumerate(run):
                frame = computed if self.view is None else self.view(computed, i)
                rhs += frame.statistics.get("rhs", 0)
                x.append(frame.x)
                if held:
                    frames.append(frame)
        except AnalysisError as error:
            seconds = time.process_time() - begun
            self.attempts.append(Attempt(integrator, tolerance, rhs, seconds, reason=str(error)))
            raise
        attempt = Attempt(integrator, tolerance, rhs, time.process_time() - begun)
        self.attempts.append(attempt)
        coordinates, shown = np.array(x), self.shown or run.mechanism
        if tolerance is not None and held:
            extent = Extent(shown)
            extent.take(frames)
            least = min(extent.sizes().values(), default=np.inf)
            self.coarse, self.ratio = SMALLEST * ratio > least, min(least, ratio)
        if self.variables:
            values = assessed(shown, 1, frames, self.variables, stationary=False).values
        else:
            values = coordinates[:, free_coordinates(shown)].T
        return Computed(run, attempt, values, coordinates, frames if held else None)

    def compare(self, now: Computed, before: Computed) -> float:
        """The difference of two runs in the norm, noted with the later one."""
        d = distance(now.values, before.values, amplitudes(now.values, stationary=False))
        self.attempts[-1] = replace(self.attempts[-1], difference=d)
        return d


def forward(run: Run) -> Iterator[Sequence[Frame]]:
    """Frames of mode 1 or 4 within the error that `run.accuracy` asks for, with its estimate in `xerr`. Raises as these
    modes do."""
    request, settings = run.accuracy or AccuracyRequest(), run.mechanism.settings
    plain = replace(run, accuracy=None, report=run.report, header=run.header)
    if settings.duration is None or not run.mechanism.numbering.nkddof:
        run.header["accuracy"] = Accuracy(request.target, 0.0, 1.0, "nothing is integrated")
        yield from plain.blocks()
        return
    search = Search(run, tuple(quantity(v) for v in request.variables))
    methods = STIFF if stiff(run) else EXPLICIT
    if request.target is None:
        shown, before, estimate, difference = measured(search, methods)
    else:
        shown, before, estimate, difference = tightened(search, methods, request.target)
    error = np.maximum.accumulate(np.abs(shown.x - before.x), axis=0)
    error *= estimate / difference if difference > 0.0 else 1.0
    run.header["accuracy"] = found = _accuracy(search, request.target, shown, before, estimate, difference)
    run.mechanism, run.n_frames = shown.run.mechanism, len(shown.x)
    for line in found.lines():
        run.report.add(line)
    if shown.frames is None or run.mode.linearized:
        again = replace(plain, mechanism=run.mechanism)
        frames: Iterator[Frame] = iter(again)
    else:
        run.header |= shown.run.header
        for line in shown.run.report.lines:
            run.report.add(line)
        frames = iter(shown.frames)
    for frame, bars in zip(frames, error, strict=True):
        frame.xerr = bars
        yield (frame,)


def stiff(run: Run) -> bool:
    """Would explicit methods follow the highest frequency of the start state in too many small steps?"""
    mechanism, duration = run.mechanism, run.mechanism.settings.duration
    evaluator = Dynamics(mechanism)
    if not has_forces(evaluator.model):
        return False
    y = evaluator.start()
    if len(y) > LARGEST_JACOBIAN:
        return bool(mechanism.stiffness[2].any())
    jacobian, _ = state_jacobian(evaluator, 0.0, y)
    fastest = float(np.abs(np.linalg.eigvals(jacobian)).max(initial=0.0))
    return fastest * (duration or 0.0) / STABLE > EXPENSIVE


def measured(search: Search, methods: tuple[int, int]) -> tuple[Computed, Computed, float, float]:
    """The run of the file's settings, the one that checks it, the estimated error of the first, their difference."""
    settings = search.run.mechanism.settings
    row = METHODS[settings.integrator]
    shown = search.compute(row.code, None)
    same = (methods[1], AUTOMATIC) if methods == STIFF else (methods[1],)  # it may have changed to that one
    check = methods[0] if row.code in same else methods[1]
    tolerance = settings.rtol / GAIN if row.variable_step and settings.rtol > 0.0 else UNRESOLVED
    other = search.compute(check, max(tolerance, TIGHTEST))
    difference = search.compare(shown, other)
    return shown, other, difference, difference


def tightened(search: Search, methods: tuple[int, int], target: float) -> tuple[Computed, Computed, float, float]:
    """As `measured`, of the last of a sequence of runs that ends when its estimated error is within the target."""
    turn = 0
    tolerance = min(max(FIRST * target, TIGHTEST * GAIN), LOOSEST)
    before: Computed | None = None
    last, gained_before, wanted = np.inf, 1.0, 2 if methods == EXPLICIT else 3
    while True:
        code = methods[turn % 2] if methods == EXPLICIT else methods[min(turn, 1)]
        turn += 1
        try:
            now = search.compute(code, tolerance)
        except AnalysisError:
            # A loose tolerance may leave the range of the model where a tight one does not.
            if tolerance <= TIGHTEST or sum(bool(a.reason) for a in search.attempts) > 1:
                raise
            tolerance = max(tolerance / GAIN**2, TIGHTEST)
            continue
        if before is None and search.coarse:
            search.coarse = False
            turn -= 1
            continue
        if before is None:
            before, tolerance = now, max(tolerance / GAIN, TIGHTEST)
            continue
        difference = search.compare(now, before)
        gained = (now.attempt.tolerance or 1.0) / (before.attempt.tolerance or 1.0)
        falls = difference < last < np.inf
        estimate = difference
        if falls:
            estimate = max(difference * max(TRUSTED, gained**0.5), last * gained_before * gained)
        enough = sum(not a.reason for a in search.attempts) >= wanted
        rounding = difference < SMALL and difference > STALLED * last
        if (estimate <= target and enough) or tolerance <= TIGHTEST or rounding:
            return now, before, estimate if estimate <= target else difference, difference
        before, last, gained_before = now, difference, gained
        wish = (MARGIN * target / max(difference * gained, MARGIN * target)) ** 2
        tolerance = max(tolerance * min(max(wish, FURTHEST), 1.0 / GAIN), TIGHTEST)


def _accuracy(
    search: Search, target: float | None, shown: Computed, before: Computed, estimate: float, difference: float
) -> Accuracy:
    """The record of a search."""
    a, b = before.attempt, shown.attempt
    way = f"method {_words(b)} against method {_words(a)} differ by {difference:.2e}"
    until = None
    if target is not None and estimate > target:
        amplitude = amplitudes(shown.values, stationary=False)
        away = (np.abs(shown.values - before.values) / amplitude[:, None]).max(axis=0) > target
        t = search.run.mechanism.settings
        first = int(np.argmax(away)) - 1 if away.any() else 0
        until = max(first, 0) * (t.duration or 0.0) / max(t.n_steps, 1)
        way += "; more accuracy is not to be had: the tolerance is at the limit of rounding"
        if estimate > SMALL:
            way += ", the motion magnifies small changes (chaos)"
    cost = sum(x.seconds for x in search.attempts) / max(b.seconds, 1e-9)
    return Accuracy(target, float(estimate), float(cost), way, until, tuple(search.attempts))


def _words(attempt: Attempt) -> str:
    how = "with the settings of the file" if attempt.tolerance is None else f"with ERROR {attempt.tolerance:.2g}"
    return f"{attempt.integrator} {how}"


def _size(run: Run) -> int:
    """Bytes of the frames of a run, about."""
    n = run.mechanism.numbering
    columns = 1 + n.ndof * (run.mechanism.settings.sbd_level or 0)
    return 8 * (run.mechanism.settings.n_steps + 1) * (6 * n.nx + 4 * n.ne) * columns
