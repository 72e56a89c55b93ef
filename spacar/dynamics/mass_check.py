"""Is the reduced mass matrix of the dynamic degrees of freedom regular? Says which motion carries no mass.

M_dd = W_d^T (M + V^T M_e V) W_d is scaled to a unit diagonal first, so that metres and radians compare. Its entries
are then at most 1 and known to a few eps, its norm is at most the number q of degrees of freedom, so its eigenvalues
are known to 8 q eps (Weyl; 8 for the sums): a smallest one below that cannot be told from zero. A larger one may
belong to a light part that carries a heavy one (mass ratio 1e13 in relative coordinates), which the saddle-point form
solves accurately.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.saddle_point import DeformationInertia
from spacar.errors import AnalysisError
from spacar.kinematics.kinematics import Kinematics
from spacar.kinematics.transfer import velocity_transfer
from spacar.mechanism.numbering import Numbering

SMALLEST = 8.0 * float(np.finfo(float).eps)  # per degree of freedom
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
        if np.linalg.eigvalsh(scaled)[0] > SMALLEST * len(M):
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
