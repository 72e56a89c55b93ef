"""What is known of one state of the stroke (`spacar.stroke.station`), for large models: no dense matrices.

Two tangents of the mixed equations (theory-system.md 6.2) stand for the drive held and free. The coordinate of the
drive is left out of the free ones or added to them; if the drive is a deformation, this is a constraint or has no
stress. Then

    path            T_held (x, sigma) = -(column of the drive); for a deformation 1 in its row
    slope           the row of the drive of the mixed matrix times (path, 1); for a deformation -sigma of its row
    node            C = P^T T^-1 P with P the forces and moments on the node

Frequencies and multipliers are the lowest ones (`spacar.linear.lowest`, `spacar.linear.lowest_multipliers`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError, Report
from spacar.frame import Frame
from spacar.kinematics.transfer import moved_along
from spacar.linear.buckling import BucklingModes
from spacar.linear.lowest import is_symmetric_loading, lowest_vibration
from spacar.linear.lowest_multipliers import lowest_buckling, lowest_extra_load
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism.numbering import Numbering
from spacar.stationary.flexibility import Flexibility
from spacar.stationary.tangent import STATIC, SparseTangent
from spacar.stroke.extra_load import ExtraLoad
from spacar.stroke.observed_node import ObservedNode
from spacar.stroke.station import Station, add_warnings, apart, first_of, hertz_of, strain_energy, without_still

FIRST, MOST = 6, 40  # multipliers, and free modes, that are computed at first and at most


@dataclass(frozen=True)
class DriveTangents:
    """Tangents of one evaluator with the drive held and free. `row`: of the drive in x, or in e for a `deformation`."""

    held: SparseTangent
    free: SparseTangent
    row: int
    deformation: bool

    @classmethod
    def of(cls, dynamics: Dynamics, row: int, deformation: bool) -> DriveTangents:
        n = dynamics.numbering
        stiff = Flexibility(dynamics)
        if deformation:
            return cls(
                SparseTangent(dynamics, stiff), SparseTangent(dynamics, Flexibility(dynamics, (row,))), row, True
            )
        others = np.setdiff1d(np.r_[n.x_class["calculable"], n.x_class["dynamic"]], row)
        every = np.append(others, row)
        return cls(SparseTangent(dynamics, stiff, others), SparseTangent(dynamics, stiff, every), row, False)

    @property
    def dynamics(self) -> Dynamics:
        return self.held.dynamics

    def at(self, sigma: Array) -> None:
        """The stresses of the state, (ne,)."""
        self.held.sigma = self.free.sigma = sigma

    def path(self) -> tuple[Array, float]:
        """d(x)/d(drive) (nx,), and dF/d(drive). Raises SingularMatrixError where the state is critical."""
        t, d = self.held, self.dynamics
        system, size = t.factor(STATIC), t.flexibility.size
        right, x = np.zeros(t.nf + t.ne), np.zeros(d.numbering.nx)
        if self.deformation:
            right[t.nf + self.row] = size
        else:
            x[self.row] = 1.0
            right[: t.nf] = -self.free.times(tuple(STATIC), x[:, None])[t.F, 0]
            right[t.nf :] = -size * t.flexibility.coupled * d.sweep.rate(x)
        found = system.solve(right)
        x[t.F] = found[: t.nf]
        sigma = size * found[t.nf :]
        if self.deformation:
            return x, -float(sigma[self.row])
        force = self.free.times(tuple(STATIC), x[:, None])[:, 0] + d.sweep.rate_transposed(sigma)
        return x, float(force[self.row])


def large_station(
    frame: Frame, tangents: DriveTangents, held: bool, node: ObservedNode, modes: int, extra: ExtraLoad | None,
    report: Report,
) -> Station:  # fmt: skip
    """Everything about a placed state, as from `spacar.stroke.station.station`."""
    d = tangents.dynamics
    P, moved = _forces(d, frame, node)
    own = row_of_q(d.numbering, tangents.row, tangents.deformation)
    locked = _compliance(tangents.held, P, np.delete(moved, own, axis=1), moved, node, "locked", report)
    free = _compliance(tangents.free, P, moved, moved, node, "free", report)
    try:
        path, slope = tangents.path()
    except SingularMatrixError:
        path, slope = np.full(d.numbering.nx, np.nan), np.nan
    hertz, _ = _frequencies(tangents.held, modes, report)
    hertz_free, drive_hertz, unwanted = _free_modes(tangents.free, modes + 1, path, report)
    return Station(
        frame, slope, P.T @ path, locked, free, first_of(hertz, modes), first_of(hertz_free, modes), drive_hertz,
        unwanted, _margin(tangents.held, report), _margin(tangents.free, report),
        *_extra(tangents, held, extra, report), strain_energy(d),
    )  # fmt: skip


def node_compliance_of(tangents: DriveTangents, frame: Frame, node: ObservedNode, report: Report) -> Array:
    """(m, m) compliance of a node with the drive free; nan where the stiffness is singular."""
    P, moved = _forces(tangents.dynamics, frame, node)
    return _compliance(tangents.free, P, moved, moved, node, "free", report)


def _forces(dynamics: Dynamics, frame: Frame, node: ObservedNode) -> tuple[Array, Array]:
    """Unit forces and moments P (nx, m) on the node, and what a unit of every degree of freedom moves along them, P^T W
    (m, ndof)."""
    P = np.zeros((dynamics.numbering.nx, len(node.names)))
    P[node.rows] = node.map(frame.x).T
    return P, np.array([moved_along(dynamics.kinematics, f) for f in P.T])


def row_of_q(n: Numbering, row: int, deformation: bool) -> int:
    """The row of q of a row of e, if it is a `deformation`, or of x."""
    return int(np.flatnonzero((n.q_e if deformation else n.q_x) == row)[0]) + deformation * len(n.q_x)


def _compliance(
    tangent: SparseTangent, P: Array, moved: Array, every: Array, node: ObservedNode, how: str, report: Report
) -> Array:
    try:
        system = tangent.factor(STATIC)
    except SingularMatrixError as error:
        report.add(f"warning: with the drive {how} there is no compliance: {error}")
        return np.full((P.shape[1], P.shape[1]), np.nan)
    return without_still(P.T @ tangent.displacement(system, P), moved, every, node.points)


def _frequencies(tangent: SparseTangent, wanted: int, report: Report) -> tuple[Array, Array]:
    """Lowest frequencies (n,) [Hz] from low to high, unstable ones negative, and shapes (nx, n); n = 0 without mass."""
    told = Report()
    try:
        found = lowest_vibration(tangent, told, wanted, undamped=True)
    except (AnalysisError, SingularMatrixError) as error:
        report.add(f"warning: no frequencies: {error}")
        return np.zeros(0), np.zeros((tangent.dynamics.numbering.nx, 0))
    for line in told.lines:
        report.add(line)
    assert found.motions is not None
    hertz, chosen = hertz_of(found.values)
    return hertz, found.motions[:, chosen].real


def _free_modes(tangent: SparseTangent, wanted: int, path: Array, report: Report) -> tuple[Array, float, float]:
    """Free frequencies, the frequency of the mode that is the motion of the drive, and the lowest of the others [Hz].

    `wanted` modes are computed, and more where one that is missing may have a larger share of that motion.
    """
    hertz, shapes = _frequencies(tangent, wanted, report)
    if not len(hertz) or not np.isfinite(path).all():
        return hertz, np.nan, np.nan
    moved = tangent.times(("mass",), path[:, None])[:, 0]
    whole = max(float(path @ moved), np.finfo(float).tiny)
    while True:
        own = np.einsum("ik,ik->k", shapes, tangent.times(("mass",), shapes))
        share = (shapes.T @ moved) ** 2 / np.maximum(own, np.finfo(float).tiny) / whole
        k = int(np.argmax(share))
        if share[k] >= 1.0 - share.sum() or wanted >= MOST or len(hertz) < wanted:
            break
        wanted = min(2 * wanted, MOST)
        hertz, shapes = _frequencies(tangent, wanted, report)
    if share[k] < 1.0 - share.sum():  # all modes together have 1
        text = f"the motion of the drive is none of the {len(hertz)} lowest free modes: its frequency is not known"
        report.add(f"warning: {text}")
        return hertz, np.nan, float(hertz[0])
    return hertz, *apart(hertz, k)


def _margin(tangent: SparseTangent, report: Report) -> float:
    """Lowest positive multiplier of all loads and prestresses of the state; infinite without one."""
    return _searched(partial(lowest_buckling, tangent), tangent, "load multipliers", report)


def _searched(
    find: Callable[[Report, int], BucklingModes], tangent: SparseTangent, what: str, report: Report
) -> float:
    """The lowest positive multiplier among those of smallest modulus, of more where all these are negative."""
    wanted, most = FIRST, min(MOST, tangent.dynamics.numbering.nddof)
    while True:
        told = Report()
        try:
            found: BucklingModes = find(told, wanted)
        except (AnalysisError, SingularMatrixError) as error:
            report.add(f"warning: no {what}: {error}")
            return np.nan
        value = found.lowest_positive
        # If there are fewer than wanted, the others are infinite or, with an unsymmetric loading only, complex.
        all_found = len(found.multipliers) < wanted and is_symmetric_loading(tangent)
        if np.isfinite(value) or wanted >= most or all_found:
            break
        wanted = min(2 * wanted, most)
    add_warnings(told, report)
    if np.isinf(value) and not all_found and wanted < tangent.dynamics.numbering.nddof:
        report.add(f"warning: none of the {wanted} lowest {what} is positive; a larger one is not looked for")
    return value


def _extra(tangents: DriveTangents, held: bool, load: ExtraLoad | None, report: Report) -> tuple[float, float]:
    """Multipliers of the extra load alone, drive held and free."""
    if load is None:
        return np.nan, np.nan
    d, what = tangents.dynamics, "multipliers of the extra load"
    t = tangents.held if held else tangents.free
    try:
        s1 = _stresses(t, load.at(d.kinematics.x))
    except SingularMatrixError as error:
        report.add(f"warning: no {what}: {error}")
        return np.nan, np.nan
    moments = load.gradient_entries()
    found = [
        _searched(partial(lowest_extra_load, t, s1, moments), t, what, report)
        for t in (tangents.held, tangents.free)
    ]
    return found[0], found[1]


def _stresses(t: SparseTangent, force: Array) -> Array:
    """sigma (ne,) that a small force (nx,) adds."""
    right = np.zeros(t.nf + t.ne)
    right[: t.nf] = force[t.F]
    solution: Array = t.factor(STATIC).solve(right)
    return t.flexibility.size * solution[t.nf :]
