"""Where the contributions of the batches are in the flat arrays of an evaluation: made once per mechanism.

The entries of V (ne x nx) come first, batch by batch, (n_deformations, n_coordinates, n) each, then those of M
(nx x nx), (n_coordinates, n_coordinates, n). A place is the part of a flat array that belongs to a batch, and its
shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod
from typing import NamedTuple

import numpy as np

from spacar.arrays import Index
from spacar.elements.family import Family
from spacar.records import quickly_made

Place = tuple[int, slice, tuple[int, ...]]  # index of the batch, part of the flat array, shape


class Batch(NamedTuple):
    """A family with its place in the global vectors, and its place among the batches of its mechanism."""

    family: Family
    x: Index  # (n_coordinates, n) indices into x
    e: Index  # (n_deformations, n) indices into e
    index: int = 0  # type: ignore[assignment]  # set by the Mechanism; arrays of an evaluation are kept under it


@quickly_made
@dataclass(frozen=True, eq=False, repr=False)
class Layout:
    """Batches by what they have, and the index arrays of all of them together."""

    strained: tuple[Batch, ...]
    massive: tuple[Batch, ...]
    moving: tuple[Batch, ...]  # mass matrix depends on the configuration
    curved: tuple[Batch, ...]  # V depends on the configuration
    v_rows: Index
    v_columns: Index
    m_rows: Index
    m_columns: Index
    x_index: Index  # coordinates of all batches
    e_index: Index  # deformations of all strained batches
    f_index: Index  # coordinates of all moving batches
    V: tuple[Place, ...]
    M: tuple[Place, ...]
    x: tuple[Place, ...]
    e: tuple[Place, ...]
    f: tuple[Place, ...]

    @classmethod
    def of(cls, batches: Sequence[Batch]) -> Layout:
        strained = tuple(b for b in batches if b.family.n_deformations)
        massive = tuple(b for b in batches if b.family.has_mass)
        moving = tuple(b for b in massive if not b.family.constant_mass)
        return cls(
            strained=strained,
            massive=massive,
            moving=moving,
            curved=tuple(b for b in strained if not b.family.constant_gradient),
            v_rows=_join([b.e.repeat(len(b.x), 0) for b in strained]),
            v_columns=_join([b.x[None].repeat(len(b.e), 0) for b in strained]),
            m_rows=_join([b.x.repeat(len(b.x), 0) for b in massive]),
            m_columns=_join([b.x[None].repeat(len(b.x), 0) for b in massive]),
            x_index=_join([b.x for b in batches]),
            e_index=_join([b.e for b in strained]),
            f_index=_join([b.x for b in moving]),
            V=_places(strained, [(len(b.e), len(b.x)) for b in strained]),
            M=_places(massive, [(len(b.x), len(b.x)) for b in massive]),
            x=_places(batches, [(len(b.x),) for b in batches]),
            e=_places(strained, [(len(b.e),) for b in strained]),
            f=_places(moving, [(len(b.x),) for b in moving]),
        )


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
