"""What the engine asks of Python while it evaluates: prescribed motion that is no polynomial, user functions, and the
batches of a new element that has no functions in C yet (its NumPy family, all elements of a batch at once).

Everything else stays in C, so one such element or one user function costs its own share only. Arrays are shared: C
writes the state into them, Python the answer. An exception is kept, ends the evaluation in C and is raised after it.

C asks through one callback of ctypes (`_answer`); the user function of a single case it asks itself (`asking`).

Several cases have a function each, loaded for it as for a run of its own: functions are called once a lane, with what
they get alone. Lanes that only fill a vector up have the answer of the last case.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np

from spacar.arrays import Array
from spacar.compiled.asking import AnsweringLaw, Asking, python
from spacar.compiled.library import CForeign, CUser, address_of
from spacar.compiled.numbers import Elements
from spacar.elements.family import Configuration, Family
from spacar.mechanism.mechanism import Drive, Polynomial, UserSignal
from spacar.mechanism.placed_vectors import PlacedVector, placed

ASK = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_double)
MOTION, STRESS, STRAIN, CONVECTIVE, INERTIA, OUTPUT = range(6)  # as ASK_MOTION ... in elements.c
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


def law(
    user: UserSignal, told: tuple[PlacedVector, ...], sigma: Array, force: Array
) -> Callable[[float], dict[int, str]]:
    """What calls the user function of one case for a time and gives the sentences about stresses that cannot act.

    told           e, ed, x, xd, which C writes;  sigma, force   one lane of arrays that C has cleared, for the answer
    """
    answering = getattr(user, "answering", None)  # USERSIG: numbers, no arrays
    if answering is not None:
        written: AnsweringLaw = answering(told, sigma.data, force.data)
        return written

    def answer(t: float) -> dict[int, str]:
        given = user(t, *told)
        sigma[:], force[:] = given.sigma, given.force
        return given.lost

    return answer


class Slots:
    """The answers for one model. `motions` are the arrays (n, 3, lanes) of prescribed coordinates and deformations.

    drives, users   of every case; with fewer cases than lanes, the last one has the others too
    sizes           nx, ne, lanes
    """

    def __init__(
        self, elements: Sequence[Elements], drives: Sequence[Drive], motions: tuple[Array, Array],
        users: Sequence[UserSignal], sizes: tuple[int, int, int],
    ) -> None:  # fmt: skip
        nx, ne, lanes = sizes
        self.lanes = lanes
        self.drives = drives
        self.polynomial = all([isinstance(drive, Polynomial) for drive in drives])
        self.x_motion, self.e_motion = motions
        self.foreign = {b: ForeignBatch(e.family) for b, e in enumerate(elements) if e.family is not None}
        # whether a family here may find its elements outside the range of their theory
        self.has_limits = any(type(f.family).troubles is not Family.troubles for f in self.foreign.values())
        self.error: BaseException | None = None
        self.failed: int | None = None  # the case whose function did not answer the last question
        self.lost: list[dict[int, str]] = [{}] * max(len(users), 1)  # sentences by row of e, of every case
        self.first_lost: list[dict[int, str]] = [{} for _ in users]  # the first ones of all outputs of several cases
        self.outputs: list[dict[int, str]] = []  # those of the outputs of one call, see `spacar.compiled.passage`
        self.told: set[int] = set()  # rows of their sentences
        self.laws: tuple[Callable[[float], dict[int, str]], ...] = ()
        self.foreign_c: ctypes.Array[ctypes.c_void_p] | None = None  # addresses of the foreign batches, by batch
        if self.foreign:
            self.foreign_c = (ctypes.c_void_p * len(elements))()
            for b, batch in self.foreign.items():
                self.foreign_c[b] = ctypes.addressof(batch.c)
        self.user_c: CUser | None = None
        self.asking: Asking | None = None
        if users:
            self.user_c = c = CUser()
            (x, xd, self.force), of_x = _shared((3, nx, lanes))
            (e, ed, self.sigma), of_e = _shared((3, ne, lanes))
            (c.x, c.xd, c.force), (c.e, c.ed, c.sigma) = of_x, of_e
            guarded = (e, "e"), (ed, "ep"), (x, "x"), (xd, "xp")
            self.laws = tuple([
                law(
                    user,
                    tuple([placed(values[:, lane], name) for values, name in guarded]),
                    self.sigma[:, lane],
                    self.force[:, lane],
                )
                for lane, user in enumerate(users)
            ])  # fmt: skip
            table = python()
            if lanes == 1 and table is not None and hasattr(users[0], "answering"):
                self.asking = Asking(cast(AnsweringLaw, self.laws[0]), table, c, self.lost)

    def called(self) -> tuple[Any, ...]:
        """What C calls, for the model to keep (kept here it would be a circle of references): first the callback for
        all questions, None where C has none."""
        if self.polynomial and not (self.foreign or self.laws):
            return (None,)
        return ASK(self._answer), *(self.asking.functions() if self.asking else ())

    def _answer(self, what: int, batch: int, t: float) -> int:
        stopped = self.asking is not None and self.asking.c.stopped
        if stopped or (self.error is not None and not isinstance(self.error, Exception)):
            return NOT_ANSWERED  # Ctrl-C: nobody is asked any more
        try:
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
            elif what == STRAIN:
                self.foreign[batch].strain()
            elif what == CONVECTIVE:
                self.foreign[batch].convective()
            elif what == INERTIA:
                self.foreign[batch].inertia()
            elif what == OUTPUT and self.lanes > 1:
                for first, lost in zip(self.first_lost, self.lost, strict=True):
                    first |= lost | first
            elif what == OUTPUT:
                self.outputs.append(self.lost[0])
                if not self.told.issuperset(self.lost[0]):
                    self.told.update(self.lost[0])
                    return NOT_ANSWERED  # a sentence that is new is handed on at once
            else:
                self._move(t)
        except BaseException as error:  # nothing may pass through C
            self.error = error
            return NOT_ANSWERED
        self.failed = None
        return ANSWERED

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

    def raise_error(self) -> None:
        """Raise what happened in the last call, if anything did."""
        error, raised = self._kept()
        if raised is not None and self.asking is not None:
            error = self.asking.explained(raised)
        if error is not None:
            raise error

    def interrupted(self) -> None:
        """Raise what is no failure of the state, such as Ctrl-C. A failure is forgotten, because it will come again."""
        for error in self._kept():
            if error is not None and not isinstance(error, Exception):
                raise error

    def _kept(self) -> tuple[BaseException | None, BaseException | None]:
        """What was kept here and what by `asking`; both keep nothing then."""
        error, self.error = self.error, None
        return error, None if self.asking is None else self.asking.raised()


def _shared(shape: tuple[int, int, int]) -> tuple[Array, list[int]]:
    """Arrays (k, n, lanes) of zeros and the addresses of its k parts."""
    together = np.zeros(shape)
    first, size = address_of(together), together[0].nbytes
    return together, [first + k * size for k in range(shape[0])]
