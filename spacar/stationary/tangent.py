"""The static tangent without dense matrices (theory-system.md 6.2), in mixed form.

    [ K_g  V^T ] [ dx_F  ]   [ (f - h - V_A^T sigma_A)_F ]
    [ V    -C  ] [ sigma ] = [ 0                          ],     K_g = Hs(sigma) + d(h - f)/dx

F: coordinates that are not prescribed. C is the flexibility of the elements: zero for fixed and input deformations
(then sigma is a multiplier as in (18)), the inverse of the element stiffness S for the elastic ones; deformations
without stiffness have sigma = 0. The elimination of sigma gives K_x = V_A^T S V_A + K_g of (18), whose rounding
errors grow with the fourth power of the number of beams in a chain; here they grow with the second.

All blocks are element-local; the pattern, its ordering and S are made once per model, an iteration only fills values.
The same parts, weighted, are the pencils of vibration (K_x + s^2 M + s C_d) and of buckling (K_x without K_g).
Only for systems at rest, holonomic, without user functions and MEE.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from spacar.dynamics.dynamics import Dynamics
from spacar.dynamics.forces import moment_gradient
from spacar.linear_systems import SingularMatrixError, System, assemble
from spacar.linearization.contractions import configuration_of, geometric_blocks
from spacar.mechanism.mechanism import Array, Batch, Index

SINGULAR = 1e14  # displacements under a load of the size of the stiffness above which it counts as singular


class Part:
    """Entries (rows, columns) of one term of the matrix, restricted to F, and how to get their values."""

    def __init__(self, place: Index, rows: Index, columns: Index, values: Callable[[], Array]) -> None:
        a, b = place[rows], place[columns]
        self.keep = np.flatnonzero((a >= 0) & (b >= 0))
        self.rows, self.columns = a[self.keep], b[self.keep]
        self._values = values

    def values(self) -> Array:
        """Values at the present configuration, in the order of rows and columns."""
        return self._values()[self.keep] if len(self.keep) else np.zeros(0)


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
        self.elastic = [b for b in sweep.strained if any(S.any() for S in b.family.stiffness())]
        self.active = {b.index: (b.e >= dynamics.law.first).astype(float) for b in self.elastic}
        loaded = [b for b in sweep.moving if dynamics.forces.heavy or hasattr(b.family, "with_flow")]
        moment_rows = _moment_rows(dynamics)
        self.parts = {
            "geometric": Part(self.place, *_square(sweep.curved), self._geometric),
            "load": Part(self.place, *_square(loaded), lambda: self._inertia(loaded, 0)),
            "moment": Part(self.place, *_pairs(moment_rows), lambda: self._moments(moment_rows.shape[1])),
            "mass": Part(self.place, sweep.m_rows, sweep.m_columns, lambda: sweep.m_entries),
            "flow": Part(self.place, *_square(loaded), lambda: self._inertia(loaded, 1)),
        }
        self.ne = n.ne
        self._v = np.flatnonzero(self.place[sweep.v_columns] >= 0)
        self._flexible = _square_e(self.elastic)
        self._rigid = np.setdiff1d(np.arange(n.ne), self._flexible[0])  # rows of other elements: only a diagonal
        self._systems: dict[tuple[str, ...], System] = {}
        self._flexibilities: dict[tuple[float, float], tuple[Array, Array, float]] = {}

    @property
    def damped(self) -> bool:
        """Does any active deformation or the flow in a tube give forces proportional to rates?"""
        viscous = any((b.family.stiffness()[1] * self.active[b.index]).any() for b in self.elastic)
        return viscous or bool(self.parts["flow"].values().any())

    def factor(self, weights: dict[str, float], stiffness: float = 1.0, damping: float = 0.0) -> System:
        """Factored matrix of the weighted parts and of the element matrices stiffness x S + damping x S_d.

        Raises SingularMatrixError, also when displacements under a load of the size of the stiffness exceed 1e14.
        """
        system = self._fill(weights, stiffness, damping)
        self._check_growth(system.solve(self._probe()))
        return system

    def _probe(self) -> Array:
        """A load of the size of the stiffness on all coordinates."""
        probe = np.zeros(self.nf + self.ne)
        probe[: self.nf] = self._size
        return probe

    def _check_growth(self, solution: Array) -> None:
        growth = float(np.max(np.abs(solution[: self.nf]), initial=0.0))
        if not growth < SINGULAR:
            raise SingularMatrixError(f"the stiffness is singular to working precision (growth {growth:.2g})")

    def _fill(self, weights: dict[str, float], stiffness: float = 1.0, damping: float = 0.0) -> System:
        sweep, names = self.dynamics.sweep, tuple(weights)
        if names not in self._systems:
            i, j = self.nf + sweep.v_rows[self._v], self.place[sweep.v_columns[self._v]]
            a, b = (self.nf + k for k in self._flexible)
            c = self.nf + self._rigid
            rows = np.concatenate([self.parts[k].rows for k in names] + [i, j, a, c])
            columns = np.concatenate([self.parts[k].columns for k in names] + [j, i, b, c])
            self._systems[names] = assemble(self.nf + self.ne, rows, columns)
        system = self._systems[names]
        if (stiffness, damping) not in self._flexibilities:
            self._flexibilities[stiffness, damping] = self._flexibility(stiffness, damping)
        flexibility, coupled, size = self._flexibilities[stiffness, damping]
        diagonal = np.where(self._rigid >= self.n_rows, -1.0, 0.0)
        v = sweep.v_entries[self._v] * coupled[sweep.v_rows[self._v]]
        values = [w * self.parts[k].values() for k, w in weights.items()]
        # multiplied by a typical stiffness, the rows of all unknowns compare
        system.factor(np.concatenate([*values, size * v, size * v, -size * flexibility, size * diagonal]))
        self._size = size
        return system

    def _flexibility(self, stiffness: float, damping: float) -> tuple[Array, Array, float]:
        """C times `size`, in the order of `_flexible`; which rows of e have stiffness (ne,); the largest stiffness."""
        coupled, blocks = np.zeros(self.ne), []
        for b in self.elastic:
            S, Sd = b.family.stiffness()
            S = stiffness * S + damping * Sd
            n = len(b.e)
            elastic = (S[np.arange(n), np.arange(n)] > 0.0) * self.active[b.index]
            S = S * elastic[:, None] * elastic[None, :]
            coupled[b.e] = elastic
            blocks.append((b, S, elastic))
        size = max((float(np.max(np.abs(S), initial=0.0)) for _, S, _ in blocks), default=1.0) or 1.0
        values = []
        for b, S, elastic in blocks:
            n = len(b.e)
            S = S / size
            S[np.arange(n), np.arange(n)] += 1.0 - elastic  # decoupled rows: sigma = 0, or the multiplier below
            C = np.linalg.inv(S.transpose(2, 0, 1)).transpose(1, 2, 0)
            passive = (b.e < self.n_rows).astype(float)
            C[np.arange(n), np.arange(n)] -= passive
            values.append(C.ravel())
        coupled[: self.n_rows] = 1.0
        return _joined(values), coupled, size

    def displacement(self, system: System, force: Array) -> Array:
        """Coordinates (nx,) or (nx, k) that the force (nx,) or (nx, k) on F produces, the constraint rows kept."""
        b = np.zeros((self.nf + self.ne, *force.shape[1:]))
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
        system = self._fill(STATIC)
        b = np.stack((self._probe(), np.zeros(self.nf + self.ne)), axis=1)
        b[: self.nf, 1] = force[self.F]
        solution = system.solve(b)  # both at once: dense storage factors at every solution
        self._check_growth(solution[:, 0])
        dx = np.zeros(n.nx)
        dx[self.F] = solution[: self.nf, 1]
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

    def viscous(self, x: Array) -> Array:
        """V^T S_d V x of displacements (nx, k)."""
        sweep = self.dynamics.sweep
        out = np.zeros_like(x)
        for k in range(x.shape[1]):
            e, sigma = sweep.rate(x[:, k]), np.zeros(self.ne)
            for b in self.elastic:
                active = self.active[b.index]
                sigma[b.e] = active * np.einsum("abn,bn->an", b.family.stiffness()[1], active * e[b.e])
            out[self.F, k] = sweep.rate_transposed(sigma)[self.F]
        return out

    # -- values of the parts ------------------------------------------------------------------------------------
    def _geometric(self) -> Array:
        return _joined([block.ravel() for _, block in geometric_blocks(self.dynamics.sweep, self.sigma)])

    def _inertia(self, batches: list[Batch], which: int) -> Array:
        """d(h - gravity)/dx (0) or dh/dv (1) at rest."""
        sweep, zero = self.dynamics.sweep, np.zeros(self.dynamics.numbering.nx)
        a = -self.dynamics.forces.field
        return _joined(
            [b.family.inertia_gradient(configuration_of(sweep, b), zero[b.x], a[b.x])[which].ravel() for b in batches]
        )

    def _moments(self, n: int) -> Array:
        loads = self.dynamics.forces.loads
        moments = np.zeros((n, 3))  # the additional ones come later and are zero until then
        moments[: len(loads.moment)] = loads.moment
        return -moment_gradient(moments).ravel()


STATIC = {"geometric": 1.0, "load": 1.0, "moment": 1.0}


def _square_e(batches: list[Batch]) -> tuple[Index, Index]:
    """Rows and columns of square blocks over the deformations of elements."""
    shapes = [(len(b.e), len(b.e), b.family.n) for b in batches]
    rows = [np.broadcast_to(b.e[:, None, :], s).ravel() for b, s in zip(batches, shapes, strict=True)]
    columns = [np.broadcast_to(b.e[None, :, :], s).ravel() for b, s in zip(batches, shapes, strict=True)]
    return _joined_index(rows), _joined_index(columns)


def _moment_rows(d: Dynamics) -> Index:
    """Rows of lambda with moments, those of the additional loading behind the others, (4, n)."""
    m = d.mechanism
    additional = [m.additional.moment_rows] if m.additional is not None else []
    return np.concatenate([m.loads.moment_rows, *additional], axis=1)


def _square(batches: Sequence[Batch]) -> tuple[Index, Index]:
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
