"""Richardson's extrapolation over meshes with ..., n, 2n, 4n elements a beam.

For an error c h^p + d h^(p+2) + ... steps of extrapolation are made with the factors 2^p, 2^(p+2) ... (Romberg). Every
variable has the order that it shows, 2^p = |u_n - u_2n| / |u_2n - u_4n| in the norm of the study, taken as 2 or 4, the
orders of beams of this kind, if it is close to one of them. As many meshes count as show the same order one after the
other. The error estimate is the smallest last step of the extrapolation, from the second one on: an upper estimate
while the expansion holds. What an accidental order could gain is bounded by
GAINED for each three meshes that show it, once more if all variables share it.
A variable without an order has the value of the finest mesh, with the last difference as error.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from spacar.arrays import Array

ORDERS = (2, 4)
CLOSE = 0.6  # between observed and theoretical order
ROUNDING = 1e-13  # differences below cannot tell an order
GAINED = 0.02  # error of an extrapolated variable over the last difference, at least


@dataclass(frozen=True)
class Extrapolation:
    """values (variables, steps), errors (variables,) in amplitudes, order (variables,) that was used: 0, 2 or 4."""

    values: Array
    errors: Array
    order: Array

    @property
    def error(self) -> float:
        """The largest."""
        return float(self.errors.max(initial=0.0))

    def orders(self, counted: Array | bool = True) -> str:
        """How many variables were extrapolated with which order, in words."""
        seen = {p: int(np.sum((self.order == p) & counted)) for p in (4, 2, 0)}
        return ", ".join(f"{k} with order {p}" if p else f"{k} not" for p, k in seen.items() if k)


def extrapolate(meshes: Sequence[Array], amplitude: Array) -> Extrapolation:
    """Values (variables, steps) of two meshes or more, each twice as fine as the one before; amplitude (variables,)."""

    def size(v: Array) -> Array:
        return np.asarray(np.max(np.abs(v), axis=1, initial=0.0))

    differences = [size(b - a) / amplitude for a, b in pairwise(meshes)]
    found = np.zeros((len(meshes) - 2, len(amplitude)), int)
    for row, (first, second) in zip(found, pairwise(differences), strict=True):
        told = (second > ROUNDING) & (first > 0.0)
        seen = np.log2(np.where(told, first, 1.0) / np.where(told, second, 1.0))
        for p in ORDERS:
            row[told & (np.abs(seen - p) <= CLOSE)] = p
    values, errors = meshes[-1].copy(), differences[-1].copy()
    order = found[-1] if len(found) else np.zeros(len(amplitude), int)
    often = np.cumprod(found[::-1] == order, axis=0).sum(axis=0) if len(found) else order
    shared = len(order) > 1 and len(set(order.tolist())) == 1
    for p in ORDERS:
        for k in range(1, len(found) + 1):
            rows = np.flatnonzero((order == p) & (often == k))
            table = [mesh[rows] for mesh in meshes[-k - 2 :]]
            least = np.full(len(rows), np.inf)
            for q in range(p, p + 2 * k + 1, 2):
                before = table[-1]
                table = [(2**q * b - a) / (2**q - 1) for a, b in pairwise(table)]
                step = size(table[-1] - before) / amplitude[rows]
                better = (step < least) & (q > p)
                values[rows[better]], least[better] = table[-1][better], step[better]
            errors[rows] = np.maximum(least, GAINED ** (k + shared) * differences[-1][rows])
    return Extrapolation(values, errors, order)
