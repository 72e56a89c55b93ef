"""The tangent of the mixed equations at rest, in the storage of `SparseTangent`."""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.linear_systems import LinearSystem
from spacar.linear_systems.lost_digits import entry_rounding
from spacar.linear_systems.matrix_inertia import Inertia
from spacar.linearization.contractions import geometric_blocks
from spacar.stationary.stationary_equations import Iterate
from spacar.stationary.tangent import STATIC, SparseTangent

SYMMETRIC = 1e-12  # relative: rounding of the element blocks


class RestingTangent:
    """`factor` at the point where the sweep is, then `solve`. The counterpart of `MovingTangent`."""

    exact = True

    def __init__(self, sparse: SparseTangent) -> None:
        self.t = sparse
        self._system: LinearSystem | None = None
        self._inertia: Inertia | None = None
        loading = sparse.parts["load"], sparse.parts["moment"]
        self._unsymmetric = [p for p in loading if len(p.keep)]

    def factor(self, point: Iterate) -> None:
        """Raises SingularMatrixError."""
        self.t.sigma = point.sigma
        self._system = self.t.factor_static()

    def solve(self, right: Array) -> Array:
        """Solution for right-hand sides (n,) or (n, k). Raises SingularMatrixError (dense storage factors here)."""
        assert self._system is not None
        return self._system.solve(right)

    def along(self, dx: Array) -> Array:
        """The matrix times a change dx (nx,) of prescribed coordinates, (n,). The gradient of the loads is left out."""
        t, sweep = self.t, self.t.dynamics.sweep
        force = np.zeros_like(dx)
        for b, block in geometric_blocks(sweep, t.sigma):
            np.add.at(force, b.x, np.einsum("abn,bn->an", block, dx[b.x]))
        C = t.flexibility
        return np.concatenate((force[t.F], C.size * C.coupled * sweep.rate(dx)))

    def dense(self) -> Array:
        """The matrix, (n, n)."""
        n = self.t.nf + self.t.ne
        rows, columns = self.t.pattern(tuple(STATIC))
        return np.bincount(rows * n + columns, self.t.entries(STATIC)[0], n * n).reshape(n, n)

    def rounding(self, z: Array) -> Array:
        """eps |matrix| |z|, (n,)."""
        return entry_rounding(len(z), *self.t.pattern(tuple(STATIC)), self.t.entries(STATIC)[0], z)

    @property
    def symmetric(self) -> bool:
        """Is the matrix symmetric? Follower moments and the flow in tubes make it unsymmetric."""
        from scipy.sparse import coo_matrix

        for part in self._unsymmetric:
            A = coo_matrix((part.values(), (part.rows, part.columns)), (self.t.nf, self.t.nf)).tocsr()
            if abs(A - A.T).max() > SYMMETRIC * abs(A).max():
                return False
        return True

    @property
    def natural(self) -> bool:
        """Is there nothing but the stiffness of the elements, and this not negative? Then no eigenvalue of K is."""
        t = self.t
        loaded = t.sigma.any() or any(part.values().any() for part in self._unsymmetric)
        return not loaded and t.flexibility.definite

    def sign(self) -> float:
        """Sign of the determinant of the tangent stiffness."""
        # The mixed matrix has one negative eigenvalue more for every stress.
        assert self._system is not None
        return self._system.determinant_sign() * (-1.0) ** self.t.ne

    def inertia(self) -> tuple[int, int]:
        """Negative and zero eigenvalues of the matrix at the sweep's configuration and `sigma`."""
        from spacar.linear_systems.banded import BandedSystem

        if self._inertia is None:
            rank = self._system.row_rank if isinstance(self._system, BandedSystem) else None
            self._inertia = Inertia(self.t.nf + self.t.ne, *self.t.pattern(tuple(STATIC)), rank)
        return self._inertia(self.t.entries(STATIC)[0])
