"""Third order transfer functions as full tensors, for the log only (theory-system.md 1.3).

    D3F_x[:,a,b,c] = solveU(-B_abc),    D3F_e[:,a,b,c] = B_abc + V D3F_x[:,a,b,c]
    B_abc = D3D(G_a, G_b, G_c) + H(F_ab, G_c) + H(F_bc, G_a) + H(F_ca, G_b),    F_ab = D2F_x[:,a,b]

The element families give T(v)[e,j] = D3D(v, v, unit_j); polarization gives D3D(u, v, .) = (T(u+v) - T(u-v))/4.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.kinematics.kinematics import Kinematics
from spacar.kinematics.second_order_transfer import gradient_tensor


def third_order_transfer(k: Kinematics, G: Array, d2x: Array) -> tuple[Array, Array]:
    """d3x (nx, n, n, n) and d3e (ne, n, n, n) from G (nx, n) and d2x (nx, n, n) at the present configuration."""
    n, ne, nx = G.shape[1], k.numbering.ne, k.numbering.nx
    H = gradient_tensor(k)
    HG = np.einsum("eij,jc->eic", H, G)  # H is symmetric in i, j for holonomic rows
    mixed = np.einsum("eic,iab->eabc", HG, d2x, optimize=True)
    bracket = mixed + mixed.transpose(0, 3, 1, 2) + mixed.transpose(0, 2, 3, 1)
    for a in range(n):
        for b in range(a, n):
            third = (_rate_gradient(k, G[:, a] + G[:, b]) - _rate_gradient(k, G[:, a] - G[:, b])) / 4.0 @ G
            bracket[:, a, b] += third
            if b != a:
                bracket[:, b, a] += third
    flat = bracket.reshape(ne, n**3)
    d3x = np.zeros((nx, flat.shape[1]))
    d3x[k.c] = k.position_system.solve(-flat[k.h])
    d3e = flat + k.sweep_rates(d3x)
    return d3x.reshape(nx, n, n, n), d3e.reshape(ne, n, n, n)


def _rate_gradient(k: Kinematics, v: Array) -> Array:
    """T(v), (ne, nx)."""
    out = np.zeros((k.numbering.ne, k.numbering.nx))
    for b in k.sweep.curved:
        block = np.zeros((len(b.e), len(b.x), b.family.n))
        b.family.rate_gradient(k.sweep.configuration[b.index], v[b.x], block)
        out[b.e[:, None, :], b.x[None, :, :]] = block
    return out
