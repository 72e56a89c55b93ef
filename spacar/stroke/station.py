"""What is known of one state of the stroke, from the linearized equations with the drive free and with it locked.

With q the dynamic degrees of freedom, d the drive, K = K0 + N0 + G0 of both (theory-system.md (12)):

    path            dq/dd = -K_qq^-1 K_qd           all other loads stay as they are
    drive           dF/dd = K_dd + K_dq dq/dd
    node, locked    C = D_q K_qq^-1 D_q^T;          free: C = D K^-1 D^T over q and d
    frequencies     of (K_qq, M_qq), of (K, M);     without damping; an unstable motion has a negative one
    buckling        det(K0 + lambda G0) = 0 of q, and of q and d (theory-system.md 6.5)
    extra load      det(K + lambda dG) = 0 of the same (spacar.stroke.extra_load)

The free mode that belongs to the drive is the one with the largest share s of the motion v = (dq/dd, 1) of the path,
s = (phi^T M v)^2 / (phi^T M phi v^T M v).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError, Report
from spacar.frame import Frame
from spacar.linear.buckling import buckling_modes
from spacar.linear.eigen import vibration_modes
from spacar.linear.internal_unknowns import buckling_matrices
from spacar.linear.node_compliance import compliance_of, displacements
from spacar.linearization.matrices import Linearization
from spacar.stroke.extra_load import ExtraLoad, extra_margin, extra_stresses
from spacar.stroke.observed_node import ObservedNode

NOTHING = 1e-11  # of the largest displacement by a degree of freedom: a direction that moves less counts as rigid


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
    frame: Frame, dynamics: Dynamics, L: Linearization, drive: int, held: bool, node: ObservedNode, modes: int,
    extra: ExtraLoad | None, report: Report,
) -> Station:  # fmt: skip
    """Everything about a placed state.

    drive   its row of q;  held  is it prescribed?
    modes   how many frequencies are kept;  extra  the load whose own margin is asked for
    """
    others = np.array([k for k in dynamics.numbering.dynamic.tolist() if k != drive], np.int64)
    every = np.append(others, drive)
    K = L.stiffness
    D = node.map(frame.x) @ L.G[node.rows]
    try:
        follow = -displacements(K[np.ix_(others, others)], K[others, drive][:, None])[:, 0]
        locked = without_still(compliance_of(K[np.ix_(others, others)], D[:, others]), D[:, others], D, node.points)
    except AnalysisError as error:
        report.add(f"warning: with the drive locked {error}")
        follow, locked = np.full(len(others), np.nan), np.full((len(D), len(D)), np.nan)
    slope = float(K[drive, drive] + K[drive, others] @ follow)
    free = free_compliance(frame, L, every, node, report)
    path = np.append(follow, 1.0)
    hertz, _ = _frequencies(L, dynamics, others, report)
    hertz_free, shapes = _frequencies(L, dynamics, every, report)
    drive_hertz, unwanted = _split(hertz_free, shapes, L.m0[np.ix_(every, every)], path)
    return Station(
        frame, slope, D[:, every] @ path, locked, free, first_of(hertz, modes), first_of(hertz_free, modes),
        drive_hertz, unwanted, _margin(L, dynamics, others, report), _margin(L, dynamics, every, report),
        *_extra(L, dynamics, others, every, held, extra, report), strain_energy(dynamics),
    )  # fmt: skip


def free_compliance(frame: Frame, L: Linearization, rows: Index, node: ObservedNode, report: Report) -> Array:
    """(m, m) compliance of a node with the degrees of freedom `rows` free; nan where the stiffness is singular."""
    D = node.map(frame.x) @ L.G[node.rows]
    try:
        return without_still(compliance_of(L.stiffness[np.ix_(rows, rows)], D[:, rows]), D[:, rows], D, node.points)
    except AnalysisError as error:
        report.add(f"warning: with the drive free {error}")
        return np.full((len(D), len(D)), np.nan)


def without_still(C: Array, D: Array, every: Array, points: int) -> Array:
    """C without the rounding of directions that nothing moves: their rows and columns are zero."""
    size = np.abs(D).max(axis=1, initial=0.0)
    largest = np.abs(every).max(axis=1, initial=0.0)
    still = np.zeros(len(D), bool)
    for part in (slice(0, points), slice(points, len(D))):
        still[part] = size[part] <= NOTHING * largest[part].max(initial=0.0)
    C = C.copy()
    C[still], C[:, still] = 0.0, 0.0
    return C


def _frequencies(L: Linearization, dynamics: Dynamics, rows: Index, report: Report) -> tuple[Array, Array]:
    """Frequencies (n,) [Hz] from low to high, unstable ones negative, and shapes (len(rows), n); n = 0 without mass."""
    none = np.zeros(0), np.zeros((len(rows), 0))
    if not len(rows):
        return none
    if _massless(L.m0[np.ix_(rows, rows)]):
        report.add("warning: no frequencies: the mass matrix is not positive definite; a motion carries no mass")
        return none
    undamped = replace(L, c0=np.zeros_like(L.c0), d0=np.zeros_like(L.d0))
    told = Report()
    try:
        found = vibration_modes(undamped, rows, rows, told, dynamics.numbering.twist_rates)
    except AnalysisError as error:
        report.add(f"warning: no frequencies: {error}")
        return none
    for line in told.lines:
        report.add(line)
    hertz, chosen = hertz_of(found.values)
    return hertz, found.vectors[: len(rows), chosen].real


def hertz_of(values: NDArray[np.complex128]) -> tuple[Array, Index]:
    """Frequencies (n,) [Hz] of undamped motion from low to high, unstable ones negative, and the places of their
    eigenvalues: of a pair the one with the positive imaginary, or positive real part."""
    chosen = np.flatnonzero((values.imag > 0.0) | ((values.imag == 0.0) & (values.real > 0.0)))
    hertz = np.abs(values[chosen]) / (2.0 * np.pi)
    hertz = np.where(values[chosen].imag > 0.0, hertz, -hertz)
    order = np.argsort(hertz, kind="stable")
    return hertz[order], chosen[order]


def _massless(M: Array) -> bool:
    """Is the mass matrix singular to rounding, beside degrees of freedom without any mass?"""
    M = M[M.any(axis=1)][:, M.any(axis=0)]
    scale = 1.0 / np.sqrt(np.maximum(np.diag(M), np.finfo(float).tiny))
    values = np.linalg.eigvalsh(M * np.outer(scale, scale))
    return bool(values.min(initial=np.inf) <= np.finfo(float).eps * len(M) * values.max(initial=0.0))


def _split(hertz: Array, shapes: Array, M: Array, path: Array) -> tuple[float, float]:
    """Frequency of the mode that is the motion of the drive, and the lowest of the others."""
    if not len(hertz) or not np.isfinite(path).all():
        return np.nan, np.nan
    along = shapes.T @ (M @ path)
    share = along**2 / np.maximum(np.einsum("ik,ij,jk->k", shapes, M, shapes), np.finfo(float).tiny)
    return apart(hertz, int(np.argmax(share)))


def apart(hertz: Array, k: int) -> tuple[float, float]:
    """Frequency k, and the lowest of the others (nan: none)."""
    rest = np.delete(hertz, k)
    return float(hertz[k]), float(rest[0]) if len(rest) else np.nan


def first_of(hertz: Array, n: int) -> Array:
    """The first n, filled up with nan."""
    return np.pad(hertz[:n], (0, max(0, n - len(hertz))), constant_values=np.nan)


def _margin(L: Linearization, dynamics: Dynamics, rows: Index, report: Report) -> float:
    """Lowest positive multiplier of all loads and prestresses of the state; infinite without one."""
    if not len(rows):
        return np.inf
    told = Report()
    try:
        found = buckling_modes(*buckling_matrices(dynamics, L, rows), told).lowest_positive
    except AnalysisError as error:
        report.add(f"warning: no load multipliers: {error}")
        return np.nan
    add_warnings(told, report)
    return found


def _extra(
    L: Linearization, dynamics: Dynamics, others: Index, every: Index, held: bool, load: ExtraLoad | None,
    report: Report,
) -> tuple[float, float]:  # fmt: skip
    """Multipliers of the extra load alone, drive locked and free; nan without such a load, and where there are none."""
    if load is None:
        return np.nan, np.nan
    told = Report()
    try:
        sigma = extra_stresses(dynamics, L, others if held else every, load)
        found = [extra_margin(dynamics, L, rows, sigma, load, told) for rows in (others, every)]
    except AnalysisError as error:
        report.add(f"warning: no multipliers of the extra load: {error}")
        return np.nan, np.nan
    add_warnings(told, report)
    return found[0], found[1]


def add_warnings(told: Report, report: Report) -> None:
    """What was told of multipliers, without that there are none: the value says it."""
    for line in told.lines:
        if line.startswith("warning"):
            report.add(line)


def strain_energy(dynamics: Dynamics) -> float:
    """e^T S e/2 + sigma0^T e of the elements whose deformations are free."""
    law, e = dynamics.law, dynamics.sweep.e
    return 0.5 * float(e @ (law(e, np.zeros(len(e))) + law.preload))
