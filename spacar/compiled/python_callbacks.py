"""How C calls Python while it evaluates (`python_callbacks.c`): through the stable C interface of Python, whose
functions ctypes finds. A callback of ctypes loses the Ctrl-C that is noticed where it begins, and costs more than many
a function; it is taken only in a Python that does not have these functions.

The user function of a single case is called by C itself, which takes answers that have the form of an earlier one;
`PythonCallbacks.read` reads the others. An exception is kept (`raised`) and ends the evaluation. Behind one that is no
Exception, such as Ctrl-C, nobody is asked until it was raised.
"""

from __future__ import annotations

import ctypes
import sys
from array import array
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.compiled.interface import POINTER, functions, structure
from spacar.errors import BY_USERS

if TYPE_CHECKING:
    from spacar.mechanism.user_functions import Answering

FUNCTIONS = tuple(functions("PYTHON_FUNCTIONS"))
TYPES = float, np.float64, int, list, tuple, Exception
BACK = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_double)


@lru_cache
def python() -> ctypes.Array[ctypes.c_void_p] | None:
    """The table of python_callbacks.c, or None in a Python that does not have all of it: then ctypes calls back."""
    if sys.implementation.name != "cpython":
        return None
    try:
        found = [ctypes.cast(getattr(ctypes.pythonapi, name), POINTER).value for name in FUNCTIONS]
    except AttributeError:
        return None
    return (POINTER * (len(FUNCTIONS) + len(TYPES)))(*found, *map(id, TYPES))


class PythonCallbacks:
    """What C asks of one model.

    law    of the user function of a single case, of which C takes usual answers itself; into what `user` shares
    lost   list whose only entry is given the sentences about stresses that cannot act
    """

    def __init__(self, law: Any, user: Any | None, lost: list[dict[int, str]]) -> None:
        self.law: Answering | None = None
        self.user, self.lost = user, lost
        self.caught: list[BaseException] = []
        self.known: tuple[list[Any], list[Any]] | None = None  # the forms that C knows
        table = python()
        if table is None:
            self.c = structure("PythonCallbacks")()
        elif law is None or user is None:
            self.c = structure("PythonCallbacks")(ctypes.addressof(table))
        else:
            self.law = law
            known = user.sigma, user.force, -1, id(law.function), tuple(map(id, law.arguments))
            self.c = structure("PythonCallbacks")(ctypes.addressof(table), *known)

    def calls(self, answer: Callable[[int, int, float], bool]) -> tuple[Any, ...]:
        """What C calls, for the model to keep. `answer` is given what is asked, a batch and the time, and says whether
        C has to stop there all the same."""
        c, called = self.c, (answer, self.caught.append, self.read)
        c.answer, c.keep, c.read = map(id, called)
        if c.python:
            return called
        back = BACK(_guarded(answer, self.caught.append, c))
        c.back = ctypes.cast(back, POINTER).value
        return (back,)

    def read(self, t: float, given: Any) -> None:
        """Write an answer that C does not know the form of, and let C take the next ones that are like it."""
        assert self.law is not None
        assert self.user is not None
        c = self.c
        self.lost[0] = lost = self.law.read(t, given)
        forms = self.law.forms
        if lost:
            self.user.lost = 1  # and no forms: rows of which nothing is lost would not take the sentences away
        if forms is not None and any(len({*form[2::3]}) < len(form) // 3 for form in forms):
            forms = None  # C writes one row to a place
        if self.known is not forms:
            self.known = forms
            if forms is None:
                c.n_sigma = -1
                return
            of_sig, of_f = forms
            self.rows = array("d", of_sig + of_f)
            c.rows, c.n_sigma, c.n_force = self.rows.buffer_info()[0], len(of_sig) // 3, len(of_f) // 3

    def raised(self) -> BaseException | None:
        """What was raised in the last call, if anything was, and told with the time if it comes from the user function;
        from then on C asks again."""
        if not self.caught:
            return None
        error = self.caught[-1]
        self.caught.clear()
        self.c.stopped = 0
        if self.law is None or not self.c.within or not isinstance(error, BY_USERS):
            return error
        failed = self.law.failed(self.c.t, error)
        failed.__cause__ = error
        return failed


def _guarded(
    answer: Callable[[int, int, float], bool], keep: Callable[[BaseException], None], c: Any
) -> Callable[[int, int, float], int]:
    """For a callback of ctypes, through which no exception may pass."""

    def guarded(what: int, batch: int, t: float) -> int:
        try:
            return int(answer(what, batch, t))
        except BaseException as error:
            c.stopped = not isinstance(error, Exception)
            keep(error)
            return 1

    return guarded
