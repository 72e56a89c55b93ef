"""Vectors that user functions index with `le` and `lnp`: the -1 of what does not exist is an error there.

NumPy would read the last entry for -1, a wrong number without a word. The check costs a comparison for every indexing
and holds for the vector itself only: results of arithmetic and slices are ordinary arrays. Slices may be negative.
"""

from typing import Any

import numpy as np

from spacar.arrays import Array

WHOLE = {int, np.int64}


class PlacedVector(np.ndarray):
    """A vector whose entries are read by places from 0 on. Raises IndexError for a negative place."""

    name = ""  # in messages; of the class, so that what is made of a vector has it for nothing

    def __getitem__(self, key: Any) -> Any:
        if type(key) in WHOLE and key >= 0:  # the usual question, without a further view of the vector
            entry = np.ndarray.__getitem__(self, key)
            return np.asarray(entry) if isinstance(entry, PlacedVector) else entry
        if _negative(key):
            raise IndexError(
                f"a place in {self.name} is negative: le and lnp hold -1 for a mode or coordinate that does not exist"
            )
        return np.asarray(self)[key]

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        plain = [np.asarray(i) if isinstance(i, PlacedVector) else i for i in inputs]
        if "out" in options:
            options["out"] = tuple(np.asarray(o) if isinstance(o, PlacedVector) else o for o in options["out"])
        return getattr(ufunc, method)(*plain, **options)

    def __repr__(self) -> str:
        return repr(np.asarray(self))  # NumPy asks a vector for its last entries when it writes it

    def __str__(self) -> str:
        return str(np.asarray(self))


class _E(PlacedVector):
    name = "e"


class _Ep(PlacedVector):
    name = "ep"


class _X(PlacedVector):
    name = "x"


class _Xp(PlacedVector):
    name = "xp"


KINDS = {kind.name: kind for kind in (_E, _Ep, _X, _Xp)}


def placed(values: Array, name: str) -> PlacedVector:
    """A guarded view of a vector; `name`: e, ep, x or xp. One that is guarded already is given back."""
    kind = KINDS[name]
    return values if type(values) is kind else values.view(kind)


def _negative(key: Any) -> bool:
    if isinstance(key, (int, np.integer)):
        return bool(key < 0)
    if isinstance(key, tuple):
        return any(_negative(k) for k in key)
    if isinstance(key, (list, np.ndarray)):
        index = np.asarray(key)
        return index.dtype.kind == "i" and bool((index < 0).any())
    return False
