"""Types of arrays in annotations, the rounding of their numbers, places in them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]  # of float64; NumPy annotates some float results too widely
Index = NDArray[np.int64]
Complex = NDArray[np.complex128]
EPS = float(np.finfo(float).eps)


def places_in(n: int, of: Index, to: Index | int | None = None) -> Index:
    """(n,) places by number: those of the numbers `of` in this list, or in `to`; -1 of all others."""
    found = np.full(n, -1)
    found[of] = np.arange(len(of)) if to is None else to
    return found
