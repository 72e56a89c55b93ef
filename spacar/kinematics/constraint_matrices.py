"""The matrices of position and velocity of a mechanism as linear systems, made and factored when they are asked for.

Position level: D_h by the calculable coordinates c. Velocity level: V[E, U] (theory-system.md section 1.1). Both take
their entries from the sweep of the elements; without slips they are the same.
"""

from __future__ import annotations

from contextlib import suppress
from functools import cached_property

import numpy as np

from spacar.arrays import Index
from spacar.kinematics.element_sweep import ElementSweep
from spacar.linear_systems import LinearSystem, SingularMatrixError, assemble
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
