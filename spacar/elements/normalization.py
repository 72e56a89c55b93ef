"""Normalization of the Euler parameters of a node: e = lam.lam - 1 (theory-spatial.md section 1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.elements.family import Family


class Normalization(Family):
    """One row for each spatial orientation node; `nodes` (n,) are the user's node numbers."""

    n_coordinates = 4
    n_deformations = 1
    keyword = "normalization"

    def __init__(self, nodes: NDArray[np.int64]) -> None:
        self.numbers = nodes
        self.length = np.zeros(len(nodes))

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> None:
        e[0] = np.einsum("i...,i...->...", x, x) - 1.0
        np.multiply(x, 2.0, out=V[0])

    def convective_strain(self, c: None, v: Array, out: Array) -> None:
        out[0] = 2.0 * np.einsum("i...,i...->...", v, v)

    def gradient_rate(self, c: None, v: Array, out: Array) -> None:
        np.multiply(v, 2.0, out=out[0])

    def rate_gradient(self, c: None, v: Array, out: Array) -> None:
        out[...] = 0.0

    def geometric_stiffness(self, c: None, sigma: Array, out: Array) -> None:
        for i in range(4):
            out[i, i] = 2.0 * sigma[0]
