"""The equations of a state with the drive held and free, from the dense linearized equations.

With q the dynamic degrees of freedom, d the drive, K = K0 + N0 + G0 of both (theory-system.md (12)):

    path            dq/dd = -K_qq^-1 K_qd           all other loads stay as they are
    drive           dF/dd = K_dd + K_dq dq/dd
    node, locked    C = D_q K_qq^-1 D_q^T;          free: C = D K^-1 D^T over q and d
    frequencies     of (K_qq, M_qq), of (K, M);     without damping
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError, Report
from spacar.linear.buckling import BucklingModes, buckling_modes
from spacar.linear.eigen import vibration_modes
from spacar.linear.internal_unknowns import buckling_matrices, extra_load_matrices
from spacar.linear.node_compliance import compliance_of, displacements
from spacar.linear_systems.linear_system import matrix
from spacar.linearization.coefficients import geometric_stiffness
from spacar.linearization.matrices import Linearization
from spacar.mechanism.numbering import Numbering
from spacar.stroke.extra_load import ExtraLoad
from spacar.stroke.observed_node import ObservedNode


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

    `complete`: all modes and multipliers are computed, however many are `wanted`, else up to `most`. Raises
    AnalysisError or SingularMatrixError where the state is critical.
    """

    complete = True

    def __init__(self, dynamics: Dynamics, L: Linearization, drive: DrivePlace) -> None:
        self.dynamics, self.L = dynamics, L
        self.most = dynamics.numbering.nddof
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

    def vibration(self, free: bool, wanted: int, told: Report) -> Frequencies:
        """Without damping."""
        rows, L = self._rows[free], self.L
        if not len(rows):
            return Frequencies.of(np.zeros(0, complex), np.zeros((0, 0), complex))
        if _massless(self._block(L.m0, free)):
            text = "the mass matrix is not positive definite; a motion carries no mass"
            raise AnalysisError(text, "dynamics.singular-mass")
        undamped = replace(L, c0=np.zeros_like(L.c0), d0=np.zeros_like(L.d0))
        found = vibration_modes(undamped, rows, rows, told, self.dynamics.numbering.twist_rates)
        return Frequencies.of(found.values, found.vectors[: len(rows)])

    def momenta(self, motions: Array) -> Array:
        """Mass matrix of the free drive times motions (unknowns, n)."""
        return np.asarray(self._block(self.L.m0, True) @ motions)

    def buckling(self, free: bool, wanted: int, told: Report) -> BucklingModes:
        """Multipliers of all loads and prestresses."""
        rows = self._rows[free]
        if not len(rows):
            return BucklingModes(np.zeros(0), np.zeros((0, 0)))
        return buckling_modes(*buckling_matrices(self.dynamics, self.L, rows), told)

    def extra_stresses(self, free: bool, load: ExtraLoad) -> Array:
        """sigma (ne,) that the extra load adds. Raises AnalysisError 'compliance.singular'."""
        d, L, c, rows = self.dynamics, self.L, self.L.c, self._rows[free]
        df = load.at(d.kinematics.x)
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
        return np.asarray(sigma)

    def extra(self, free: bool, sigma: Array, load: ExtraLoad, wanted: int, told: Report) -> BucklingModes:
        """Multipliers of the extra load alone, with its stresses. Raises AnalysisError 'buckling.singular'."""
        d, L, rows = self.dynamics, self.L, self._rows[free]
        if not len(rows):
            return BucklingModes(np.zeros(0), np.zeros((0, 0)))
        loading = geometric_stiffness(d.sweep, sigma) - matrix(*load.gradient_entries(), L.G.shape[:1] * 2)
        added = np.asarray((L.W[:, rows].T @ loading) @ L.G[:, rows])
        return buckling_modes(*extra_load_matrices(d, L, rows, self._block(L.stiffness, free), added, sigma), told)

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
    return bool(values.min(initial=np.inf) <= np.finfo(float).eps * len(M) * values.max(initial=0.0))
