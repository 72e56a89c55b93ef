"""Numbers of many cases as combinations of those of a few."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from spacar.arrays import Array
from spacar.compiled.numbers import Entries, Numbers

ENTRIES = "mass", "stiffness", "damping", "moments", "coupling"
NONE = np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 1))
ROUNDING = 64.0 * np.finfo(float).eps  # of the largest number of an array: constants of elements are some dozen sums


def combined(corners: Sequence[Numbers], weights: Array) -> Numbers | None:
    """The first corner and, in case k, `weights[i - 1, k]` times the difference to every other corner i: numbers that
    do not differ stay what they are. None where the corners have other entries.
    """
    return _each(corners, lambda arrays: affine(arrays, weights))


def same(a: Numbers, b: Numbers) -> bool:
    """Whether the numbers of one case are those of another one to rounding; zeros need not be entries."""

    def close(arrays: Sequence[Array]) -> Array | None:
        one, other = arrays
        return one if np.abs(one - other).max(initial=0.0) <= ROUNDING * np.abs(one).max(initial=0.0) else None

    kinds = [[(e.kind, e.moving) for e in of.elements] for of in (a, b)]
    if kinds[0] != kinds[1] or not all(_same_entries(getattr(a, name), getattr(b, name)) for name in ENTRIES):
        return False
    nothing = {name: NONE for name in ENTRIES}
    return _each((a._replace(**nothing), b._replace(**nothing)), close) is not None  # type: ignore[arg-type]


def _same_entries(a: Entries, b: Entries) -> bool:
    size = max(int(of[1].max(initial=0)) for of in (a, b)) + 1
    keys = np.unique(np.concatenate([of[0] * size + of[1] for of in (a, b)]))
    one, other = np.zeros((2, len(keys)))
    for values, of in ((one, a), (other, b)):
        np.add.at(values, np.searchsorted(keys, of[0] * size + of[1]), of[2][:, 0])
    return bool(np.abs(one - other).max(initial=0.0) <= ROUNDING * np.abs(one).max(initial=0.0))


def affine(arrays: Sequence[Array], weights: Array) -> Array:
    """The same of one array, (..., 1) of each corner; (..., cases)."""
    first, *others = arrays
    total = np.repeat(first, weights.shape[1], axis=-1)
    for other, weight in zip(others, weights, strict=True):
        total += (other - first) * weight
    return total


def _each(corners: Sequence[Numbers], merged: Callable[[Sequence[Array]], Array | None]) -> Numbers | None:
    """The first corner, every array replaced by what `merged` makes of those of all; None where it makes nothing."""
    first = corners[0]
    lost = False

    def array(name: str, of: Sequence[object] = corners) -> Array:
        return kept([getattr(corner, name) for corner in of])

    def kept(arrays: Sequence[Array]) -> Array:
        nonlocal lost
        found = merged(arrays) if len({a.shape for a in arrays}) == 1 else None
        lost = lost or found is None
        return arrays[0] if found is None else found

    def entries(name: str) -> Entries:
        nonlocal lost
        lists: list[Entries] = [getattr(corner, name) for corner in corners]
        rows, columns, _ = lists[0]
        lost = lost or not all(np.array_equal(o[0], rows) and np.array_equal(o[1], columns) for o in lists)
        return rows, columns, kept([values for _, _, values in lists])

    elements = tuple(
        batch._replace(parameters=array("parameters", [corner.elements[k] for corner in corners]))
        for k, batch in enumerate(first.elements)
    )
    found = Numbers(
        elements,
        entries("mass"), entries("stiffness"), entries("damping"), entries("moments"), entries("coupling"),
        array("force"), array("field"), array("x0"), array("preload"), array("x_motion"), array("e_motion"),
    )  # fmt: skip
    return None if lost else found
