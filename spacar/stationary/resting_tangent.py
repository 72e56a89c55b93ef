"""The tangent of the mixed equations at rest, in the storage of `SparseTangent`."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from spacar.arrays import Array
from spacar.linear_systems import LinearSystem, SingularMatrixError
from spacar.linear_systems.matrix_inertia import Inertia
from spacar.linear_systems.reciprocal_condition import entry_rounding
from spacar.linearization.coefficients import geometric_blocks
from spacar.stationary.definite import DefiniteStiffness
from spacar.stationary.stationary_equations import Iterate
from spacar.stationary.tangent import STATIC, SparseTangent, TangentTerm

SYMMETRIC = 1e-12  # relative: rounding of the element blocks


class RestingTangent:
    """`factor` at the point where the sweep is, then `solve`. The counterpart of `MovingTangent`."""

    exact = True

    def __init__(self, sparse: SparseTangent) -> None:
        self.t = sparse
        self._entries, self._entries_of = np.zeros(0), object()

    @cached_property
    def _inertia(self) -> Inertia:
        rank = getattr(self.system, "row_rank", None)  # of band storage
        return Inertia(self.t.nf + self.t.ne, *self.t.pattern(tuple(STATIC)), rank)

    @cached_property
    def _definite(self) -> DefiniteStiffness:
        return DefiniteStiffness(self.t)

    @cached_property
    def _unsymmetric(self) -> list[TangentTerm]:
        """Terms that may be so."""
        loading = self.t.parts["load"], self.t.parts["moment"]
        return [p for p in loading if len(p.rows)]

    @cached_property
    def system(self) -> LinearSystem:
        return self.t.system()

    def entries(self, point: Iterate) -> Array:
        """Of the matrix at the point where the sweep is; evaluated once."""
        self.t.sigma = point.sigma
        if self._entries_of is not point:
            self._entries, self._entries_of = self.t.entries(STATIC)[0], point
        return self._entries

    def factor(self, point: Iterate) -> None:
        """Raises SingularMatrixError."""
        self.system.factor(self.entries(point))

    def solve(self, right: Array) -> Array:
        """Solution for right-hand sides (n,) or (n, k). Raises SingularMatrixError (dense storage factors here)."""
        return self.system.solve(right)

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
        return np.bincount(rows * n + columns, self._entries, n * n).reshape(n, n)

    def rounding(self, z: Array) -> Array:
        """eps |matrix| |z|, (n,)."""
        return entry_rounding(len(z), *self.t.pattern(tuple(STATIC)), self._entries, z)

    @property
    def symmetric(self) -> bool:
        """Is the matrix symmetric? Follower moments and the flow in tubes make it unsymmetric."""
        n = self.t.nf
        for part in self._unsymmetric:
            values, rows, columns = part.values(), part.rows.astype(np.int64), part.columns.astype(np.int64)
            both = np.concatenate((rows * n + columns, columns * n + rows))
            places, at = np.unique(both, return_inverse=True)
            entries = np.bincount(at[: len(values)], values, len(places))
            difference = entries - np.bincount(at[len(values) :], values, len(places))
            if np.abs(difference).max(initial=0.0) > SYMMETRIC * np.abs(entries).max(initial=0.0):
                return False
        return True

    def natural(self, point: Iterate) -> bool:
        """Is there nothing but the stiffness of the elements, and this not negative? Then no eigenvalue of K is."""
        loaded = point.sigma.any() or any(part.values().any() for part in self._unsymmetric)
        return not loaded and self.t.flexibility.definite

    def is_definite(self, point: Iterate) -> bool:
        """Is it proved that no eigenvalue of the tangent stiffness is negative at the point where the sweep is?"""
        if self.system.kind == "condensed":
            return self._counted(point) == self.t.ne
        return self._definite.proved(self.entries(point))

    def _counted(self, point: Iterate) -> int | None:
        """Negative eigenvalues of the matrix by its condensed factors; None where these do not tell."""
        try:
            self.factor(point)
        except SingularMatrixError:
            return None
        return self.system.negative()

    def sign(self) -> float:
        """Sign of the determinant of the tangent stiffness."""
        # The mixed matrix has one negative eigenvalue more for every stress.
        return self.system.determinant_sign() * (-1.0) ** self.t.ne

    def inertia(self, point: Iterate) -> tuple[int, int]:
        """Negative and zero eigenvalues of the matrix at the point where the sweep is."""
        if self.system.kind == "condensed":
            negative = self._counted(point)
            if negative is not None:
                return negative, 0
        return self._inertia(self.entries(point))
