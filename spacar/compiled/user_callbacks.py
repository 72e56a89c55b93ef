"""What the engine asks of Python while it evaluates: prescribed motion that is no polynomial, user functions, and the
batches of a new element that has no functions in C yet (its NumPy family, all elements of a batch at once).

Everything else stays in C, so one such element or one user function costs its own share only. Arrays are shared: C
writes the state into them, Python the answer. An exception is kept, ends the evaluation in C and is raised after it:
`python_callbacks`, where C takes the usual answers of the user function of a single case itself.

Several cases have a function each, loaded for it as for a run of its own: functions are called once a lane, with what
they get alone. Lanes that only fill a vector up have the answer of the last case.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.compiled.interface import constants, structure
from spacar.compiled.library import WIDTH, address_of
from spacar.compiled.numbers import Elements
from spacar.compiled.python_callbacks import PythonCallbacks
from spacar.elements.family import Configuration, Family
from spacar.mechanism.mechanism import Drive, Polynomial
from spacar.mechanism.placed_vectors import placed

MOTION, STRESS, STRAIN, CONVECTIVE, INERTIA, OUTPUT = constants(
    "ASK_MOTION", "ASK_STRESS", "ASK_STRAIN", "ASK_CONVECTIVE", "ASK_INERTIA", "ASK_OUTPUT"
)


class ForeignBatch:
    """One batch that is evaluated here; arrays (..., n) as the family has them."""

    def __init__(self, family: Family) -> None:
        nx, ne, n = family.n_coordinates, family.n_deformations, family.n
        self.family = family
        self.x, self.v, self.h = np.zeros((3, nx, n))
        self.branch, self.e, self.H = np.zeros((3, ne, n))
        self.V, self.M = np.zeros((ne, nx, n)), np.zeros((nx, nx, n))
        arrays = self.x, self.v, self.branch, self.e, self.V, self.H, self.M, self.h
        self.c = structure("Foreign")(*(a.ctypes.data for a in arrays))
        self.configuration: Configuration = None

    def strain(self) -> None:
        self.configuration = self.family.strain(self.x, self.branch, self.e, self.V)

    def convective(self) -> None:
        self.H[:] = 0.0
        if not self.family.constant_gradient:
            self.family.convective_strain(self.configuration, self.v, self.H)

    def inertia(self) -> None:
        if not self.family.n_deformations:
            self.strain()
        self.family.mass(self.configuration, self.M)
        self.h[:] = self.family.inertia_force(self.configuration, self.v, None)


OF_BATCHES = {STRAIN: ForeignBatch.strain, CONVECTIVE: ForeignBatch.convective, INERTIA: ForeignBatch.inertia}


class UserCallbacks:
    """The answers for one model. `motions` are the arrays (n, 3, lanes) of prescribed coordinates and deformations.

    drives, users   (`UserLaw`) of every case; with fewer cases than lanes, the last one has the others too
    sizes           nx, ne, lanes
    """

    def __init__(
        self, elements: Sequence[Elements], drives: Sequence[Drive], motions: tuple[Array, Array],
        users: Sequence[Any], sizes: tuple[int, int, int],
    ) -> None:  # fmt: skip
        nx, ne, lanes = sizes
        self.lanes = lanes
        self.drives = drives
        self.polynomial = all([isinstance(drive, Polynomial) for drive in drives])
        self.x_motion, self.e_motion = motions
        self.foreign = {b: ForeignBatch(e.family) for b, e in enumerate(elements) if e.family is not None}
        # whether a family here may find its elements outside the range of their theory
        self.has_limits = any(type(f.family).troubles is not Family.troubles for f in self.foreign.values())
        self.failed: int | None = None  # the case whose function did not answer the last question
        self.lost: list[dict[int, str]] = [{}] * max(len(users), 1)  # sentences by row of e, of every case
        self.first_lost: list[dict[int, str]] = [{} for _ in users]  # the first ones of all outputs of several cases
        self.outputs: list[dict[int, str]] = []  # those of the outputs of one call, see `spacar.compiled.output_block`
        self.reported: set[int] = set()  # rows of their sentences
        self.laws: tuple[Callable[[float], dict[int, str]], ...] = ()
        self.foreign_c: ctypes.Array[ctypes.c_void_p] | None = None  # addresses of the foreign batches, by batch
        if self.foreign:
            self.foreign_c = (ctypes.c_void_p * len(elements))()
            for b, batch in self.foreign.items():
                self.foreign_c[b] = ctypes.addressof(batch.c)
        self.user_c: Any | None = None
        if users:
            parts = list(accumulate((nx, nx, nx, ne, ne, ne), initial=0))  # x, xd, force; e, ed, sigma
            shared = np.zeros((parts[-1], lanes))
            first, row = address_of(shared), WIDTH * lanes
            self.user_c = structure("User")(*[first + row * begin for begin in parts[:-1]])
            x, xd, self.force, e, ed, self.sigma = [shared[i:k] for i, k in pairwise(parts)]
            guarded = (e, "e"), (ed, "ep"), (x, "x"), (xd, "xp")
            arguments = [[placed(of[:, lane], name) for of, name in guarded] for lane in range(len(users))]
            self.laws = tuple([
                user.answering(tuple(arguments[lane]), self.sigma[:, lane], self.force[:, lane])
                for lane, user in enumerate(users)
            ])  # fmt: skip
        self.asking: PythonCallbacks | None = None
        if users or self.foreign or not self.polynomial:
            alone = self.laws[0] if lanes == 1 and users else None
            self.asking = PythonCallbacks(alone, self.user_c, self.lost)

    def answer(self, what: int, batch: int, t: float) -> bool:
        """Answer C; whether it has to stop there all the same."""
        if what == STRESS:
            if self.lanes == 1:
                self.lost[0] = self.laws[0](t)
            else:
                for lane, answer in enumerate(self.laws):
                    self.failed = lane
                    self.lost[lane] = answer(t)
                if len(self.laws) < self.lanes:
                    self._fill(len(self.laws), self.sigma, self.force)
            if self.user_c is not None and any(self.lost):
                self.user_c.lost = 1
        elif what in OF_BATCHES:
            OF_BATCHES[what](self.foreign[batch])
        elif what == OUTPUT and self.lanes > 1:
            for first, lost in zip(self.first_lost, self.lost, strict=True):
                first |= lost | first
        elif what == OUTPUT:
            self.outputs.append(self.lost[0])
            if not self.reported.issuperset(self.lost[0]):
                self.reported.update(self.lost[0])
                return True  # a sentence that is new is handed on at once
        else:
            self._move(t)
        self.failed = None
        return False

    def _move(self, t: float) -> None:
        for lane, drive in enumerate(self.drives):
            self.failed = lane
            at = drive.at(t)
            self.x_motion[:, :, lane] = np.column_stack((at.x, at.xd, at.xdd))
            self.e_motion[:, :, lane] = np.column_stack((at.e, at.ed, at.edd))
        if len(self.drives) < self.lanes:
            self._fill(len(self.drives), self.x_motion, self.e_motion)

    @staticmethod
    def _fill(cases: int, *arrays: Array) -> None:
        """Lanes without a case have the answer of the last one."""
        for array in arrays:
            array[..., cases:] = array[..., cases - 1 : cases]

    def raise_error(self, failures: bool = True) -> None:
        """Raise what happened in the last call, if anything did; without `failures` only what is none of the state."""
        error = None if self.asking is None else self.asking.raised()
        if error is not None and (failures or not isinstance(error, Exception)):
            raise error

    def interrupted(self) -> None:
        """Raise what is no failure of the state, such as Ctrl-C. A failure is forgotten, because it will come again."""
        self.raise_error(failures=False)
