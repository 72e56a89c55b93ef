"""Corrections with a singular tangent: free rigid motions, cyclic coordinates, a state exactly at a critical load.

If the right-hand side is in the range of the matrix, the solution of minimum norm is taken: the free motion keeps its
place. Singular values of the matrix, scaled to rows of size one, count as zero below n eps times the largest times
SPREAD; what the right-hand side loses to them must be rounding, of the residual or relative to it.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.kinematics.kinematics import largest
from spacar.linear_systems import SingularMatrixError
from spacar.stationary.stationary_equations import EPS, SPREAD, Astray, Iterate, StationaryEquations, Tangent

LARGEST = 2000  # unknowns: the singular value decomposition takes ten seconds there
IN_RANGE = 1e-8  # relative: half of the digits of a matrix that is singular to working precision


class FreeMotion(Astray):
    """The load works on a motion without stiffness, most of all at `coordinate` of x."""

    def __init__(self, coordinate: int) -> None:
        super().__init__("the tangent stiffness is singular")
        self.coordinate = coordinate


def minimum_norm(q: StationaryEquations, tangent: Tangent, p: Iterate, dx: Array, strict: bool) -> tuple[Array, float]:
    """The correction (n,) of minimum norm and the noise in it.

    Raises FreeMotion if `strict`, SingularMatrixError for large systems.
    """
    A = tangent.dense()
    if len(A) > LARGEST:
        raise SingularMatrixError("a motion without stiffness, or exactly a critical load")
    if not np.isfinite(A).all():
        raise Astray("numbers that are not finite")
    right = p.right - tangent.along(dx) if dx.any() else p.right
    d, u, s, vt, regular = _decomposed(A)
    projected = u.T @ (d * right)
    lost = np.abs(projected[~regular])
    rounding = np.abs(u[:, ~regular]).T @ (d * p.rounding)
    if strict and (lost > np.maximum(IN_RANGE * np.linalg.norm(projected), SPREAD * rounding)).any():
        free = d * (vt[~regular].T @ (u[:, ~regular].T @ (d * right)))
        raise FreeMotion(int(q.F[np.argmax(np.abs(free[: q.nf] * p.right[: q.nf]))]))
    both = np.column_stack((projected, u.T @ (d * q.signs * p.rounding)))[regular]
    z = d[:, None] * (vt[regular].T @ (both / s[regular, None]))
    return z[:, 0], largest(z[: q.nf, 1] / q.free_scale)


def minimum_norm_solutions(A: Array, right: Array) -> Array:
    """z (n, k) of minimum norm, measured as in `minimum_norm`, with A z = right (n, k).

    Raises SingularMatrixError where a column is not in the range of A.
    """
    d, u, s, vt, regular = _decomposed(A)
    projected = u.T @ (d[:, None] * right)
    lost = np.linalg.norm(projected[~regular], axis=0)
    if (lost > IN_RANGE * np.linalg.norm(projected, axis=0)).any():
        raise SingularMatrixError("a motion without stiffness would have to move without limit")
    return np.asarray(d[:, None] * (vt[regular].T @ (projected[regular] / s[regular, None])))


def _decomposed(A: Array) -> tuple[Array, Array, Array, Array, Array]:
    """d (n,), with which d A d has rows and columns of size one; its singular value decomposition; which singular
    values are no rounding (n,)."""
    size = np.maximum(np.abs(A).max(axis=1, initial=0.0), np.abs(A).max(axis=0, initial=0.0))
    d = 1.0 / np.sqrt(np.where(size > 0.0, size, 1.0))
    u, s, vt = np.linalg.svd(A * d[:, None] * d)
    return d, u, s, vt, s > SPREAD * len(A) * EPS * s[0]
