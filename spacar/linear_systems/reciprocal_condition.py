"""Smallest singular value of a factored system, its reciprocal condition number, and the digits that rounding leaves.

Power method for B^-T B^-1, B = diag(row_scale) A diag(column_scale): the largest singular value 1/s of B^-1 is found
from below, with B^-1 u = w/s; a growth of less than a tenth ends it. The start vector, b_i = (-1)^i (1 + i/(n - 1)),
has no symmetry that a model could share (Higham's vector: N. J. Higham, Accuracy and Stability of Numerical Algorithms,
SIAM 2002, section 15.3). The reciprocal condition of dense storage is that of the 1-norm, exact, from the solutions of
all unit vectors in one call: within sqrt(n) of the other, and what the compiled solver gives.

A computed z solves (A + E) z = b with |E| about eps |A| (N. J. Higham, Accuracy and Stability of Numerical Algorithms,
SIAM 2002, section 7.2), so it is known to A^-1 (eps |A| |z|): a measure of singularity that takes the units and the
range of stiffness of a model as they are, where the size of z itself grows with both.
"""

from collections.abc import Callable

import numpy as np

from spacar.arrays import EPS, Array, Index
from spacar.linear_systems.linear_system import LinearSystem, SingularMatrixError

ITERATIONS = 10
SETTLED = 1.1  # growth of the estimate in one iteration below which it is good enough: a factor of two does not matter


def reciprocal_condition(system: LinearSystem, norm: float, row_scale: Array, column_scale: Array) -> float:
    """s/|B|, both scales (n,); `norm` is |B|. `system` is A, factored. 0 when singular."""
    n = system.n
    if n == 0:
        return 1.0
    if system.kind != "dense":
        return smallest(system, row_scale, column_scale)[0] / norm
    try:
        inverse = np.abs(system.solve(np.eye(n)))
        size = norm * float(((1.0 / column_scale) @ inverse / row_scale).max())
    except SingularMatrixError:
        return 0.0
    return 1.0 / size if 0.0 < size < np.inf else 0.0


def smallest(system: LinearSystem, row_scale: Array, column_scale: Array) -> tuple[float, Array, Array]:
    """s, u and w (n,) of norm 1 with B w = s u; s = 0 when singular."""
    n = system.n
    u = 1.0 + np.arange(n) / max(n - 1.0, 1.0)
    u[1::2] *= -1.0
    u /= np.linalg.norm(u)
    w, estimate = u, 0.0

    def image(solve: Callable[[Array], Array], v: Array, first: Array, then: Array) -> tuple[Array, float]:
        y = solve(v / first) / then
        size = float(np.linalg.norm(y))
        if not 0.0 < size < np.inf:
            raise SingularMatrixError("the solution is zero or not finite")
        return y / size, size

    try:
        for _ in range(ITERATIONS):
            w, size = image(system.solve, u, row_scale, column_scale)
            if size <= SETTLED * estimate:
                return 1.0 / size, u, w
            estimate = size
            u, _ = image(system.solve_transposed, w, column_scale, row_scale)
    except SingularMatrixError:
        return 0.0, u, w
    return 1.0 / estimate, u, w


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
