"""Static Newton step without dense matrices (theory-system.md (18)), and the sparse pencils of vibration and buckling.

    [ K_x   V_RF^T ] [ dx_F    ]   [ (f - h - V_A^T sigma_A)_F ]
    [ V_RF  0      ] [ sigma_R ] = [ 0                          ],    K_x = V_A^T S V_A + Hs(sigma) - df/dx + dh/dx

All blocks are element-local; with reverse Cuthill-McKee ordering the cost is linear for chains.
"""

from __future__ import annotations

import numpy as np

from spacar.dynamics.dynamics import Dynamics
from spacar.dynamics.forces import moment_gradient
from spacar.errors import AnalysisError
from spacar.linear.contractions import geometric_blocks, inertia_blocks
from spacar.linear_systems import SingularMatrixError, assemble
from spacar.mechanism.mechanism import Array, Batch, Index

Entries = tuple[Index, Index, Array]


class SparseTangent:
    """Static tangent at the placed configuration."""

    def __init__(self, dynamics: Dynamics) -> None:
        self.dynamics = dynamics
        n = dynamics.numbering
        xs = n.x_class
        self.F = np.r_[
            xs["calculable"].start : xs["calculable"].stop, xs["dynamic"].start : xs["dynamic"].stop
        ]
        self.n_rows = n.e_class["input"].stop
        self.place = np.full(n.nx, -1)
        self.place[self.F] = np.arange(len(self.F))

    def correction(self, sigma: Array, full: Array) -> Array:
        """Change of the dynamic degrees of freedom of one Newton step, (nddof,)."""
        d = self.dynamics
        n, sweep = d.numbering, d.sweep
        nf = len(self.F)
        entries = self.constraint_entries() + [material_entries(d), geometric_entries(d, full), load_entries(d)]
        rows, columns, values = self.restrict(entries)
        active = sigma.copy()
        active[: self.n_rows] = 0.0
        force = d.forces(d.kinematics.x, None) - d.forces.inertia(sweep, np.zeros(n.nx)) - sweep.rate_transposed(active)
        system = assemble(nf + self.n_rows, rows, columns)
        try:
            system.factor(values)
            solution = system.solve(np.concatenate((force[self.F], np.zeros(self.n_rows))))
        except SingularMatrixError as error:
            raise AnalysisError(
                f"the tangent stiffness is singular ({error}); a motion without stiffness, or exactly a critical load",
                "statics.no-solution",
            ) from None
        dx = np.zeros(n.nx)
        dx[self.F] = solution[:nf]
        de = sweep.rate(dx)
        return np.concatenate((dx[n.x_class["dynamic"]], de[n.e_class["dynamic"]]))

    def constraint_entries(self) -> list[Entries]:
        """V_RF and its transpose, already in the numbering of the system."""
        sweep, nf = self.dynamics.sweep, len(self.F)
        keep = np.flatnonzero((sweep.v_rows < self.n_rows) & (self.place[sweep.v_columns] >= 0))
        r, c, v = nf + sweep.v_rows[keep], self.place[sweep.v_columns[keep]], sweep.v_entries[keep]
        self._constraints = (np.r_[r, c], np.r_[c, r], np.r_[v, v])
        return []

    def restrict(self, entries: list[Entries]) -> Entries:
        """Coordinate entries restricted to F, together with the constraint entries."""
        rows, columns, values = [self._constraints[0]], [self._constraints[1]], [self._constraints[2]]
        for i, j, v in entries:
            a, b = self.place[i], self.place[j]
            keep = (a >= 0) & (b >= 0)
            rows.append(a[keep])
            columns.append(b[keep])
            values.append(v[keep])
        return np.concatenate(rows), np.concatenate(columns), np.concatenate(values)


def block_entries(blocks: list[tuple[Batch, Array]]) -> Entries:
    """Square element blocks as rows, columns, values of an (nx, nx) matrix."""
    if not blocks:
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
    rows = [np.broadcast_to(b.x[:, None, :], block.shape).ravel() for b, block in blocks]
    columns = [np.broadcast_to(b.x[None, :, :], block.shape).ravel() for b, block in blocks]
    return np.concatenate(rows), np.concatenate(columns), np.concatenate([block.ravel() for _, block in blocks])


def material_entries(d: Dynamics) -> Entries:
    """V_A^T S V_A."""
    sweep, first = d.sweep, d.law.first
    blocks = []
    for b in sweep.strained:
        S, _ = b.family.stiffness()
        if S.any():
            active = (b.e >= first).astype(float)
            S = S * active[:, None] * active[None, :]
            V = sweep.V[id(b)]
            SV = np.einsum("abn,bjn->ajn", S, V)
            blocks.append((b, np.einsum("ain,ajn->ijn", V, SV)))
    return block_entries(blocks)


def geometric_entries(d: Dynamics, sigma: Array) -> Entries:
    """Hs(sigma)."""
    return block_entries(geometric_blocks(d.sweep, sigma))


def load_entries(d: Dynamics) -> Entries:
    """d(h - f)/dx at rest: gravity on moving families, tube flow, constant moments."""
    n = d.numbering
    zero = np.zeros(n.nx)
    by_x, _ = inertia_blocks(d.sweep, zero, -d.forces.field if d.forces.heavy else zero)
    rows, columns, values = block_entries(by_x)
    moment_rows = d.forces.loads.moment_rows
    if not moment_rows.size:
        return rows, columns, values
    K = moment_gradient(d.forces.loads.moment)
    i = np.broadcast_to(moment_rows[:, None, :], K.shape).ravel()
    j = np.broadcast_to(moment_rows[None, :, :], K.shape).ravel()
    return np.r_[rows, i], np.r_[columns, j], np.r_[values, -K.ravel()]

