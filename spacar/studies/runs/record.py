"""The record of a run of an accuracy search: setting, values, error, cost."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError
from spacar.frame import Frame
from spacar.mechanism import Mechanism
from spacar.stream import Run
from spacar.studies.runs.quantities import Quantity
from spacar.studies.runs.result_quantities import Assessed, assessed, coordinates

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
