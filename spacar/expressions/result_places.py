"""Where a coordinate or a deformation stands, and a message that lists what there is when it does not exist."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from spacar.deck.findings import runs
from spacar.errors import UsageError

MOST = 6  # ranges that a message lists
NODE, ELEMENT = ("node", "coordinate"), ("element", "deformation mode")


def listed(numbers: Iterable[int]) -> str:
    """`1 to 6, 8, 10 to 12`; at most six ranges, then the last number."""
    known = [*map(int, numbers)]
    texts = runs(known, " to ")
    return ", ".join(texts if len(texts) <= MOST else [*texts[: MOST - 1], "...", str(max(known))])


def place(table: NDArray[np.int64], number: int, k: int, words: tuple[str, str]) -> int:
    """0-based column of the k-th entry of a node (table lnp) or an element (le). Raises UsageError.

    table  (numbers, most entries), 1-based columns, 0 where there is none;  words  NODE or ELEMENT
    """
    rows = np.asarray(table)
    numbers, entries = rows.shape
    if number in range(1, numbers + 1) and k in range(1, entries + 1):
        found: int = rows.item(int(number) - 1, int(k) - 1)
        if found:
            return found - 1
    what, entry = words
    own = places(rows, number, words)
    has = listed(np.flatnonzero(rows[number - 1]) + 1)
    raise UsageError(f"{what} {number} has the {entry}{'s' * (len(own) > 1)} {has}, not {k}", "expression.number")


def places(table: NDArray[np.int64], number: int, words: tuple[str, str]) -> NDArray[np.int64]:
    """0-based columns of all entries of a node or an element, as `place`. Raises UsageError."""
    rows = np.asarray(table)
    if number in range(1, len(rows) + 1):
        row = rows[int(number) - 1]
        found: NDArray[np.int64] = row[row > 0] - 1
        if len(found):
            return found
    there, what = np.flatnonzero(np.any(rows != 0, axis=1)) + 1, words[0]
    known = f"{what}s are {listed(there)}" if len(there) else f"there are no {what}s"
    raise UsageError(f"{what} {number} does not exist; {known}", "expression.number")
