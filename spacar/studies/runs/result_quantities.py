"""What the accuracy of a stationary solution is about, with the amplitude of each variable.

Unless expressions are chosen:

    positions    free coordinates of nodes; amplitude: the largest displacement of the model, that of a node [m]
    orientation  angles or Euler parameters; amplitude: the largest change of one of them
    twist rates  of warping nodes; amplitude: the largest of them
    reactions    forces at fixed and prescribed coordinates; amplitude: the largest force, and the largest moment
    frequencies  the FREQUENCIES lowest eigenvalues; amplitude: each one's modulus
    multipliers  the MULTIPLIERS lowest load multipliers; amplitude: each one's size

A group that is zero to ZERO of what it could be (lengths of the model, a radian, force times length) does not count.

The error of a result in one number: max |v - v_ref| / amplitude over variables and output times.

The amplitude of a variable is its span over the output times, or its largest magnitude in the stationary modes and when
it hardly changes: span below CONSTANT of it, and below CONSTANT of the largest span or ROUNDED of it. So 1e-6 means: a
millionth of the motion of that variable, also where all that moves moves by 1e-9 m.
"""

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from spacar.arrays import EPS, Array, Index
from spacar.errors import Report, UsageError
from spacar.frame import Frame
from spacar.linear.lowest import lowest_modes
from spacar.linearization.descriptor import DescriptorSystem
from spacar.mechanism import Mechanism
from spacar.result import Result
from spacar.studies.runs.quantities import Quantity

FREQUENCIES, MULTIPLIERS = 6, 3
ZERO = 1e-6
CONSTANT = 1e-6  # a variable whose span is a smaller part of its magnitude may be constant
ROUNDED = 1e6 * EPS  # a smaller span may be rounding, or left by iterations
STILL = 1e-9  # a variable that stays below this part of the largest one is left out
# The same for stationary solutions, which are iterated to 5e-7 (ITERSTEP): smaller values are errors of the iteration.
STILL_STATIONARY = 1e-6


class Assessed(NamedTuple):
    """names of the variables, values (variables, steps), amplitude (variables,); inf: does not count."""

    names: tuple[str, ...]
    values: Array
    amplitude: Array


def assessed(
    mechanism: Mechanism, mode: int, frames: Sequence[Frame], variables: Sequence[Quantity], stationary: bool
) -> Assessed:
    """The variables of a run, on the nodes of the user. Raises UsageError for one that is not real and finite."""
    if variables:
        result = Result(mechanism, mode, tuple(frames), (), {})
        values = np.array([_real(v, result) for v in variables])
        return Assessed(tuple(v.name for v in variables), values, amplitudes(values, stationary))
    if not stationary:
        return coordinates(mechanism, np.array([f.x for f in frames]))
    free = free_coordinates(mechanism)
    groups = _coordinates(mechanism, frames, free) + _reactions(mechanism, frames, free) + _spectrum(mechanism, frames)
    names = tuple(name for g in groups for name in g.names)
    return Assessed(names, *(np.concatenate([getattr(g, f) for g in groups]) for f in ("values", "amplitude")))


def coordinates(mechanism: Mechanism, x: Array) -> Assessed:
    """The free ones of a motion, x (times, nx)."""
    free = free_coordinates(mechanism)
    names = tuple(mechanism.numbering.x_name(int(i)) for i in free)
    return Assessed(names, x[:, free].T, amplitudes(x[:, free].T, stationary=False))


def free_coordinates(mechanism: Mechanism) -> Index:
    """Columns of the coordinates that the motion determines."""
    n, rows = mechanism.numbering, np.arange(mechanism.numbering.nx)
    return np.setdiff1d(rows, np.r_[: n.x_class["fixed"].stop, n.x_class["input"]])


def _real(variable: Quantity, result: Result) -> Array:
    series = variable.series(result)
    if np.iscomplexobj(series) or not np.isfinite(series).all():
        raise UsageError(f"{variable.text} is not a real, finite number at every step", "study.accuracy")
    return np.broadcast_to(np.asarray(series, float), (len(result.frames),))


def _group(mechanism: Mechanism, rows: Index, every: Array, size: float, least: float, of: str = "") -> Assessed:
    """Rows of `every` variable with one amplitude; inf when it is below `least`."""
    names = tuple(of + mechanism.numbering.x_name(int(i)) for i in rows)
    return Assessed(names, every[rows], np.full(len(rows), size if size > least else np.inf))


def _kinds(mechanism: Mechanism, rows: Index) -> dict[str, Index]:
    """Rows of x by the kind of their node."""
    n = mechanism.numbering
    kind = np.array([n.kind[n.x_owner(int(i))[0]] for i in rows])
    return {k: rows[kind == k] for k in ("position", "orientation", "warping")}


