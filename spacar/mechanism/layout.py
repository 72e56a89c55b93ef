"""Where the contributions of the batches are in the flat arrays of an evaluation: made once per mechanism.

The entries of V (ne x nx) come first, batch by batch, (n_deformations, n_coordinates, n) each, then those of M
(nx x nx), (n_coordinates, n_coordinates, n). A place is the part of a flat array that belongs to a batch, and its
shape.
"""

from collections.abc import Callable
from functools import cached_property
from math import prod
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array, Index
from spacar.elements.family import Family

Place = tuple[int, slice, tuple[int, ...]]  # index of the batch, part of the flat array, shape


class Batch(NamedTuple):
    """A family with its place in the global vectors, and its place among the batches of its mechanism."""

    family: Family
    x: Index  # (n_coordinates, n) indices into x
    e: Index  # (n_deformations, n) indices into e
    index: int = 0  # type: ignore[assignment]  # set by the Mechanism; arrays of an evaluation are kept under it


def _indices(of: str, index: Callable[[Batch], Index]) -> cached_property[Index]:
    """The indices of the batches `of` a layout, one after the other."""

    def joined(layout: "Layout") -> Index:
        parts = [index(b).ravel() for b in getattr(layout, of)]
        return np.concatenate(parts) if parts else np.zeros(0, np.int64)

    return cached_property(joined)


def _places(of: str, shape: Callable[[Batch], tuple[int, ...]]) -> cached_property[tuple[Place, ...]]:
    """Consecutive parts (*shape, n) for the batches `of` a layout."""

    def places(layout: "Layout") -> tuple[Place, ...]:
        found, first = [], 0
        for b in getattr(layout, of):
            whole = (*shape(b), b.family.n)
            size = prod(whole)
            found.append((b.index, slice(first, first + size), whole))
            first += size
        return tuple(found)

    return cached_property(places)


class Layout:
    """Batches by what they have. The index arrays of all of them together are made when an evaluation asks for them."""

    # entries of V and M
    v_rows = _indices("strained", lambda b: b.e.repeat(len(b.x), 0))
    v_columns = _indices("strained", lambda b: b.x[None].repeat(len(b.e), 0))
    m_rows = _indices("massive", lambda b: b.x.repeat(len(b.x), 0))
    m_columns = _indices("massive", lambda b: b.x[None].repeat(len(b.x), 0))
    V = _places("strained", lambda b: (len(b.e), len(b.x)))
    M = _places("massive", lambda b: (len(b.x), len(b.x)))
    # coordinates of all batches, deformations of the strained ones, coordinates of the moving ones
    x_index = _indices("batches", lambda b: b.x)
    e_index = _indices("strained", lambda b: b.e)
    f_index = _indices("moving", lambda b: b.x)
    x = _places("batches", lambda b: (len(b.x),))
    e = _places("strained", lambda b: (len(b.e),))
    f = _places("moving", lambda b: (len(b.x),))

    def __init__(self, batches: tuple[Batch, ...]) -> None:
        self.batches = batches
        self.strained = tuple(b for b in batches if b.family.n_deformations)
        self.massive = tuple(b for b in batches if b.family.has_mass)
        self.moving = tuple(b for b in self.massive if not b.family.constant_mass)  # it depends on the configuration
        self.curved = tuple(b for b in self.strained if not b.family.constant_gradient)  # V depends on it
        self.turning = tuple(b for b in self.strained if b.family.has_own_branch)

    def branch(self, x: Array, e: Array) -> Array:
        """What the branch of states after x (nx,), e (ne,) is chosen by, (ne,): deformations, or what families say."""
        found = e.copy()
        for b in self.turning:
            found[b.e] = b.family.branch(x[b.x], e[b.e])
        return found

    @cached_property
    def sizes(self) -> tuple[int, int]:
        """How many entries V and M have."""
        return sum(len(b.e) * b.x.size for b in self.strained), sum(len(b.x) * b.x.size for b in self.massive)
