"""What rounding of the entries of a matrix makes of a solution.

A computed z solves (A + E) z = b with |E| about eps |A| (N. J. Higham, Accuracy and Stability of Numerical Algorithms,
SIAM 2002, section 7.2), so it is known to A^-1 (eps |A| |z|): a measure of singularity that takes the units and the
range of stiffness of a model as they are, where the size of z itself grows with both.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spacar.arrays import Array, Index

EPS = float(np.finfo(float).eps)


def entry_rounding(n: int, rows: Index, columns: Index, entries: Array, z: Array) -> Array:
    """eps |A| |z| of A (n, n) given by its entries, for z (n,)."""
    return np.asarray(EPS * np.bincount(rows, np.abs(entries * z[columns]), n))


def lost(solve: Callable[[Array], Array], rounding: Array, z: Array, count: int) -> float:
    """The change of z by `rounding` (n,) with alternating signs over z itself, each the largest of the first `count`
    unknowns; inf when it is not a number."""
    sign = np.where(np.arange(len(z)) % 2, -1.0, 1.0)
    change = float(np.max(np.abs(solve(sign * rounding)[:count]), initial=0.0))
    size = float(np.max(np.abs(z[:count]), initial=0.0))
    found = change / size if size > 0.0 else 0.0
    return found if np.isfinite(found) else np.inf
