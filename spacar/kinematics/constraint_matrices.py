"""The matrices of position and velocity of a mechanism as linear systems, made and factored when they are asked for.

Position level: D_h by the calculable coordinates c. Velocity level: V[E, U] (theory-system.md section 1.1). Both take
their entries from the sweep of the elements; without slips they are the same.

The difference matrix dD/dx is made comparable: lengths and rotations without dimension. `is_single_root`: is a position
that solves D(x) = e to rounding a single root, or are two of them nearer than rounding tells apart?

With the smallest singular value s of the scaled matrix D' (of the position, or of the velocities), D' w = s u, a change
a of the position along w changes the residual along u by

    s a + c a^2/2,    c = u^T H(w, w)                                       (H: second derivative of the deformations)

The second root is at a = -2 s/c. The residual is known to delta only, so that both roots cannot be told apart when

    s^2 <= 2 |c| delta

(the condition of Kantorovich, along the one direction that matters). There the position has the error s/c, and the
velocities, which go with 1/s, are wrong by half of their size. At a dead point c is of order one and s is zero; in a
long chain s is small, n^-2, but c nearly vanishes, and every position is determined. Rank-deficient to rounding is
s <= n eps |D'|.
"""

from contextlib import suppress
from functools import cached_property
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import EPS, Array, Index
from spacar.kinematics.element_sweep import ElementSweep
from spacar.linear_systems import LinearSystem, SingularMatrixError, assemble
from spacar.linear_systems.reciprocal_condition import smallest
from spacar.mechanism.mechanism import Mechanism
from spacar.mechanism.numbering import places_in

ROUNDING = 64.0 * EPS  # of the scaled residual, per unit of the numbers that enter it


class MatrixPart(NamedTuple):
    """Rows and columns of V, where its entries are in the sweep and, (i, j), in the part; their linear system."""

    rows: Index
    columns: Index
    take: Index
    i: Index
    j: Index
    system: LinearSystem


class ConstraintMatrices:
    """Those of one mechanism; `kind` of storage as `spacar.linear_systems.assemble`; `sweep`: of its elements."""

    def __init__(self, mechanism: Mechanism, kind: str | None, sweep: ElementSweep | None = None) -> None:
        self.mechanism = mechanism
        n = self.numbering = mechanism.numbering
        self.sweep = sweep or ElementSweep(mechanism)
        self.E, self.U = n.velocity_equations, n.velocity_unknowns
        self.h, self.c = n.position_equations, n.position_unknowns
        self.kind = kind
        self.scale: Array = mechanism.scale
        self.h_scale = mechanism.deformation_scale[self.h]
        self.x = mechanism.x0.copy()
        self.target = np.zeros(n.ne)  # given deformations of the last position that was looked for
        self.velocity_map_is_position_map = bool(n.holonomic)
        self._factored = self._waiting = False

    @property
    def velocity_system(self) -> LinearSystem:
        """V[E, U], factored where the position was found."""
        self.factor_waiting()
        return self.of_velocity.system

    @property
    def position_system(self) -> LinearSystem:
        """D_h by the calculable coordinates, likewise."""
        self.factor_waiting()
        return self.of_position.system

    @cached_property
    def of_velocity(self) -> MatrixPart:
        return self._part(self.E, self.U)

    @cached_property
    def of_position(self) -> MatrixPart:
        return self.of_velocity if self.velocity_map_is_position_map else self._part(self.h, self.c)

    def _part(self, rows: Index, columns: Index) -> MatrixPart:
        n, sweep = self.numbering, self.sweep
        r, c = places_in(n.ne, rows)[sweep.v_rows], places_in(n.nx, columns)[sweep.v_columns]
        take = np.flatnonzero((r >= 0) & (c >= 0))
        i, j = r[take], c[take]
        return MatrixPart(rows, columns, take, i, j, assemble(len(rows), i, j, self.kind))

    @property
    def is_factored(self) -> bool:
        """Have the linear systems factors at the configuration? Not where they are singular."""
        self.factor_waiting()
        return self._factored

    def factor_waiting(self) -> None:
        """Factor V of the sweep, if that has waited to be asked for."""
        if self._waiting:
            with suppress(SingularMatrixError):
                self.refactor()

    def refactor(self) -> None:
        """V was changed from outside: factor it. Raises SingularMatrixError."""
        self._factor_position()
        if not self.velocity_map_is_position_map:
            self._factor_velocity()
        self._factored = True

    def _factor_position(self) -> None:
        self._waiting = False
        self.of_position.system.factor(self.sweep.entries[self.of_position.take])

    def _factor_velocity(self) -> None:
        self.of_velocity.system.factor(self.sweep.entries[self.of_velocity.take])

    def rounding(self, x: Array, target: Array) -> float:
        """How well the scaled residual of the position is known at x (nx,) for these given deformations (h,)."""
        sizes = (np.abs(values).max(initial=0.0) for values in (x / self.scale, target / self.h_scale))
        return ROUNDING * float(max(1.0, *sizes))

    def norm(self, part: MatrixPart) -> float:
        """1-norm of the scaled matrix from its entries; bounded from above where two add up."""
        weight = self.mechanism.scale[part.columns][part.j] / self.mechanism.deformation_scale[part.rows][part.i]
        return float(np.bincount(part.j, np.abs(self.sweep.entries[part.take]) * weight).max(initial=0.0))

    def is_single_root(self, part: MatrixPart, rounding: float) -> bool:
        """At the configuration of the sweep; `rounding` is delta of the scaled residual."""
        s, _, _, bend = self.fold(part)
        return bool(s > len(part.rows) * EPS * self.norm(part) and s * s > 2.0 * abs(bend) * rounding)

    def fold(self, part: MatrixPart) -> tuple[float, Array, Array, float]:
        """s, u, w, c at the configuration of the sweep."""
        self.factor_waiting()
        row_scale, column_scale = 1.0 / self.mechanism.deformation_scale[part.rows], self.mechanism.scale[part.columns]
        s, u, w = smallest(part.system, row_scale, column_scale)
        v = np.zeros(self.sweep.nx)
        v[part.columns] = w * column_scale
        return s, u, w, float(u @ (self.sweep.convective(v)[part.rows] * row_scale))


ZERO = sqrt(EPS)  # singular values below this part of the largest count as zero
Entries = tuple[Index | NDArray[np.int32], Index | NDArray[np.int32], Array]


def entries_of(sweep: ElementSweep) -> Entries:
    """Rows, columns and values of V where the sweep is."""
    return sweep.v_rows, sweep.v_columns, sweep.v_entries


def scaled_difference_matrix(mechanism: Mechanism, entries: Entries, E: Index, U: Index) -> Array:
    """The rows E and columns U of V without dimension, dense; `entries` are those of the whole V, repeated ones add
    up. No array is larger than that."""
    rows, columns, values = entries
    row, column = places_in(mechanism.numbering.ne, E), places_in(mechanism.numbering.nx, U)
    part = np.flatnonzero((row[rows] >= 0) & (column[columns] >= 0))
    i, j = rows[part], columns[part]
    scaled = values[part] * mechanism.scale[j] / mechanism.deformation_scale[i]
    D = np.bincount(row[i] * len(U) + column[j], scaled, len(E) * len(U))
    return np.asarray(D.reshape(len(E), len(U)))
