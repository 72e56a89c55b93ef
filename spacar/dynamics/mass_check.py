"""Is the reduced mass matrix of the dynamic degrees of freedom regular? Says which motion carries no mass.

M_dd = W_d^T (M + V^T M_e V) W_d is scaled to a unit diagonal first, so that metres and radians compare; its smallest
eigenvalue below 1e-13 means a motion without inertia to working precision.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.saddle_point import DeformationInertia
from spacar.errors import AnalysisError
from spacar.kinematics.kinematics import Kinematics
from spacar.kinematics.transfer import velocity_transfer
from spacar.mechanism.numbering import Numbering

SMALLEST = 1e-13
LARGEST_CHECKED = 400  # dense work of order nx nq^2; larger models are caught by the factorization itself


def require_regular_mass(n: Numbering, M: Array) -> None:
    """Raises AnalysisError 'dynamics.singular-mass' naming the degrees of freedom without mass.

    M: reduced mass matrix of the dynamic degrees of freedom, (nddof, nddof).
    """
    diagonal = M.diagonal()
    light = diagonal <= 0.0
    if not light.any():
        scale = np.sqrt(diagonal)
        scaled = M / (scale[:, None] * scale)
        if np.linalg.eigvalsh(scaled)[0] > SMALLEST:
            return
    names = [n.q_names[k] for k in n.dynamic]
    massless = [names[k] for k in np.flatnonzero(light)]
    if not massless:
        vectors = np.linalg.eigh(scaled)[1]
        weight = np.abs(vectors[:, 0] / scale)
        massless = [names[k] for k in np.argsort(-weight)[:3] if weight[k] > 0.1 * weight.max()]
    text = (
        "singular mass matrix: no inertia on the motion of "
        + ", ".join(massless[:6])
        + "; add mass (XM, EM) or prescribe (INPUTX, INPUTE) or release (RLSE) it"
    )
    raise AnalysisError(text, "dynamics.singular-mass")


def is_checked(n: Numbering) -> bool:
    """Whether the model is small enough for the check."""
    return n.nddof > 0 and n.ndof <= LARGEST_CHECKED


def dynamic_mass(k: Kinematics, coupling: DeformationInertia) -> Array:
    """W^T (M + V^T M_e V) W of the dynamic degrees of freedom, (nddof, nddof), at the placed configuration."""
    W = velocity_transfer(k)[:, k.numbering.dynamic]
    M = np.array([k.sweep.mass_times(column) for column in W.T]) @ W
    if coupling.present:
        i, j, value = coupling.table
        We = k.sweep_rates(W)
        M += We[i].T @ (value[:, None] * We[j])
    return M
