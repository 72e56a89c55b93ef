"""What the engine asks of Python while it evaluates: prescribed motion that is no polynomial, user functions, and the
batches of a new element that has no functions in C yet (its NumPy family, all elements of a batch at once).

Everything else stays in C, so one such element or one user function costs its own share only. Arrays are shared: C
writes the state into them, Python the answer. An exception is kept, ends the evaluation in C and is raised after it.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.compiled.library import CForeign, CUser
from spacar.compiled.numbers import Elements
from spacar.elements.family import Configuration, Family
from spacar.mechanism.mechanism import Drive, Polynomial, UserSignal
from spacar.mechanism.placed_vectors import placed

ASK = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_double)
MOTION, STRESS, STRAIN, CONVECTIVE, INERTIA = range(5)  # as ASK_MOTION ... in elements.c
ANSWERED, NOT_ANSWERED = 0, 1


class ForeignBatch:
    """One batch that is evaluated here; arrays (..., n) as the family has them."""

    def __init__(self, family: Family) -> None:
        nx, ne, n = family.n_coordinates, family.n_deformations, family.n
        self.family = family
        self.x, self.v, self.h = np.zeros((3, nx, n))
        self.near, self.e, self.H = np.zeros((3, ne, n))
        self.V, self.M = np.zeros((ne, nx, n)), np.zeros((nx, nx, n))
        arrays = self.x, self.v, self.near, self.e, self.V, self.H, self.M, self.h
        self.c = CForeign(*(a.ctypes.data for a in arrays))
        self.configuration: Configuration = None

    def strain(self) -> None:
        self.configuration = self.family.strain(self.x, self.near, self.e, self.V)

    def convective(self) -> None:
        self.H[:] = 0.0
        if not self.family.constant_gradient:
            self.family.convective_strain(self.configuration, self.v, self.H)

    def inertia(self) -> None:
        if not self.family.n_deformations:
            self.strain()
        self.family.mass(self.configuration, self.M)
        self.h[:] = self.family.inertia_force(self.configuration, self.v, None)


class Slots:
    """The answers for one model. `motions` are the arrays (n, 3, 1) of prescribed coordinates and deformations."""

    def __init__(
        self, elements: Sequence[Elements], drive: Drive, motions: tuple[Array, Array], user: UserSignal | None,
        sizes: tuple[int, int],
    ) -> None:  # fmt: skip
        nx, ne = sizes
        self.drive, self.user = drive, user
        self.user_rows: Callable[..., Any] | None = getattr(user, "rows", None)  # USERSIG: numbers, no arrays
        self.x_motion, self.e_motion = motions
        self.foreign = {b: ForeignBatch(e.family) for b, e in enumerate(elements) if e.family is not None}
        # whether a family here may find its elements outside the range of their theory
        self.has_limits = any(type(f.family).troubles is not Family.troubles for f in self.foreign.values())
        self.error: BaseException | None = None
        self.lost: dict[int, str] = {}  # sentences about stresses that cannot act, by row of e
        self.user_c: CUser | None = None
        if user is not None:
            self.x, self.xd, self.force = np.zeros((3, nx))
            self.e, self.ed, self.sigma = np.zeros((3, ne))
            arrays = self.x, self.xd, self.e, self.ed, self.force, self.sigma
            guarded = zip((self.e, self.ed, self.x, self.xd), ("e", "ep", "x", "xp"), strict=True)
            self.told = tuple(placed(values, name) for values, name in guarded)  # as user functions get them
            self.user_c = CUser(*(a.ctypes.data for a in arrays))
        needed = bool(self.foreign) or user is not None or not isinstance(drive, Polynomial)
        self.ask = ASK(self._answer) if needed else None

    def _answer(self, what: int, batch: int, t: float) -> int:
        try:
            if what == STRAIN:
                self.foreign[batch].strain()
            elif what == CONVECTIVE:
                self.foreign[batch].convective()
            elif what == INERTIA:
                self.foreign[batch].inertia()
            elif what == MOTION:
                self._move(t)
            else:
                self._stress(t)
        except BaseException as error:  # nothing may pass through C
            self.error = error
            return NOT_ANSWERED
        return ANSWERED

    def _move(self, t: float) -> None:
        at = self.drive.at(t)
        self.x_motion[:, :, 0] = np.column_stack((at.x, at.xd, at.xdd))
        self.e_motion[:, :, 0] = np.column_stack((at.e, at.ed, at.edd))

    def _stress(self, t: float) -> None:
        assert self.user is not None
        if self.user_rows is None:
            given = self.user(t, *self.told)
            self.force[:], self.sigma[:], self.lost = given.force, given.sigma, given.lost
            return
        stresses, forces, self.lost = self.user_rows(t, *self.told)
        for values, rows in ((self.sigma, stresses), (self.force, forces)):
            values.fill(0.0)
            for i, row in rows:
                values[i] += row[2]

    def raise_error(self) -> None:
        """Raise what happened in the last call, if anything did."""
        error, self.error = self.error, None
        if error is not None:
            raise error

    def interrupted(self) -> None:
        """Raise what is no failure of the state, such as Ctrl-C. A failure is forgotten, because it will come again."""
        error, self.error = self.error, None
        if error is not None and not isinstance(error, Exception):
            raise error
