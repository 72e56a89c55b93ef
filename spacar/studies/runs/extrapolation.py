"""Richardson's extrapolation over meshes with n, 2n, 4n elements a beam.

The error of a mesh is c h^2 + d h^4 + e h^6 + ..., in the angle measure with a small or no c: differences of coarse
meshes then show order 4, and c is what is left. Every variable has the order p = 2 or 4 that it shows,
2^p = |u_n - u_2n| / |u_2n - u_4n| in the norm of the study. With R_p = u_4n + (u_4n - u_2n)/(2^p - 1) and w, the
extrapolation of the three meshes with orders 2 and 4 (Romberg):

    p = 4, value R_4:  it errs by 0.8 c h^2 - 3.2 e h^6, w - R_4 = -0.8 c h^2 + 67 e h^6
    p = 2, value w:    it errs by 64 e h^6, w - R_2 = 4 d h^4 + 84 e h^6

MARGIN times such a difference is the error; unless two terms cancel, it is between MARGIN and 21 MARGIN times the true
one for p = 4. Three meshes before the asymptotic range may show order 2 where it is 4: until a fourth mesh shows it
again the error is at least DOUBT of the last difference, |R_2 - R_4|; then w is compared with the extrapolation of four
meshes with orders 2, 4, 6. A variable without an order has the value of the finest mesh, with the last difference as
error. No error is larger than that difference.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from spacar.arrays import Array

CLOSE = 0.6  # between observed and theoretical order
ROUNDING = 1e-13  # differences below cannot tell an order
MARGIN = 1.3  # of the estimate over the difference of two extrapolations
DOUBT = 1 / 3 - 1 / 15  # least error over the last difference, where order 2 shows for the first time


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
        return np.asarray(np.max(np.abs(v), axis=1, initial=0.0) / amplitude)

    differences = [size(b - a) for a, b in pairwise(meshes[-4:])]
    none = np.zeros(len(amplitude), int)
    before, order = [none, none, *(_orders(a, b) for a, b in pairwise(differences))][-2:]
    values, last = meshes[-1].copy(), differences[-1]
    errors = last.copy()
    if order.any():
        first, second, *third = _romberg(meshes[-4:], 2)[1:]
        fourth = _romberg(meshes[-2:], 4)[1]
        again = (order == 2) & (before == 2)
        for rows, value, other, least in (
            (order == 4, fourth, second, 0.0),
            ((order == 2) & ~again, second, first, DOUBT),
            (again, second, [first, *third][-1], 0.0),
        ):
            values[rows] = value[rows]
            errors[rows] = np.maximum(MARGIN * size(other - value), least * last)[rows]
    return Extrapolation(values, np.minimum(errors, last), order)


def _orders(first: Array, second: Array) -> Array:
    """The order 2 or 4 that two differences show, one after the other; 0: none."""
    told = (second > ROUNDING) & (first > 0.0)
    seen = np.log2(np.where(told, first, 1.0) / np.where(told, second, 1.0))
    return np.where(told & (np.abs(seen - 2) <= CLOSE), 2, np.where(told & (np.abs(seen - 4) <= CLOSE), 4, 0))


def _romberg(meshes: Sequence[Array], order: int) -> list[Array]:
    """The finest value of each level of the extrapolation with order, order + 2, ...; that of the mesh first."""
    table, finest = list(meshes), [meshes[-1]]
    while len(table) > 1:
        table = [b + (b - a) / (2**order - 1) for a, b in pairwise(table)]
        finest.append(table[-1])
        order += 2
    return finest
