"""The compliance matrix of a node (reference/files.md section 5, "Forces on Euler parameters").

    C = T DX K^-1 DX^T T^T,  K = K0 + N0 + G0 of the degrees of freedom that may move, DX their columns of dx

T turns coordinates into displacements and small rotations: spatial diag(I, 2 Lambda_bar) along the global axes and
diag(R^T, 2 Lambda) along the axes of the body, Lambda_bar = [-l, l0 I + l~], Lambda = [-l, l0 I - l~]; planar the
identity and diag(R^T, 1).
"""

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError

SINGULAR = 1e14  # condition of the stiffness, scaled to a unit diagonal


def spatial_maps(lam: Array) -> tuple[Array, Array]:
    """T along global and along body axes, (6, 7) each, at the Euler parameters lam (4,) of the orientation node."""
    l0, l = lam[0], lam[1:]
    tilde = np.array([[0, -l[2], l[1]], [l[2], 0, -l[0]], [-l[1], l[0], 0]])
    bar = np.column_stack((-l, l0 * np.eye(3) + tilde))
    plain = np.column_stack((-l, l0 * np.eye(3) - tilde))
    fixed, body = np.zeros((6, 7)), np.zeros((6, 7))
    fixed[:3, :3], fixed[3:, 3:] = np.eye(3), 2 * bar
    body[:3, :3], body[3:, 3:] = (bar @ plain.T).T, 2 * plain
    return fixed, body


def planar_maps(phi: Array) -> tuple[Array, Array]:
    """The same in the plane, (3, 3) each, at the angle phi (1,)."""
    c, s = np.cos(phi[0]), np.sin(phi[0])
    return np.eye(3), np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])


def directions(planar: bool) -> tuple[str, ...]:
    """Names of the rows of T."""
    return ("ux", "uy", "phi") if planar else ("ux", "uy", "uz", "phix", "phiy", "phiz")


def compliance_of(K: Array, D: Array) -> Array:
    """D K^-1 D^T (m, m) of the stiffness K (n, n) and the displacements D (m, n) by the degrees of freedom.

    Raises AnalysisError 'compliance.singular'.
    """
    return np.asarray(D @ displacements(K, D.T))


def displacements(K: Array, force: Array) -> Array:
    """K^-1 force (n, m), with K (n, n) scaled to a unit diagonal. Raises AnalysisError 'compliance.singular'."""
    if not len(K):
        return np.zeros_like(force)
    d = np.sqrt(np.abs(np.diag(K)))
    scale = (1.0 / np.where(d > 0.0, d, d.max(initial=0.0) or 1.0))[:, None]
    scaled = K * scale * scale.T
    if np.linalg.cond(scaled) > SINGULAR:
        text = "the stiffness is singular (critical load or rigid motion): there is no compliance"
        raise AnalysisError(text, "compliance.singular")
    return np.asarray(scale * np.linalg.solve(scaled, scale * force))
