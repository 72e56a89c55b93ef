"""The equations of a state with the drive held and free, for large models: mixed form, no dense matrices.

Two tangents (theory-system.md 6.2) stand for the drive held and free. The coordinate of the drive is left out of the
free ones or added to them; if the drive is a deformation, this is a constraint or has no stress. Then

    path            T_held (x, sigma) = -(column of the drive); for a deformation 1 in its row
    slope           the row of the drive of the mixed matrix times (path, 1); for a deformation -sigma of its row
    node            C = P^T T^-1 P with P the forces and moments on the node

Frequencies and multipliers are the lowest ones (`spacar.linear.lowest`, `spacar.linear.lowest_multipliers`).
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import Report
from spacar.kinematics.transfer import moved_along
from spacar.linear.buckling import BucklingModes
from spacar.linear.lowest import is_symmetric_loading, lowest_vibration
from spacar.linear.lowest_multipliers import lowest_buckling, lowest_extra_load
from spacar.stationary.flexibility import Flexibility
from spacar.stationary.tangent import STATIC, SparseTangent
from spacar.stroke.extra_load import ExtraLoad
from spacar.stroke.observed_node import ObservedNode
from spacar.stroke.reduced_drive import DrivePlace, Frequencies


class MixedDrive:
    """As ReducedDrive, with tangents of one evaluator that stands at the state."""

    complete = False

    def __init__(self, dynamics: Dynamics, drive: DrivePlace) -> None:
        n, row = dynamics.numbering, drive.row
        self.dynamics, self.drive = dynamics, drive
        self.most = n.nddof
        stiff, moving = Flexibility(dynamics), None
        loose = Flexibility(dynamics, (row,)) if drive.deformation else stiff
        if not drive.deformation:
            moving = np.setdiff1d(np.r_[n.x_class["calculable"], n.x_class["dynamic"]], row)
        self._tangents = (
            SparseTangent(dynamics, stiff, moving),
            SparseTangent(dynamics, loose, None if moving is None else np.append(moving, row)),
        )

    def at(self, sigma: Array) -> MixedDrive:
        """With the stresses of the state, (ne,)."""
        for tangent in self._tangents:
            tangent.sigma = sigma
        return self

    def moved(self, node: ObservedNode, free: bool) -> Array:
        d = self.dynamics
        every = np.array([moved_along(d.kinematics, f) for f in self._forces(node).T])
        return every if free else np.delete(every, self.drive.place, axis=1)

    def compliance(self, node: ObservedNode, free: bool) -> Array:
        tangent, P = self._tangents[free], self._forces(node)
        return np.asarray(P.T @ tangent.displacement(tangent.factor(STATIC), P))

    def path(self, node: ObservedNode) -> tuple[Array, float, Array]:
        (t, free), d, row = self._tangents, self.dynamics, self.drive.row
        system, size = t.factor(STATIC), t.flexibility.size
        right, x = np.zeros(t.nf + t.ne), np.zeros(d.numbering.nx)
        if self.drive.deformation:
            right[t.nf + row] = size
        else:
            x[row] = 1.0
            right[: t.nf] = -(free.assembled(tuple(STATIC)) @ x)[t.F]
            right[t.nf :] = -size * t.flexibility.coupled * d.sweep.rate(x)
        found = system.solve(right)
        x[t.F] = found[: t.nf]
        sigma = size * found[t.nf :]
        if self.drive.deformation:
            slope = -float(sigma[row])
        else:
            force = free.assembled(tuple(STATIC)) @ x + d.sweep.rate_transposed(sigma)
            slope = float(force[row])
        return self._forces(node).T @ x, slope, x

    def vibration(self, free: bool, wanted: int, told: Report) -> Frequencies:
        found = lowest_vibration(self._tangents[free], told, wanted, undamped=True)
        assert found.motions is not None
        return Frequencies.of(found.values, found.motions)

    def momenta(self, motions: Array) -> Array:
        return np.asarray(self._tangents[True].assembled(("mass",)) @ motions)

    def buckling(self, free: bool, wanted: int, told: Report) -> BucklingModes:
        return lowest_buckling(self._tangents[free], told, wanted)

    def extra_stresses(self, free: bool, load: ExtraLoad) -> Array:
        t = self._tangents[free]
        right = np.zeros(t.nf + t.ne)
        right[: t.nf] = load.at(self.dynamics.kinematics.x)[t.F]
        return np.asarray(t.flexibility.size * t.factor(STATIC).solve(right)[t.nf :])

    def extra(self, free: bool, sigma: Array, load: ExtraLoad, wanted: int, told: Report) -> BucklingModes:
        return lowest_extra_load(self._tangents[free], sigma, load.gradient_entries(), told, wanted)

    def contains_all(self, found: BucklingModes, wanted: int, free: bool) -> bool:
        """If there are fewer than wanted, the others are infinite or, with an unsymmetric loading only, complex."""
        return len(found.multipliers) < wanted and is_symmetric_loading(self._tangents[free])

    def _forces(self, node: ObservedNode) -> Array:
        """Unit forces and moments on the node, (nx, m)."""
        d = self.dynamics
        P = np.zeros((d.numbering.nx, len(node.names)))
        P[node.rows] = node.map(d.kinematics.x).T
        return P
