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

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.kinematics.element_sweep import ElementSweep
from spacar.linear_systems import LinearSystem, SingularMatrixError, assemble
from spacar.linear_systems.reciprocal_condition import smallest
from spacar.mechanism.mechanism import Mechanism


class ConstraintMatrices:
    """Those of one mechanism; `kind` of storage as `spacar.linear_systems.assemble`; `sweep`: of its elements."""

    def __init__(self, mechanism: Mechanism, kind: str | None, sweep: ElementSweep | None = None) -> None:
        self.mechanism = mechanism
        n = self.numbering = mechanism.numbering
        self.sweep = sweep or ElementSweep(mechanism)
        self.E, self.U = n.velocity_equations, n.velocity_unknowns
        self.h, self.c = n.position_equations, n.position_unknowns
        self.kind = kind
        self.velocity_map_is_position_map = bool(n.holonomic)
        self._factored = self._waiting = False

    @property
    def velocity_system(self) -> LinearSystem:
        """V[E, U], factored where the position was found."""
        self.factor_waiting()
        return self._velocity[0]

    @property
    def position_system(self) -> LinearSystem:
        """D_h by the calculable coordinates, likewise."""
        self.factor_waiting()
        return self._position[0]

    @property
    def velocity_take(self) -> Index:
        """Where the entries of V[E, U] are in the sweep."""
        return self._velocity[1]

    @property
    def position_take(self) -> Index:
        """Where those of the position are."""
        return self._position[1]

    @cached_property
    def _velocity(self) -> tuple[LinearSystem, Index]:
        return self._system(self.E, self.U)

    @cached_property
    def _position(self) -> tuple[LinearSystem, Index]:
        return self._velocity if self.velocity_map_is_position_map else self._system(self.h, self.c)

    def _system(self, rows: Index, columns: Index) -> tuple[LinearSystem, Index]:
        """The part of V with these rows and columns as a linear system, and where its entries are in the sweep."""
        row_of = np.full(self.numbering.ne, -1)
        row_of[rows] = np.arange(len(rows))
        column_of = np.full(self.numbering.nx, -1)
        column_of[columns] = np.arange(len(columns))
        r, c = row_of[self.sweep.v_rows], column_of[self.sweep.v_columns]
        take = np.flatnonzero((r >= 0) & (c >= 0))
        return assemble(len(rows), r[take], c[take], self.kind), take

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
        system, take = self._position
        system.factor(self.sweep.entries[take])

    def _factor_velocity(self) -> None:
        system, take = self._velocity
        system.factor(self.sweep.entries[take])


ZERO = float(np.sqrt(np.finfo(float).eps))  # singular values below this part of the largest count as zero
Entries = tuple[Index | NDArray[np.int32], Index | NDArray[np.int32], Array]
EPS = float(np.finfo(float).eps)


def entries_of(sweep: ElementSweep) -> Entries:
    """Rows, columns and values of V where the sweep is."""
    return sweep.v_rows, sweep.v_columns, sweep.v_entries


def scaled_difference_matrix(mechanism: Mechanism, entries: Entries, E: Index, U: Index) -> Array:
    """The rows E and columns U of V without dimension, dense; `entries` are those of the whole V, repeated ones add
    up. No array is larger than that."""
    rows, columns, values = entries
    row, column = np.full(mechanism.numbering.ne, -1), np.full(mechanism.numbering.nx, -1)
    row[E], column[U] = np.arange(len(E)), np.arange(len(U))
    part = np.flatnonzero((row[rows] >= 0) & (column[columns] >= 0))
    i, j = rows[part], columns[part]
    scaled = values[part] * mechanism.scale[j] / mechanism.deformation_scale[i]
    D = np.bincount(row[i] * len(U) + column[j], scaled, len(E) * len(U))
    return np.asarray(D.reshape(len(E), len(U)))


def is_single_root(
    sweep: ElementSweep, system: LinearSystem, rows: Index, columns: Index, row_scale: Array, column_scale: Array,
    norm: float, rounding: float,
) -> bool:  # fmt: skip
    """At the configuration of the sweep. `system` is D' with these rows of e and columns of x, factored; `norm` the
    size of its scaled matrix, `rounding` delta of the scaled residual.
    """
    s, _, _, bend = fold(sweep, system, rows, columns, row_scale, column_scale)
    return bool(s > len(rows) * EPS * norm and s * s > 2.0 * abs(bend) * rounding)


def fold(
    sweep: ElementSweep, system: LinearSystem, rows: Index, columns: Index, row_scale: Array, column_scale: Array
) -> tuple[float, Array, Array, float]:
    """s, u, w, c at the configuration of the sweep."""
    s, u, w = smallest(system, row_scale, column_scale)
    v = np.zeros(sweep.nx)
    v[columns] = w * column_scale
    return s, u, w, float(u @ (sweep.convective(v)[rows] * row_scale))
