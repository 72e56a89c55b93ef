"""What is known of one state of the stroke: node, frequencies and multipliers with the drive free and with it locked.

The equations of the state: `spacar.stroke.drive_equations`.

    buckling        det(K0 + lambda G0) = 0 without and with the drive (theory-system.md 6.5)
    extra load      det(K + lambda dG) = 0 of the same (`spacar.stroke.drive_equations`)

The free mode that belongs to the drive is the one with the largest share s of the motion v of the path,
s = (phi^T M v)^2 / (phi^T M phi v^T M v). All modes together have 1.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError, Report
from spacar.frame import Frame
from spacar.linear.buckling import BucklingModes
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism.mechanism import Loads
from spacar.stroke.drive_equations import DriveEquations, Frequencies
from spacar.stroke.observed_node import ObservedNode

NOTHING = 1e-11  # of the largest displacement by a degree of freedom: a direction that moves less counts as rigid
FIRST, MOST = 6, 40  # multipliers, and free modes, that are computed at first and at most
FAILED = AnalysisError, SingularMatrixError


@dataclass(frozen=True)
class Station:
    """One state, with d the coordinate of the drive, m directions of the node and f frequencies that were asked for.

    slope  dF/dd;  velocity (m,) of the node by d;  locked, free (m, m) compliances;  hertz, hertz_free (f,) [Hz];
    drive_hertz, unwanted_free  of the free modes, that of the drive and the lowest of the others
    margin, margin_free  lowest positive load multipliers;  extra, extra_free  those of the extra load alone (nan: none)
    energy  strain energy [J]
    """

    frame: Frame
    slope: float
    velocity: Array
    locked: Array
    free: Array
    hertz: Array
    hertz_free: Array
    drive_hertz: float
    unwanted_free: float
    margin: float
    margin_free: float
    extra: float
    extra_free: float
    energy: float


def station(
    frame: Frame, equations: DriveEquations, held: bool, node: ObservedNode, modes: int, extra: Loads | None,
    report: Report,
) -> Station:  # fmt: skip
    """Everything about a placed state.

    held   is the drive prescribed?;  modes  how many frequencies are kept;  extra  load whose own margin is asked for
    """
    e = equations
    locked, free = (node_compliance(e, node, k, report) for k in (False, True))
    try:
        velocity, slope, path = e.path(node)
    except FAILED:  # as the compliance, which says it
        velocity, slope, path = np.full(len(node.names), np.nan), np.nan, np.full(1, np.nan)
    hertz = _frequencies(e, False, modes, report).hertz
    hertz_free, drive_hertz, unwanted = _free_modes(e, modes + 1, path, report)
    margin, margin_free = (_lowest_positive(e, k, e.buckling, "load multipliers", report) for k in (False, True))
    law, deformations = e.dynamics.law, e.dynamics.sweep.e
    # e^T S e/2 + sigma0^T e of the elements whose deformations are free
    energy = 0.5 * float(deformations @ (law(deformations, np.zeros(len(deformations))) + law.preload))
    return Station(
        frame, slope, velocity, locked, free, _first_of(hertz, modes), _first_of(hertz_free, modes), drive_hertz,
        unwanted, margin, margin_free, *_extra(e, held, extra, report), energy,
    )  # fmt: skip


def node_compliance(e: DriveEquations, node: ObservedNode, free: bool, report: Report) -> Array:
    """(m, m) compliance of a node, with zeros instead of the rounding of directions that nothing moves; nan where the
    stiffness is singular."""
    try:
        C = e.compliance(node, free)
    except FAILED as error:
        report.add(f"warning: with the drive {'free' if free else 'locked'} {error}")
        return np.full((len(node.names), len(node.names)), np.nan)
    size, largest = (np.abs(e.moved(node, k)).max(axis=1, initial=0.0) for k in (free, True))
    for part in (slice(0, node.points), slice(node.points, len(C))):
        still = np.flatnonzero(size[part] <= NOTHING * largest[part].max(initial=0.0)) + part.start
        C[still], C[:, still] = 0.0, 0.0
    return C


def _frequencies(e: DriveEquations, free: bool, wanted: int, report: Report) -> Frequencies:
    """None without mass."""
    own = Report()
    try:
        found = e.vibration(free, wanted, own)
    except FAILED as error:
        report.add(f"warning: no frequencies: {error}")
        return Frequencies(np.zeros(0), np.zeros((0, 0)))
    for line in own.lines:
        report.add(line)
    return found


def _free_modes(e: DriveEquations, wanted: int, path: Array, report: Report) -> tuple[Array, float, float]:
    """Free frequencies, the frequency of the mode that is the motion of the drive, and the lowest of the others [Hz]
    (nan: none). `wanted` modes are computed, and more where one that is missing may have a larger share of that motion.
    """
    hertz, shapes = _frequencies(e, True, wanted, report)
    if not len(hertz) or not np.isfinite(path).all():
        return hertz, np.nan, np.nan
    moved, least = e.momenta(path[:, None])[:, 0], np.finfo(float).tiny
    whole = max(float(path @ moved), least)
    while True:
        own = np.einsum("ik,ik->k", shapes, e.momenta(shapes))
        share = (shapes.T @ moved) ** 2 / np.maximum(own, least) / whole
        k = int(np.argmax(share))
        certain = e.complete or share[k] >= 1.0 - share.sum()
        if certain or wanted >= MOST or len(hertz) < wanted:
            break
        wanted = min(2 * wanted, MOST)
        hertz, shapes = _frequencies(e, True, wanted, report)
    if not certain:
        text = f"the motion of the drive is none of the {len(hertz)} lowest free modes: its frequency is not known"
        report.add(f"warning: {text}")
        return hertz, np.nan, float(hertz[0])
    rest = np.delete(hertz, k)
    return hertz, float(hertz[k]), float(rest[0]) if len(rest) else np.nan


def _first_of(hertz: Array, n: int) -> Array:
    """The first n, filled up with nan."""
    return np.pad(hertz[:n], (0, max(0, n - len(hertz))), constant_values=np.nan)


def _extra(e: DriveEquations, held: bool, load: Loads | None, report: Report) -> tuple[float, float]:
    """Multipliers of the extra load alone, drive held and free; nan without such a load, and where there are none."""
    if load is None:
        return np.nan, np.nan
    what = "multipliers of the extra load"
    try:
        sigma = e.extra_stresses(not held, load)
    except FAILED as error:
        report.add(f"warning: no {what}: {error}")
        return np.nan, np.nan
    find = partial(e.extra, sigma, load)
    locked, free = (_lowest_positive(e, k, find, what, report) for k in (False, True))
    return locked, free


def _lowest_positive(
    e: DriveEquations, free: bool, find: Callable[[bool, int, Report], BucklingModes], what: str, report: Report
) -> float:
    """The lowest positive multiplier among those of smallest modulus, of more where all these are negative; infinite
    without one."""
    wanted, every = FIRST, e.dynamics.numbering.nddof
    while True:
        own = Report()
        try:
            found = find(free, wanted, own)
        except FAILED as error:
            report.add(f"warning: no {what}: {error}")
            return np.nan
        value, all_found = found.lowest_positive, e.contains_all(found, wanted, free)
        if np.isfinite(value) or wanted >= min(MOST, every) or all_found:
            break
        wanted = min(2 * wanted, MOST, every)
    for line in own.lines:
        if line.startswith("warning"):  # the value tells that there are none
            report.add(line)
    if np.isinf(value) and not all_found and wanted < every:
        report.add(f"warning: none of the {wanted} lowest {what} is positive; a larger one is not looked for")
    return value
