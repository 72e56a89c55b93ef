"""The static tangent without dense matrices (theory-system.md 6.2).

    [ K_x   V_RF^T ] [ dx_F    ]   [ (f - h - V_A^T sigma_A)_F ]
    [ V_RF  0      ] [ sigma_R ] = [ 0                          ],    K_x = V_A^T S V_A + Hs(sigma) + d(h - f)/dx      (18)

F: coordinates that are not prescribed, R: fixed and input deformations. All blocks are element-local; the pattern, its
ordering and the element stiffness S are made once per model, an iteration only fills values. The same parts, weighted,
are the pencils of vibration, (K_x + s^2 M), and of buckling, (V_A^T S V_A).

Only for systems at rest, holonomic, without user functions and MEE.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spacar.dynamics.dynamics import Dynamics
from spacar.dynamics.forces import moment_gradient
from spacar.linear.contractions import configuration_of, geometric_blocks
from spacar.linear_systems import SingularMatrixError, System, assemble
from spacar.mechanism.mechanism import Array, Batch, Index

SINGULAR = 1e14  # growth |A| |A^-1 b| / |b| above which the matrix counts as singular


class Part:
    """Entries (rows, columns) in coordinates of one term of the matrix, restricted to F, and how to get their values."""

    def __init__(self, place: Index, rows: Index, columns: Index, values: Callable[[], Array]) -> None:
        a, b = place[rows], place[columns]
        self.keep = np.flatnonzero((a >= 0) & (b >= 0))
        self.rows, self.columns = a[self.keep], b[self.keep]
        self._values = values

    def values(self) -> Array:
        """Values at the present configuration, in the order of rows and columns."""
        return self._values()[self.keep]


class SparseTangent:
    """The parts of the tangent of one Dynamics, and the system that factors weighted sums of them."""

    def __init__(self, dynamics: Dynamics) -> None:
        self.dynamics = dynamics
        n, sweep = dynamics.numbering, dynamics.sweep
        free = [np.arange(n.x_class[c].start, n.x_class[c].stop) for c in ("calculable", "dynamic")]
        self.F = np.concatenate(free)
        self.nf, self.n_rows = len(self.F), n.e_class["input"].stop
        self.place = np.full(n.nx, -1)
        self.place[self.F] = np.arange(self.nf)
        self.sigma = np.zeros(n.ne)
        self.stiff = _active_blocks(dynamics, 0)
        self.damped = _active_blocks(dynamics, 1)
        loaded = [b for b in sweep.moving if dynamics.forces.heavy or hasattr(b.family, "with_flow")]
        moment_rows = _moment_rows(dynamics)
        self.parts = {
            "material": Part(self.place, *_square([b for b, _ in self.stiff]), lambda: self._constitutive(self.stiff)),
            "geometric": Part(self.place, *_square(sweep.curved), self._geometric),
            "load": Part(self.place, *_square(loaded), lambda: self._inertia(loaded, 0)),
            "moment": Part(self.place, *_pairs(moment_rows), lambda: self._moments(moment_rows.shape[1])),
            "mass": Part(self.place, sweep.m_rows, sweep.m_columns, lambda: sweep.m_entries),
            "damping": Part(self.place, *_square([b for b, _ in self.damped]), lambda: self._constitutive(self.damped)),
            "flow": Part(self.place, *_square(loaded), lambda: self._inertia(loaded, 1)),
        }
        self._constraint = np.flatnonzero((sweep.v_rows < self.n_rows) & (self.place[sweep.v_columns] >= 0))
        self._systems: dict[tuple[str, ...], System] = {}

    def factor(self, weights: dict[str, float]) -> System:
        """Factored saddle-point matrix of the weighted parts. Raises SingularMatrixError, also for growth above 1e14."""
        names = tuple(weights)
        v = self.dynamics.sweep.v_entries[self._constraint]
        if names not in self._systems:
            i = self.nf + self.dynamics.sweep.v_rows[self._constraint]
            j = self.place[self.dynamics.sweep.v_columns[self._constraint]]
            rows = np.concatenate([self.parts[k].rows for k in names] + [i, j])
            columns = np.concatenate([self.parts[k].columns for k in names] + [j, i])
            self._systems[names] = assemble(self.nf + self.n_rows, rows, columns)
        system = self._systems[names]
        values = [w * self.parts[k].values() for k, w in weights.items()]
        # constraint rows of the size of the stiffness: the pivots of both blocks then compare
        self.row_scale = max((float(np.max(np.abs(u), initial=0.0)) for u in values), default=1.0) or 1.0
        system.factor(np.concatenate([*values, self.row_scale * v, self.row_scale * v]))
        probe = np.zeros(self.nf + self.n_rows)
        probe[: self.nf] = self.row_scale
        growth = float(np.max(np.abs(system.solve(probe)[: self.nf]), initial=0.0))
        if not growth < SINGULAR:
            raise SingularMatrixError(f"the stiffness is singular to working precision (growth {growth:.2g})")
        return system

    def displacement(self, system: System, force: Array) -> Array:
        """Coordinates (nx,) or (nx, k) that the force (nx,) or (nx, k) on F produces, the constraint rows kept."""
        b = np.zeros((self.nf + self.n_rows, *force.shape[1:]))
        b[: self.nf] = force[self.F]
        x = np.zeros_like(force)
        x[self.F] = system.solve(b)[: self.nf]
        return x

    def correction(self, sigma: Array, full: Array) -> Array:
        """Change of the dynamic degrees of freedom of one Newton step, (nddof,). Raises SingularMatrixError."""
        d = self.dynamics
        n, sweep = d.numbering, d.sweep
        self.sigma = full
        active = sigma.copy()
        active[: self.n_rows] = 0.0
        force = d.forces(d.kinematics.x, None) - d.forces.inertia(sweep, np.zeros(n.nx)) - sweep.rate_transposed(active)
        dx = self.displacement(self.factor(STATIC), force)
        de = sweep.rate(dx)
        return np.concatenate((dx[n.x_class["dynamic"]], de[n.e_class["dynamic"]]))

    def times(self, names: tuple[str, ...], x: Array) -> Array:
        """Sum of parts times x (nx, k), rows and columns F only."""
        from scipy.sparse import coo_matrix

        values = np.concatenate([self.parts[k].values() for k in names])
        rows = np.concatenate([self.parts[k].rows for k in names])
        columns = np.concatenate([self.parts[k].columns for k in names])
        out = np.zeros_like(x)
        out[self.F] = coo_matrix((values, (rows, columns)), (self.nf, self.nf)).tocsr() @ x[self.F]
        return out

    # -- values of the parts ------------------------------------------------------------------------------------
    def _constitutive(self, blocks: list[tuple[Batch, Array]]) -> Array:
        V = self.dynamics.sweep.V
        products = []
        for b, S in blocks:
            SV = np.einsum("abn,bjn->ajn", S, V[id(b)])
            products.append(np.einsum("ain,ajn->ijn", V[id(b)], SV).ravel())
        return _joined(products)

    def _geometric(self) -> Array:
        return _joined([block.ravel() for _, block in geometric_blocks(self.dynamics.sweep, self.sigma)])

    def _inertia(self, batches: list[Batch], which: int) -> Array:
        """d(h - gravity)/dx (0) or dh/dv (1) at rest."""
        sweep, zero = self.dynamics.sweep, np.zeros(self.dynamics.numbering.nx)
        a = -self.dynamics.forces.field
        return _joined(
            [
                b.family.inertia_gradient(configuration_of(sweep, b), zero[b.x], a[b.x])[which].ravel()
                for b in batches
            ]
        )

    def _moments(self, n: int) -> Array:
        loads = self.dynamics.forces.loads
        moments = np.zeros((n, 3))  # the additional ones come later and are zero until then
        moments[: len(loads.moment)] = loads.moment
        return -moment_gradient(moments).ravel()


STATIC = {"material": 1.0, "geometric": 1.0, "load": 1.0, "moment": 1.0}


def _active_blocks(d: Dynamics, which: int) -> list[tuple[Batch, Array]]:
    """S (0) or S_d (1) of the batches that have it, restricted to active rows."""
    blocks = []
    for b in d.sweep.strained:
        active = (b.e >= d.law.first).astype(float)
        S = b.family.stiffness()[which] * active[:, None] * active[None, :]
        if S.any():
            blocks.append((b, S))
    return blocks


def _moment_rows(d: Dynamics) -> Index:
    """Rows of lambda with moments, those of the additional loading behind the others, (4, n)."""
    m = d.mechanism
    additional = [m.additional.moment_rows] if m.additional is not None else []
    return np.concatenate([m.loads.moment_rows, *additional], axis=1)


def _square(batches: list[Batch]) -> tuple[Index, Index]:
    """Rows and columns of square element blocks."""
    shapes = [(len(b.x), len(b.x), b.family.n) for b in batches]
    rows = [np.broadcast_to(b.x[:, None, :], s).ravel() for b, s in zip(batches, shapes, strict=True)]
    columns = [np.broadcast_to(b.x[None, :, :], s).ravel() for b, s in zip(batches, shapes, strict=True)]
    return _joined_index(rows), _joined_index(columns)


def _pairs(rows: Index) -> tuple[Index, Index]:
    shape = (len(rows), len(rows), rows.shape[1])
    return np.broadcast_to(rows[:, None, :], shape).ravel(), np.broadcast_to(rows[None, :, :], shape).ravel()


def _joined(parts: list[Array]) -> Array:
    return np.concatenate(parts) if parts else np.zeros(0)


def _joined_index(parts: list[Index]) -> Index:
    return np.concatenate(parts) if parts else np.zeros(0, np.int64)