def _coordinates(mechanism: Mechanism, frames: Sequence[Frame], free: Index) -> list[Assessed]:
    x = np.array([f.x for f in frames]).T
    change, scale = np.abs(x - mechanism.x0[:, None]).max(axis=1, initial=0.0), mechanism.scale
    kinds = [rows for rows in _kinds(mechanism, free).values() if len(rows)]
    return [_group(mechanism, rows, x, float(change[rows].max()), ZERO * float(scale[rows].max())) for rows in kinds]


def _reactions(mechanism: Mechanism, frames: Sequence[Frame], free: Index) -> list[Assessed]:
    held = np.setdiff1d(np.arange(mechanism.numbering.nx), free)
    force = np.array([f.fxtot - f.fx - f.fxgrav for f in frames]).T
    rows = _kinds(mechanism, held)
    largest = {k: float(np.abs(force[r]).max(initial=0.0)) for k, r in rows.items()}
    length = mechanism.length
    least = {"position": largest["orientation"] / length, "orientation": largest["position"] * length}
    return [
        _group(mechanism, rows[kind], force, largest[kind], ZERO * least[kind], "reaction at ")
        for kind in ("position", "orientation")
        if len(rows[kind])
    ]


def _spectrum(mechanism: Mechanism, frames: Sequence[Frame]) -> list[Assessed]:
    found, space = [], frames[0].state_space
    every: list[Array] = []
    if "eigval" in frames[0].matrices:
        every = [f.matrices["eigval"] for f in frames]
    elif "A" in space and len(space["A"]):
        every = [_eigenvalues(f.state_space["A"]) for f in frames]
    elif "asp" in space:
        every = [_lowest(mechanism, f) for f in frames]
    if every:
        modulus = [np.hypot(v[:, 0], v[:, 1]) for v in every]
        n = mechanism.numbering  # a refined state space has more of them
        k = min(2 * FREQUENCIES, n.nddof + n.nkddof, *map(len, every))
        values = np.array([np.concatenate((v[-k:, 0], v[-k:, 1])) for v in every]).T
        size = np.array([m[-k:] for m in modulus]).T.max(axis=1, initial=0.0)
        largest = max(float(np.nanmax(m, initial=0.0)) for m in modulus)
        # A rigid motion is known to the root of rounding only, and a nan is no value.
        counts = np.isfinite(values[:k] + values[k:]).all(axis=1) & (size > sqrt(EPS) * largest)
        amplitude = np.where(counts, size, np.inf)
        names = [f"{part} of eigenvalue {i}" for part in ("real part", "imaginary part") for i in range(k, 0, -1)]
        found.append(Assessed(tuple(names), np.nan_to_num(values), np.tile(amplitude, 2)))
    if "lmult" in frames[0].matrices:
        k = min(MULTIPLIERS, *(len(f.matrices["lmult"]) for f in frames))
        values = np.array([f.matrices["lmult"][:k] for f in frames]).T
        size = np.where(np.isfinite(values).all(axis=1), np.abs(values).max(axis=1, initial=0.0), 0.0)
        names = [f"load multiplier {i + 1}" for i in range(k)]
        found.append(Assessed(tuple(names), np.nan_to_num(values), np.where(size > 0.0, size, np.inf)))
    return found


def _lowest(mechanism: Mechanism, frame: Frame) -> Array:
    """(n, 2) of a large model, whose equations are stored sparse."""
    n = mechanism.numbering
    system = DescriptorSystem.of_entries({"asp": frame.state_space["asp"]}, n.nkddof + n.nddof, 0, 0)
    values = lowest_modes(system, n.nkddof, 0, Report(), FREQUENCIES).values
    return np.column_stack((values.real, values.imag))


def _eigenvalues(A: Array) -> Array:
    """(n, 2) by decreasing modulus, of a pair the positive imaginary part first."""
    values = np.linalg.eigvals(A)
    rounded = np.array([float(f"{m:.10e}") for m in np.abs(values)])
    order = np.lexsort((-values.imag, -np.abs(values.imag), -rounded))
    return np.column_stack((values[order].real, values[order].imag))


def amplitudes(values: Array, stationary: bool) -> Array:
    """(variables,) amplitude of each variable of `values` (variables, times); inf for a variable that stays at zero, so
    that it does not count."""
    size = np.abs(values).max(axis=1)
    span = np.ptp(values, axis=1)
    moves = (span > CONSTANT * size) | (span > np.maximum(CONSTANT * span.max(initial=0.0), ROUNDED * size))
    scale = np.where(moves & (not stationary), span, size)
    still = STILL_STATIONARY if stationary else STILL
    return np.where(size > still * size.max(initial=0.0), scale, np.inf)


def distance(a: Array, b: Array, amplitude: Array) -> float:
    """max |a - b| / amplitude of two arrays (variables, times)."""
    return float(np.max(np.abs(a - b) / amplitude[:, None], initial=0.0))
