"""Second order transfer functions as full tensors, for OUTLEVEL only (theory-system.md (6)).

D2F_x[:,a,b] = solveU(-H(G_a, G_b)),     D2F_e[:,a,b] = H(G_a, G_b) + V D2F_x[:,a,b]
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.kinematics.kinematics import Kinematics


def second_order_transfer(k: Kinematics, G: Array) -> tuple[Array, Array]:
    """d2x (nx, nkdof, nkdof) and d2e (ne, nkdof, nkdof) at the present configuration."""
    size = G.shape[1]
    H = gradient_tensor(k)
    curvature = np.einsum("eij,ia,jb->eab", H, G, G, optimize=True).reshape(len(H), size * size)
    d2x = np.zeros((k.numbering.nx, size * size))
    d2x[k.c] = k.position_system.solve(-curvature[k.h])
    d2e = curvature + k.sweep_rates(d2x)
    return d2x.reshape(len(d2x), size, size), d2e.reshape(len(d2e), size, size)


def gradient_tensor(k: Kinematics) -> Array:
    """H as a full (ne, nx, nx) array; only for output, from unit stresses."""
    sweep = k.sweep
    H = np.zeros((sweep.ne, sweep.nx, sweep.nx))
    for batch in sweep.curved:
        nee, nxe, n = len(batch.e), len(batch.x), batch.family.n
        for row in range(nee):
            sigma = np.zeros((nee, n))
            sigma[row] = 1.0
            block = np.zeros((nxe, nxe, n))
            batch.family.geometric_stiffness(sweep.configuration[batch.index], sigma, block)
            for element in range(n):
                x = batch.x[:, element]
                H[np.ix_([batch.e[row, element]], x, x)] += block[None, :, :, element]
    return H
