"""The error of the integration: runs of one motion with tolerances that fall.

With the error of step control in proportion to the tolerance (Hairer, Norsett, Wanner, "Solving Ordinary Differential
Equations I", section II.4) the difference d_k = |u_k - u_(k-1)| of two runs is about the error of the looser one, and
that of the tighter one d_k g_k, g_k = tau_k / tau_(k-1). What is gained is trusted only to its square root, of an
implicit run, whose steps pass over what is fast, to the fourth root, and not at all when the differences do not fall:

    e_k = max(d_k max(TRUSTED, g_k^r), ALIKE d_(k-1) g_(k-1) g_k) where d_k < d_(k-1), or of the first two runs,
    e_k = d_k else, and never more;  r = 1/2, 1/4

Error norm and amplitudes: `spacar.studies.runs.result_quantities`. The method chooses itself as long as it is implicit
somewhere; tighter tolerances need that less.

The absolute error of a run is its tolerance times the largest motion of lengths or of rotations, the smaller one, or
times the ratio of ERROR, whatever is less. The first run tells how large these are; when its absolute error turns out
to be more than SMALLEST of them it is made again.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError
from spacar.forward.motion import Extent
from spacar.frame import Frame
from spacar.integrators.methods import AUTOMATIC, METHODS
from spacar.mechanism import Mechanism
from spacar.modes import find_mode
from spacar.stream import Run
from spacar.studies.runs.quantities import Quantity
from spacar.studies.runs.result_quantities import Assessed, assessed, coordinates, distance

EXPLICIT = 0
LOOSEST, TIGHTEST = 0.03, 2e-13  # tolerances that are tried
FIRST = 30.0  # tolerance of the first run over the target; a step errs by less than ERROR
GAIN = 30.0  # of the second tolerance over the first; and of the file's over that of the run that checks it
SMALLEST = 0.1  # absolute error of the first run over tolerance times motion, above which it says nothing
MARGIN = 0.5  # of the target that the next run aims at
NEAREST, FURTHEST = 0.1, 1e-3  # tolerance of the next run over the last one, at most and at least
ALIKE = 3.0  # of the difference before, reduced as the tolerances: two errors may be alike by chance
TRUSTED = 0.01  # least estimate over the last difference, however fast the differences fall
STALLED, SMALL = 0.3, 1e-4  # differences below SMALL that fall by less than STALLED are rounding ...
ROUNDED = 1e-8  # ... at tolerances below this
UNRESOLVED = 1e-8  # relative tolerance of the run that checks another one with fixed steps

KEPT = 2**28  # bytes of frames that are held in memory; of more, the last run is made twice
View = Callable[[Frame, int], Frame]


@dataclass
class Attempt:
    """Method, its relative ERROR (None: as the file has it), what the run cost, its difference from the one before."""

    integrator: int
    tolerance: float | None
    rhs: int = 0
    seconds: float = 0.0
    difference: float | None = None
    reason: str = ""  # why it failed

    def __str__(self) -> str:
        how = "with the settings of the file" if self.tolerance is None else f"with ERROR {self.tolerance:.2g}"
        return f"{self.integrator} {how}"


@dataclass
class Computed:
    """A finished run on the mesh `pieces` (beams in the place of each): its frames where they fit, coordinates x
    (times, nx), what is compared, the error of its integration where that is known; was it implicit anywhere?"""

    run: Run
    attempt: Attempt
    x: Array
    frames: list[Frame] | None
    found: Assessed
    pieces: dict[int, int] = field(default_factory=dict)
    error: float = 0.0
    implicit: bool = False

    def distance(self, other: "Computed") -> float:
        """In the norm of the study."""
        return distance(self.found.values, other.found.values, self.found.amplitude)


def compute(
    run: Run, attempt: Attempt, variables: tuple[Quantity, ...], *, view: View | None = None,
    shown: Mechanism | None = None, hold: bool = True, end: float = np.inf,
) -> Computed:  # fmt: skip
    """Run to the end; its cost, or why it failed, is written into `attempt`. Raises AnalysisError.

    view   frame and its number to the frame that counts, of the mechanism `shown`;  hold  keep frames of any size
    end    processor time at which the run is stopped [s]
    """
    shown, stationary = shown or run.mechanism, run.mode.stationary
    held = hold or bool(variables) or _size(run) <= KEPT
    begun, run.end = time.process_time(), end
    frames, x, implicit = [], [], False
    try:
        for i, frame in enumerate(run):
            seen = frame if view is None else view(frame, i)
            attempt.rhs += frame.statistics.get("rhs", 0)
            implicit |= frame.statistics.get("jacobians", 0) > 0
            x.append(seen.x)
            if held:
                frames.append(seen)
    except AnalysisError as error:
        attempt.reason = str(error)
        raise
    finally:
        attempt.seconds = time.process_time() - begun
    every = np.array(x)
    plain = not variables and not stationary
    found = coordinates(shown, every) if plain else assessed(shown, run.mode.number, frames, variables, stationary)
    return Computed(run, attempt, every, frames if held else None, found, implicit=implicit)


def _size(run: Run) -> int:
    """Bytes of the frames of a run, about."""
    n = run.mechanism.numbering
    columns = 1 + n.ndof * (run.mechanism.settings.sbd_level or 0)
    return 8 * (run.mechanism.settings.n_steps + 1) * (6 * n.nx + 4 * n.ne) * columns


@dataclass
class ToleranceLadder:
    """Runs of one motion in mode 1. `view`, `shown`, `hold`: see `compute`."""

    run: Run
    variables: tuple[Quantity, ...]
    attempts: list[Attempt] = field(default_factory=list)
    view: View | None = None
    shown: Mechanism | None = None
    hold: bool = False
    end: float = np.inf  # processor time at which runs are stopped [s]; then they begin with the loosest tolerance
    ratio: float | None = None  # of the absolute error over the tolerance, that the motion asks for
    coarse: bool = False  # the last run had one that was much larger

    def compute(self, integrator: int, tolerance: float | None) -> Computed:
        """One run; `tolerance` None: with the settings of the file. Raises AnalysisError."""
        mechanism = self.run.mechanism
        settings = mechanism.settings
        if tolerance is not None:
            ratio = settings.atol / settings.rtol if settings.rtol > 0.0 else 1.0
            ratio = ratio if self.ratio is None else min(ratio, self.ratio)
            settings = replace(settings, integrator=integrator, rtol=tolerance, atol=tolerance * ratio, step=None)
        self.attempts.append(Attempt(integrator, tolerance))
        run = Run(find_mode(1), replace(mechanism, settings=settings))
        found = compute(
            run, self.attempts[-1], self.variables, view=self.view, shown=self.shown, hold=self.hold, end=self.end
        )
        if tolerance is not None and found.frames is not None:
            extent = Extent(self.shown or run.mechanism)
            extent.take(found.frames)
            least = min(extent.sizes().values(), default=np.inf)
            self.coarse, self.ratio = SMALLEST * ratio > least, min(least, ratio)
        return found

    def measured(self) -> tuple[Computed, Computed]:
        """The run of the file's settings with its estimated error, and the one that checks it."""
        settings = self.run.mechanism.settings
        row = METHODS[settings.integrator]
        shown = self.compute(row.code, None)
        tolerance = settings.rtol / GAIN if row.variable_step and settings.rtol > 0.0 else UNRESOLVED
        check = self.compute(AUTOMATIC, max(tolerance, TIGHTEST))
        shown.error = shown.attempt.difference = shown.distance(check)
        return shown, check

    def climb(self, target: float) -> tuple[Computed, Computed]:
        """The last run, with its estimated error, and the one before; ends when that is within the target, or when no
        more is to be had, within the time."""
        tolerance = min(max(FIRST * target, TIGHTEST * GAIN), LOOSEST)
        if self.end < np.inf:
            tolerance = LOOSEST
        before: Computed | None = None
        pair: tuple[Computed, Computed] | None = None
        last, gained_before = np.inf, 1.0
        while True:
            explicit = before is not None and not before.implicit
            try:
                now = self.compute(EXPLICIT if explicit else AUTOMATIC, tolerance)
            except AnalysisError as error:
                if error.code == "study.stopped" and pair is not None:
                    return pair
                # A loose tolerance may leave the range of the model where a tight one does not.
                if tolerance <= TIGHTEST or sum(bool(a.reason) for a in self.attempts) > 1:
                    raise
                tolerance = max(tolerance / GAIN**2, TIGHTEST)
                continue
            if before is None:
                if self.coarse:
                    self.coarse = False
                    continue
                before, tolerance = now, max(tolerance / GAIN, TIGHTEST)
                continue
            now.error = now.attempt.difference = d = now.distance(before)
            gained = (now.attempt.tolerance or 1.0) / (before.attempt.tolerance or 1.0)
            if d < last:
                now.error = d * max(TRUSTED, gained ** (0.25 if now.implicit else 0.5))
                if last < np.inf:
                    now.error = min(d, max(now.error, ALIKE * last * gained_before * gained))
            rounding = tolerance < ROUNDED and d < SMALL and d > max(STALLED, gained_before**0.5) * last
            if now.error <= target or tolerance <= TIGHTEST or rounding:
                now.error = now.error if now.error <= target else d
                return now, before
            pair = now, before
            before, last, gained_before = now, d, gained
            wish = MARGIN * target / max(now.error, MARGIN * target)
            tolerance = max(tolerance * min(max(wish, FURTHEST), NEAREST), TIGHTEST)
