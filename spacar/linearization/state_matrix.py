"""State matrix A of the linearized equations (theory-system.md (15)), and the solution with the mass matrix in it.

State z = (ds, dqd) with s = (q, k) and qd restricted to the chosen rows (dynamic ones; all in mode 3).

    A = [Bk0, Ak0; -M^-1 K, -M^-1 C]                                                                           (15)
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError
from spacar.linearization.matrices import Linearization


def chosen_rows(L: Linearization, dynamics: Dynamics, everything: bool = False) -> tuple[Index, Index]:
    """Rows of q and of s that are states: the dynamic ones (and the kinematic ones), or all of them (mode 3)."""
    n = dynamics.numbering
    q = np.arange(n.ndof) if everything else n.dynamic
    return q, np.concatenate((q, np.arange(n.ndof, n.nkdof))) if n.nk else q


def selected(A: Array, rows: Index, columns: Index) -> Array:
    """A copy of A at these rows and columns."""
    return A.take(rows, axis=0).take(columns, axis=1)


EPS = float(np.finfo(float).eps)
MASSLESS = "singular mass matrix: a degree of freedom carries no mass; add XM or EM"


def require_mass(L: Linearization, q: Index) -> None:
    """Raises AnalysisError when the mass of a degree of freedom of the rows q is rounding of what it is the sum of.

    The sign of that rounding decides nothing: W^T M W is known to eps times nx times the sum of the sizes of its terms.
    Masses that overflow are not told here.
    """
    diagonal, size = L.m0.diagonal()[q], abs(L.M)
    W = L.W[:, q]
    rounding = EPS * len(W)
    with np.errstate(over="ignore", invalid="ignore"):
        # 2 |w_i w_j| <= w_i^2 + w_j^2: a bound that costs little and tells what is known of ordinary masses
        if (diagonal > rounding * (np.asarray(size.sum(1)).ravel() @ np.square(W))).all():
            return
        W = np.abs(W)
        terms = (W * np.asarray(size @ W)).sum(0)
    if np.any((diagonal <= rounding * terms) & (terms > 0.0) & np.isfinite(terms)):
        raise AnalysisError(MASSLESS, "dynamics.singular-mass")


def state_matrix(L: Linearization, q: Index, s: Index) -> Array:
    """A of (15). Raises AnalysisError when the mass matrix of the rows q is singular."""
    return assembled_state_matrix(
        selected(L.m0, q, q), selected(L.damping, q, q), selected(L.stiffness, q, s),
        selected(L.ak0, s, q), selected(L.bk0, s, s),
    )  # fmt: skip


def assembled_state_matrix(M: Array, C: Array, K: Array, ak0: Array, bk0: Array) -> Array:
    """A of (15) from M, C (q, q), K (q, s), ak0 (s, q), bk0 (s, s). Raises AnalysisError when M is singular."""
    return np.block([[bk0, ak0], [-solve_mass(M, np.hstack((K, C)))]])


def solve_mass(M: Array, b: Array) -> Array:
    """M^-1 b for a symmetric positive definite M, scaled to a unit diagonal. Raises AnalysisError for a singular M."""
    diagonal = np.diag(M)
    if np.any(diagonal <= 0.0):
        raise AnalysisError(MASSLESS, "dynamics.singular-mass")
    scale = 1.0 / np.sqrt(diagonal)
    try:
        solution = np.linalg.solve(M * np.outer(scale, scale), b * scale[:, None])
    except np.linalg.LinAlgError:
        raise AnalysisError("singular mass matrix; add XM or EM", "dynamics.singular-mass") from None
    return np.asarray(solution * scale[:, None])
