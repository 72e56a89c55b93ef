"""The error of a mesh: results of meshes of 1, 2, 4 ... beams in the place of each, extrapolated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from spacar.arrays import Array
from spacar.frame import Frame
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism import Mechanism
from spacar.studies.runs.error_norm import distance
from spacar.studies.runs.extrapolation import ROUNDING, Extrapolation, extrapolate
from spacar.studies.runs.record import Computed
from spacar.studies.runs.tolerance_ladder import SMALL, STALLED
from spacar.studies.runs.user_nodes import deform

FIELDS = ("x", "xd", "xdd", "sig", "fx", "fxtot", "xcompl")
SPECTRA = ("eigval", "lmult")


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


def extrapolated_frames(given: Mechanism, meshes: Sequence[Sequence[Frame]]) -> list[Frame]:
    """Frames of the finest of several meshes on the nodes of `given`, every variable extrapolated with the order that
    it shows; deformations follow from the coordinates."""
    fine = meshes[-1]
    found = [replace(f, matrices=dict(f.matrices)) for f in fine]
    for name in FIELDS:
        if getattr(fine[0], name) is not None:
            every = _better([np.array([getattr(f, name) for f in frames]) for frames in meshes])
            for frame, value in zip(found, every, strict=True):
                setattr(frame, name, value)
    for name in SPECTRA:
        if name in fine[0].matrices:  # what is nan has no order and stays so
            stacks = [[f.matrices[name] for f in frames] for frames in meshes]
            if len({a.shape for stack in stacks for a in stack}) == 1:
                for frame, value in zip(found, _better([np.array(s) for s in stacks]), strict=True):
                    frame.matrices[name] = value
    sweep = ElementSweep(given)
    for frame in found:
        deform(given, sweep, frame, frame)
    return found


def _better(arrays: list[Array]) -> Array:
    """Arrays (steps, ...) of the meshes, extrapolated."""
    shape = arrays[0].shape
    rows = [np.moveaxis(a, 0, -1).reshape(-1, shape[0]) for a in arrays]
    size = np.maximum(np.abs(rows[-1]).max(axis=1, initial=0.0), np.finfo(float).tiny)
    values = extrapolate(rows, size).values
    return np.moveaxis(values.reshape(*shape[1:], shape[0]), -1, 0)
