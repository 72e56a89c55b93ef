"""The user function of a single case, asked by C without a callback of ctypes (`asking.c`): that costs more than many a
function.

C calls the function itself, through the stable C interface of Python, whose functions ctypes finds. It takes answers
that have the form of an earlier one; `Asking.read` reads the others. An exception is kept (`raised`) and ends the
evaluation.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from spacar.compiled.library import POINTER, CAsking, CUser

# in the order of `Python` in asking.c
FUNCTIONS = (
    "PyGILState_Ensure", "PyGILState_Release", "PyFloat_FromDouble", "PyFloat_AsDouble",
    "PyObject_CallFunctionObjArgs", "PyObject_Type", "PyList_Size", "PyTuple_Size", "PyList_GetItem", "PyTuple_GetItem",
    "Py_DecRef", "PyErr_Occurred", "PyErr_ExceptionMatches", "PyErr_Clear", "PyErr_Fetch", "PyErr_NormalizeException",
    "PyException_SetTraceback",
)  # fmt: skip
TYPES = float, np.float64, int, list, tuple, Exception
Form = list[Any]  # of rows: two numbers and a place each


@lru_cache
def python() -> ctypes.Array[ctypes.c_void_p] | None:
    """The table of asking.c, or None in a Python that does not have all of it: then ctypes calls back."""
    if sys.implementation.name != "cpython":
        return None
    try:
        found = [ctypes.cast(getattr(ctypes.pythonapi, name), POINTER).value for name in FUNCTIONS]
    except AttributeError:
        return None
    return (POINTER * (len(FUNCTIONS) + len(TYPES)))(*found, *map(id, TYPES))


class AnsweringLaw(Protocol):
    """`spacar.mechanism.user_functions.Answering`."""

    function: Callable[..., Any]
    told: tuple[Any, ...]
    forms: tuple[Form, Form] | None

    def __call__(self, t: float) -> dict[int, str]: ...

    def read(self, t: float, given: Any) -> dict[int, str]: ...

    def failed(self, t: float, error: Exception) -> Exception: ...


class Asking:
    """What C asks the law of `user`, and which of its answers it takes itself.

    lost   list whose only entry is given the sentences about stresses that cannot act
    """

    def __init__(
        self, answering: AnsweringLaw, table: ctypes.Array[ctypes.c_void_p], user: CUser, lost: list[dict[int, str]]
    ) -> None:
        self.answering, self.user, self.lost = answering, user, lost
        self.caught: list[BaseException] = []
        self.known: Sequence[Form] | None = None  # the forms that C knows, with the objects that it looks for
        self.rows: list[Any] = []
        self.c = c = CAsking(ctypes.addressof(table), id(answering.function), tuple(map(id, answering.told)))
        c.values[:], c.n[:] = (user.sigma, user.force), (-1, -1)
        user.asking = ctypes.addressof(c)

    def functions(self) -> tuple[Callable[..., Any], ...]:
        """What C calls, for the model to keep (kept here it would be a circle of references)."""
        called = self.read, self.caught.append
        self.c.read, self.c.keep = map(id, called)
        return called

    def read(self, t: float, given: Any) -> None:
        """Write an answer that C does not know the form of, and let C take the next ones that are like it."""
        c = self.c
        self.lost[0] = lost = self.answering.read(t, given)
        if lost:
            self.user.lost = 1
            self.known = None
            c.n[:] = -1, -1  # rows of which nothing is lost would not take the sentences away
        elif self.known is not self.answering.forms:
            self.known = forms = self.answering.forms or ([], [])
            self.rows = [_rows(form) for form in forms]
            c.rows[:] = [ctypes.addressof(rows) for rows in self.rows]
            c.n[:] = [len(form) // 3 for form in forms]

    def raised(self) -> BaseException | None:
        """What was raised in the last call, if anything was; from then on C asks again."""
        if not self.caught:
            return None
        error = self.caught[-1]
        self.caught.clear()
        self.c.stopped = 0
        return error

    def explained(self, error: BaseException) -> BaseException:
        """What a run says of it: an exception of the function itself is told with the time."""
        if self.c.reading or not isinstance(error, Exception):
            return error
        failed = self.answering.failed(self.c.t, error)
        failed.__cause__ = error
        return failed


def _rows(form: Form) -> ctypes.Array[ctypes.c_ssize_t]:
    """`Row` of asking.c for every row."""
    numbers = [id(number) for number in form]
    numbers[2::3] = form[2::3]
    return (ctypes.c_ssize_t * len(form))(*numbers)
