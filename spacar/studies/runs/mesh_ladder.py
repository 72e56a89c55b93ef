"""The error of a mesh: results of meshes of 1, 2, 4 ... beams in the place of each, extrapolated."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.frame import Frame
from spacar.mechanism import Mechanism
from spacar.studies.runs.error_norm import distance
from spacar.studies.runs.extrapolated_frames import extrapolated_frames
from spacar.studies.runs.extrapolation import ROUNDING, Extrapolation, extrapolate
from spacar.studies.runs.record import Computed
from spacar.studies.runs.tolerance_ladder import SMALL, STALLED


@dataclass
class Found:
    """What is shown: frames (those of the `finest` mesh, extrapolated, or of the user's), the error of their
    coordinates (steps, nx), estimate and how it came about; `rows`: what is compared, extrapolated."""

    frames: Sequence[Frame]
    bars: Array
    estimate: float
    way: str
    finest: Computed
    rows: Extrapolation | None = None


def difference(a: Computed, b: Computed) -> float:
    return distance(a.found.values, b.found.values, a.found.amplitude)


def stalled(chain: list[Computed]) -> bool:
    """Do the differences not fall any more although they are small?"""
    now, before = difference(chain[-1], chain[-2]), difference(chain[-2], chain[-3])
    return now < SMALL and now > STALLED * before


def extrapolated(given: Mechanism, chain: list[Computed], left: float, active: Sequence[int], n: int) -> Found:
    """The best of the meshes, with what they say of its error."""
    fine, other = chain[-1], chain[-2]
    in_time = 2.0 * max(m.error for m in chain[-3:])
    which = ", ".join(str(n // 2**k) for k in range(min(len(chain), 3) - 1, -1, -1))
    way = f"meshes of {which} beams in the place of {_list(active)}"
    amplitude = fine.found.amplitude
    rows = extrapolate([m.found.values for m in chain], amplitude)
    error, size, frames = rows.error + left + in_time, difference(fine, other), fine.frames or []
    if len(chain) == 2:
        way += ", not extrapolated"
    else:
        counted = np.isfinite(amplitude) & (rows.errors > ROUNDING)
        way += f", variables extrapolated: {rows.orders(counted)}"
        frames = extrapolated_frames(given, [m.frames or () for m in chain])
    bars = np.abs(np.array([f.x for f in frames]) - other.x)
    if size > 0.0:
        bars *= error / size if len(chain) == 2 else min(1.0, error / size)
    return Found(frames, bars, error, way, fine, rows)


def _list(numbers: Sequence[int]) -> str:
    return f"beam {numbers[0]}" if len(numbers) == 1 else f"each of beams {', '.join(map(str, numbers))}"
