"""The equations of a state with the drive held and free, from the dense linearized equations.

With q the dynamic degrees of freedom, d the drive, K = K0 + N0 + G0 of both (theory-system.md (12)):

    path            dq/dd = -K_qq^-1 K_qd           all other loads stay as they are
    drive           dF/dd = K_dd + K_dq dq/dd
    node, locked    C = D_q K_qq^-1 D_q^T;          free: C = D K^-1 D^T over q and d
    frequencies     of (K_qq, M_qq), of (K, M);     without damping

Of large models in mixed form, without dense matrices: two tangents (theory-system.md 6.2) stand for the drive held and
free. The coordinate of the drive is left out of the free ones or added to them; if the drive is a deformation, this is
a constraint or has no stress. Then

    path            T_held (x, sigma) = -(column of the drive); for a deformation 1 in its row
    slope           the row of the drive of the mixed matrix times (path, 1); for a deformation -sigma of its row
    node            C = P^T T^-1 P with P the forces and moments on the node

Frequencies and multipliers are the lowest ones (`spacar.linear.lowest`, `spacar.linear.lowest_multipliers`).

The margin of one extra load alone: how much of it a state bears besides all that it carries (docs/flexures.md 3).

    (K + lambda dG) x = 0

K   stiffness at the state with all present loads, K0 + N0 + G0
dG  what a unit of the extra load adds to the geometric stiffness: Hs(d_sigma) and the gradient of its own moments. The
    stresses d_sigma are the linear answer of the state to the load, with the drive as it stands (held where it is
    prescribed), in the present configuration:  K dq = W^T df,  d_sigma = S V dx and the reactions of constraints

lambda is counted in the load that was given; the proportional multiplier (theory-system.md 6.5) multiplies all loads
and prestresses instead. For a column under a load P the extra load of the same place has lambda = P_cr - P.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import EPS, Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.loaded_mechanism import AppliedForces, moment_entries
from spacar.errors import AnalysisError, Report
from spacar.kinematics.transfer import moved_along
from spacar.linear.buckling import BucklingModes, buckling_modes
from spacar.linear.eigen import vibration_modes
from spacar.linear.internal_unknowns import buckling_matrices, extra_load_matrices
from spacar.linear.lowest import is_symmetric_loading, lowest_vibration
from spacar.linear.lowest_multipliers import lowest_buckling, lowest_extra_load
from spacar.linear.node_compliance import compliance_of, displacements
from spacar.linear_systems.linear_system import matrix
from spacar.linearization.coefficients import geometric_stiffness
from spacar.linearization.matrices import Linearization
from spacar.mechanism.mechanism import Loads
from spacar.mechanism.numbering import Numbering
from spacar.stationary.flexibility import Flexibility
from spacar.stationary.tangent import STATIC, SparseTangent
from spacar.stroke.observed_node import ObservedNode


def _force(d: Dynamics, load: Loads) -> Array:
    """df (nx,) in the configuration."""
    return AppliedForces(d.mechanism, load, d.sweep)(d.kinematics.x, None)


class DrivePlace(NamedTuple):
    """The coordinate of the drive: its row of x, or of e for a `deformation`, and its place in q."""

    row: int
    deformation: bool
    place: int

    @classmethod
    def of(cls, n: Numbering, row: int, deformation: bool) -> DrivePlace:
        place = np.flatnonzero((n.q_e if deformation else n.q_x) == row)[0] + deformation * len(n.q_x)
        return cls(row, deformation, int(place))


class Frequencies(NamedTuple):
    """Frequencies (n,) [Hz] from low to high, unstable ones negative, and their motions (unknowns, n)."""

    hertz: Array
    motions: Array

    @classmethod
    def of(cls, values: NDArray[np.complex128], motions: NDArray[np.complex128]) -> Frequencies:
        """Of eigenvalues of undamped motion: of a pair the one with the positive imaginary, or positive real part."""
        chosen = np.flatnonzero((values.imag > 0.0) | ((values.imag == 0.0) & (values.real > 0.0)))
        hertz = np.abs(values[chosen]) / (2.0 * np.pi)
        hertz = np.where(values[chosen].imag > 0.0, hertz, -hertz)
        order = np.argsort(hertz, kind="stable")
        return cls(hertz[order], motions[:, chosen[order]].real)


class ReducedDrive:
    """The linearization L of a state; rows of q without the drive, and with it in the last place.

    `complete`: all modes and multipliers are computed, however many are `wanted`. Raises
    AnalysisError or SingularMatrixError where the state is critical.
    """

    complete = True

    def __init__(self, dynamics: Dynamics, L: Linearization, drive: DrivePlace) -> None:
        self.dynamics, self.L = dynamics, L
        dynamic = dynamics.numbering.dynamic
        others = dynamic[dynamic != drive.place]
        self._rows = others, np.append(others, drive.place)

    def moved(self, node: ObservedNode, free: bool) -> Array:
        """(m, q) displacements of the node by the degrees of freedom."""
        return node.map(self.dynamics.kinematics.x) @ self.L.G[np.ix_(node.rows, self._rows[free])]

    def compliance(self, node: ObservedNode, free: bool) -> Array:
        """(m, m) of the node."""
        return compliance_of(self._block(self.L.stiffness, free), self.moved(node, free))

    def path(self, node: ObservedNode) -> tuple[Array, float, Array]:
        """Velocity of the node (m,), dF/d(drive) and the motion of all unknowns, all by the drive."""
        K = self._block(self.L.stiffness, True)
        follow = -displacements(K[:-1, :-1], K[:-1, -1:])[:, 0]
        motion = np.append(follow, 1.0)
        return self.moved(node, True) @ motion, float(K[-1] @ motion), motion

    def vibration(self, free: bool, wanted: int, report: Report) -> Frequencies:
        """Without damping."""
        rows, L = self._rows[free], self.L
        if _massless(self._block(L.m0, free)):
            text = "the mass matrix is not positive definite; a motion carries no mass"
            raise AnalysisError(text, "dynamics.singular-mass")
        undamped = replace(L, c0=np.zeros_like(L.c0), d0=np.zeros_like(L.d0))
        found = vibration_modes(undamped, rows, rows, report, self.dynamics.numbering.twist_rates)
        return Frequencies.of(found.values, found.vectors[: len(rows)])

    def momenta(self, motions: Array) -> Array:
        """Mass matrix of the free drive times motions (unknowns, n)."""
        return self._block(self.L.m0, True) @ motions

    def buckling(self, free: bool, wanted: int, report: Report) -> BucklingModes:
        """Multipliers of all loads and prestresses."""
        return buckling_modes(*buckling_matrices(self.dynamics, self.L, self._rows[free]), report)

    def extra_stresses(self, free: bool, load: Loads) -> Array:
        """sigma (ne,) that the extra load adds. Raises AnalysisError 'compliance.singular'."""
        d, L, c, rows = self.dynamics, self.L, self.L.c, self._rows[free]
        df = _force(d, load)
        dq = displacements(self._block(L.stiffness, free), (L.W[:, rows].T @ df)[:, None])[:, 0]
        dx, dv = L.G[:, rows] @ dq, L.Z[:, rows] @ dq
        sigma = c.S @ (c.V @ dx) + c.Sd @ (L.Ze[:, rows] @ dq) + c.stress_x @ dx + c.stress_v @ dv
        force = (
            (c.inertia_x + c.geometric + c.load_x + c.user_x) @ dx
            + (c.inertia_v + c.user_v) @ dv
            + c.M @ (L.Y[:, rows] @ dq)
            - df
        )
        d.kinematics.reactions(force, sigma)
        return sigma

    def extra(self, sigma: Array, load: Loads, free: bool, wanted: int, report: Report) -> BucklingModes:
        """Multipliers of the extra load alone, with its stresses. Raises AnalysisError 'buckling.singular'."""
        d, L, rows = self.dynamics, self.L, self._rows[free]
        turned = matrix(*moment_entries(load.moment_rows, load.moment), L.G.shape[:1] * 2)
        loading = geometric_stiffness(d.sweep, sigma) - turned
        added = np.asarray((L.W[:, rows].T @ loading) @ L.G[:, rows])
        return buckling_modes(*extra_load_matrices(d, L, rows, self._block(L.stiffness, free), added, sigma), report)

    def contains_all(self, found: BucklingModes, wanted: int, free: bool) -> bool:
        """Are all finite multipliers among those that were found?"""
        return True

    def _block(self, A: Array, free: bool) -> Array:
        return A[np.ix_(self._rows[free], self._rows[free])]


def _massless(M: Array) -> bool:
    """Is the mass matrix singular to rounding, beside degrees of freedom without any mass?"""
    M = M[M.any(axis=1)][:, M.any(axis=0)]
    scale = 1.0 / np.sqrt(np.maximum(np.diag(M), np.finfo(float).tiny))
    values = np.linalg.eigvalsh(M * np.outer(scale, scale))
    return bool(values.min(initial=np.inf) <= EPS * len(M) * values.max(initial=0.0))


class MixedDrive:
    """As ReducedDrive, with tangents of one evaluator that stands at the state."""

    complete = False

    def __init__(self, dynamics: Dynamics, drive: DrivePlace) -> None:
        n, row = dynamics.numbering, drive.row
        self.dynamics, self.drive = dynamics, drive
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
        return P.T @ tangent.displacement(tangent.factor(STATIC), P)

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

    def vibration(self, free: bool, wanted: int, report: Report) -> Frequencies:
        found = lowest_vibration(self._tangents[free], report, wanted, undamped=True)
        assert found.motions is not None
        return Frequencies.of(found.values, found.motions)

    def momenta(self, motions: Array) -> Array:
        return self._tangents[True].assembled(("mass",)) @ motions

    def buckling(self, free: bool, wanted: int, report: Report) -> BucklingModes:
        return lowest_buckling(self._tangents[free], report, wanted)

    def extra_stresses(self, free: bool, load: Loads) -> Array:
        t = self._tangents[free]
        right = np.zeros(t.nf + t.ne)
        right[: t.nf] = _force(self.dynamics, load)[t.F]
        return t.flexibility.size * t.factor(STATIC).solve(right)[t.nf :]

    def extra(self, sigma: Array, load: Loads, free: bool, wanted: int, report: Report) -> BucklingModes:
        entries = moment_entries(load.moment_rows, load.moment)
        return lowest_extra_load(self._tangents[free], sigma, entries, report, wanted)

    def contains_all(self, found: BucklingModes, wanted: int, free: bool) -> bool:
        """If there are fewer than wanted, the others are infinite or, with an unsymmetric loading only, complex."""
        return len(found.multipliers) < wanted and is_symmetric_loading(self._tangents[free])

    def _forces(self, node: ObservedNode) -> Array:
        """Unit forces and moments on the node, (nx, m)."""
        d = self.dynamics
        P = np.zeros((d.numbering.nx, len(node.names)))
        P[node.rows] = node.map(d.kinematics.x).T
        return P


DriveEquations = ReducedDrive | MixedDrive
