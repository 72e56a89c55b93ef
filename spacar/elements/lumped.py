"""Lumped mass on single coordinates: mass of a position node, rotary inertia of a planar orientation node (XM).

M = m (1 x 1 per coordinate) [kg or kg m^2], constant; no convective terms.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.elements.family import Configuration, Family


class LumpedMass(Family):
    """One entry per coordinate; `positions` tells which of them are position coordinates (they feel gravity)."""

    n_coordinates: ClassVar[int] = 1
    keyword = "XM"
    has_mass = True
    constant_mass = True

    def __init__(self, nodes: NDArray[np.int64], m: Array) -> None:
        self.numbers = nodes
        self.m = m
        self.length = np.zeros(len(m))

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> Configuration:
        return None

    def mass(self, c: Configuration, out: Array) -> None:
        out[0, 0] = self.m

    def inertia_force(self, c: Configuration, v: Array, a: Array | None) -> Array:
        return np.zeros_like(v) if a is None else self.m * a
