"""Where the contributions of the batches are in the flat arrays of an evaluation: made once per mechanism.

The entries of V (ne x nx) come first, batch by batch, (n_deformations, n_coordinates, n) each, then those of M
(nx x nx), (n_coordinates, n_coordinates, n). A place is the part of a flat array that belongs to a batch, and its
shape.
"""

from collections.abc import Sequence
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


class Layout:
    """Batches by what they have. The index arrays of all of them together are made when an evaluation asks for them."""

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

    # -- entries of V and M ---------------------------------------------------------------------------------------
    @cached_property
    def v_rows(self) -> Index:
        return _join([b.e.repeat(len(b.x), 0) for b in self.strained])

    @cached_property
    def v_columns(self) -> Index:
        return _join([b.x[None].repeat(len(b.e), 0) for b in self.strained])

    @cached_property
    def m_rows(self) -> Index:
        return _join([b.x.repeat(len(b.x), 0) for b in self.massive])

    @cached_property
    def m_columns(self) -> Index:
        return _join([b.x[None].repeat(len(b.x), 0) for b in self.massive])

    @cached_property
    def V(self) -> tuple[Place, ...]:
        return _places(self.strained, [(len(b.e), len(b.x)) for b in self.strained])

    @cached_property
    def M(self) -> tuple[Place, ...]:
        return _places(self.massive, [(len(b.x), len(b.x)) for b in self.massive])

    @cached_property
    def sizes(self) -> tuple[int, int]:
        """How many entries V and M have."""
        return sum(len(b.e) * b.x.size for b in self.strained), sum(len(b.x) * b.x.size for b in self.massive)

    # -- coordinates of all batches, deformations of the strained ones, coordinates of the moving ones ---------------
    @cached_property
    def x_index(self) -> Index:
        return _join([b.x for b in self.batches])

    @cached_property
    def e_index(self) -> Index:
        return _join([b.e for b in self.strained])

    @cached_property
    def f_index(self) -> Index:
        return _join([b.x for b in self.moving])

    @cached_property
    def x(self) -> tuple[Place, ...]:
        return _places(self.batches, [(len(b.x),) for b in self.batches])

    @cached_property
    def e(self) -> tuple[Place, ...]:
        return _places(self.strained, [(len(b.e),) for b in self.strained])

    @cached_property
    def f(self) -> tuple[Place, ...]:
        return _places(self.moving, [(len(b.x),) for b in self.moving])


def _join(parts: list[Index]) -> Index:
    return np.concatenate([p.ravel() for p in parts]) if parts else np.zeros(0, np.int64)


def _places(batches: Sequence[Batch], shapes: list[tuple[int, ...]]) -> tuple[Place, ...]:
    """Consecutive parts (*shape, n)."""
    places, first = [], 0
    for b, shape in zip(batches, shapes, strict=True):
        whole = (*shape, b.family.n)
        size = prod(whole)
        places.append((b.index, slice(first, first + size), whole))
        first += size
    return tuple(places)
