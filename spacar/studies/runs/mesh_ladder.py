"""The error of a mesh: Richardson's extrapolation over meshes with n, 2n, 4n elements in the place of a beam.

The error of a mesh is c h^2 + d h^4 + e h^6 + ..., in the angle measure with a small or no c: differences of coarse
meshes then show order 4, and c is what is left. Every variable has the order p = 2 or 4 that it shows,
2^p = |u_n - u_2n| / |u_2n - u_4n| in the norm of the study. With R_p = u_4n + (u_4n - u_2n)/(2^p - 1) and w, the
extrapolation of the three meshes with orders 2 and 4 (Romberg):

    p = 4, value R_4:  it errs by 0.8 c h^2 - 3.2 e h^6, w - R_4 = -0.8 c h^2 + 67 e h^6
    p = 2, value w:    it errs by 64 e h^6, w - R_2 = 4 d h^4 + 84 e h^6

MARGIN times such a difference is the error; unless two terms cancel, it is between MARGIN and 21 MARGIN times the true
one for p = 4. Three meshes before the asymptotic range may show order 2 where it is 4: until a fourth mesh shows it
again the error is at least DOUBT of the last difference, |R_2 - R_4|; then w is compared with the extrapolation of four
meshes with orders 2, 4, 6. A variable without an order has the value of the finest mesh, with the last difference as
error. No error is larger than that difference.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.frame import Frame
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism import Mechanism
from spacar.studies.runs.tolerance_ladder import SMALL, STALLED, Computed
from spacar.studies.runs.user_nodes import deform

FIELDS = ("x", "xd", "xdd", "sig", "fx", "fxtot", "xcompl")
SPECTRA = ("eigval", "lmult")

CLOSE = 0.6  # between observed and theoretical order
ROUNDING = 1e-13  # differences below cannot tell an order
MARGIN = 1.3  # of the estimate over the difference of two extrapolations
DOUBT = 1 / 3 - 1 / 15  # least error over the last difference, where order 2 shows for the first time


class Extrapolation(NamedTuple):
    """values (variables, steps), errors (variables,) in amplitudes, order (variables,) that was used: 0, 2 or 4."""

    values: Array
    errors: Array
    order: Array

    @property
    def error(self) -> float:
        return float(self.errors.max(initial=0.0))

    def orders(self, counted: Array | bool = True) -> str:
        """How many variables were extrapolated with which order, in words."""
        seen = {p: int(np.sum((self.order == p) & counted)) for p in (4, 2, 0)}
        return ", ".join(f"{k} with order {p}" if p else f"{k} not" for p, k in seen.items() if k)


def extrapolate(meshes: Sequence[Array], amplitude: Array) -> Extrapolation:
    """Values (variables, steps) of two meshes or more, each twice as fine as the one before; amplitude (variables,)."""

    def size(v: Array) -> Array:
        return np.max(np.abs(v), axis=1, initial=0.0) / amplitude

    differences = [size(b - a) for a, b in pairwise(meshes[-4:])]
    none = np.zeros(len(amplitude), int)
    before, order = [none, none, *(_orders(a, b) for a, b in pairwise(differences))][-2:]
    values, last = meshes[-1].copy(), differences[-1]
    errors = last.copy()
    if order.any():
        first, second, *third = _romberg(meshes[-4:], 2)[1:]
        fourth = _romberg(meshes[-2:], 4)[1]
        again = (order == 2) & (before == 2)
        for rows, value, other, least in (
            (order == 4, fourth, second, 0.0),
            ((order == 2) & ~again, second, first, DOUBT),
            (again, second, [first, *third][-1], 0.0),
        ):
            values[rows] = value[rows]
            errors[rows] = np.maximum(MARGIN * size(other - value), least * last)[rows]
    return Extrapolation(values, np.minimum(errors, last), order)


def _orders(first: Array, second: Array) -> Array:
    """The order 2 or 4 that two differences show, one after the other; 0: none."""
    known = (second > ROUNDING) & (first > 0.0)
    seen = np.log2(np.where(known, first, 1.0) / np.where(known, second, 1.0))
    return np.where(known & (np.abs(seen - 2) <= CLOSE), 2, np.where(known & (np.abs(seen - 4) <= CLOSE), 4, 0))


def _romberg(meshes: Sequence[Array], order: int) -> list[Array]:
    """The finest value of each level of the extrapolation with order, order + 2, ...; that of the mesh first."""
    table, finest = list(meshes), [meshes[-1]]
    while len(table) > 1:
        table = [b + (b - a) / (2**order - 1) for a, b in pairwise(table)]
        finest.append(table[-1])
        order += 2
    return finest


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


def stalled(chain: list[Computed]) -> bool:
    """Do the differences not fall any more although they are small?"""
    now, before = chain[-1].distance(chain[-2]), chain[-2].distance(chain[-3])
    return now < SMALL and now > STALLED * before


def extrapolated(given: Mechanism, chain: list[Computed], left: float, active: Sequence[int], n: int) -> Found:
    """The best of the meshes, with what they say of its error."""
    fine, other = chain[-1], chain[-2]
    in_time = 2.0 * max(m.error for m in chain[-3:])
    which = ", ".join(str(n // 2**k) for k in range(min(len(chain), 3) - 1, -1, -1))
    way = f"meshes of {which} beams in the place of {_list(active)}"
    amplitude = fine.found.amplitude
    rows = extrapolate([m.found.values for m in chain], amplitude)
    error, size, frames = rows.error + left + in_time, fine.distance(other), fine.frames or []
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
