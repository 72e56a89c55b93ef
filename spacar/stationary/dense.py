"""The Newton step with dense matrices: exact tangent K0 + N0 + G0, singular stiffness (theory-system.md 6.1)."""

from __future__ import annotations

import numpy as np

from spacar.dynamics.dynamics import Dynamics
from spacar.errors import AnalysisError
from spacar.linearization.matrices import linearize
from spacar.mechanism.mechanism import Array
from spacar.stationary.equilibrium import Equilibrium

IN_RANGE = 1e-8  # relative: is the residual in the range of a singular stiffness?
SINGULAR = 1e-13


def tangent(dynamics: Dynamics, state: Equilibrium, without_n0: bool) -> Array:
    """(K0 + N0 + G0) of the dynamic rows and columns, (nddof, nddof)."""
    L = linearize(dynamics, state.xdd, state.sigma)
    K = L.k0 + L.g0 if without_n0 else L.stiffness
    rows = dynamics.numbering.dynamic
    return K[np.ix_(rows, rows)]


def solve_tangent(K: Array, residual: Array, names: list[str], size: float = 0.0) -> Array:
    """K^-1 R; the minimum norm solution when K is singular and R in its range, else AnalysisError.

    `size` is the magnitude of the forces in R: what R loses to the null space may be rounding of them.
    """
    diagonal = np.sqrt(np.abs(np.diag(K)))
    largest = float(diagonal.max(initial=0.0)) or 1.0
    scale = np.where(diagonal > 1e-8 * largest, diagonal, largest)
    u, s, vt = np.linalg.svd(K / np.outer(scale, scale))
    regular = s > SINGULAR * s[0] if s[0] > 0.0 else np.zeros(len(s), bool)
    if regular.all():
        return np.linalg.solve(K, residual)
    projected = u.T @ (residual / scale)
    lost = float(np.linalg.norm(projected[~regular]))
    rounding = 1e-12 * size / float(scale.min())
    if lost > IN_RANGE * float(np.linalg.norm(projected)) and lost > rounding:
        worst = names[int(np.argmax(np.abs(vt[-1])))]
        text = (
            "no stationary solution: the stiffness matrix is singular and the load works on a motion without"
            " stiffness, mainly"
            f" {worst}; support it (FIX), prescribe it (INPUTX, INPUTE) or give it a stiffness (ESTIFF)"
        )
        raise AnalysisError(text, "statics.no-solution")
    return np.asarray((vt[regular].T @ (projected[regular] / s[regular])) / scale)
