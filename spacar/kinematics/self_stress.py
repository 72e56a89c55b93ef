"""Self-stresses of rigid deformations: which of them are redundant, so that the release of one frees nothing.

A combination c of rows of R = dD/dx (over the coordinates that can move) with c R = 0 is a state of self-stress. It
means a redundant constraint only if it exists along the motion too. At a dead point (two collinear bars, a folded
crank) it exists in that position alone; the stress then resists the motions v with R v = 0 by its geometric
stiffness. Along a true redundancy all e of the rows stay zero, so D2e_i(v, v) + D e_i a = 0 and

    sum_i c_i D2e_i(v, v) = -c R a = 0          for all v with R v = 0,

which is the test, to the second order: the self-stresses whose geometric stiffness vanishes on the null space of R.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array, Index
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism.mechanism import Mechanism

ZERO = float(np.sqrt(np.finfo(float).eps))


def redundancies(mechanism: Mechanism, rows: Index, x: Array | None = None) -> Array:
    """Orthonormal self-stresses (len(rows), k) of the scaled deformations `rows` that mean a redundancy.

    x (nx,) is the configuration, the reference configuration by default. Of mechanisms with wheels the second-order
    test is left out, because slips have no second derivative of their own.
    """
    n = mechanism.numbering
    sweep = ElementSweep(mechanism)
    sweep.strain(mechanism.x0 if x is None else x)
    moving = np.arange(n.x_class["fixed"].stop, n.nx)
    row_scale, scale = mechanism.deformation_scale[rows], mechanism.scale[moving]
    R = sweep.gradient()[np.ix_(rows, moving)] * scale / row_scale[:, None]
    if not R.size:
        return np.zeros((len(rows), 0))
    left, s, right = np.linalg.svd(R)
    rank = int(np.sum(s > ZERO * s[0]))
    stresses, motions = left[:, rank:], right[rank:].T
    if not stresses.shape[1] or not motions.shape[1] or not n.holonomic:
        return np.asarray(stresses)
    columns, size = [], 0.0
    for c in stresses.T:
        sigma = np.zeros(n.ne)
        sigma[rows] = c / row_scale
        K = _geometric_stiffness(sweep, sigma)[np.ix_(moving, moving)] * scale * scale[:, None]
        size = max(size, float(np.linalg.norm(K)))
        columns.append((motions.T @ K @ motions).ravel())
    _, s, right = np.linalg.svd(np.array(columns).T, full_matrices=True)
    resisting = int(np.sum(s > ZERO * size))
    return np.asarray(stresses @ right[resisting:].T)


def _geometric_stiffness(sweep: ElementSweep, sigma: Array) -> Array:
    """Sum of sigma_i times the second derivatives of e_i, (nx, nx)."""
    out = np.zeros((sweep.nx, sweep.nx))
    for b in sweep.curved:
        block = np.zeros((len(b.x), len(b.x), b.family.n))
        b.family.geometric_stiffness(sweep.configuration[b.index], sigma[b.e], block)
        np.add.at(out, (b.x[:, None, :], b.x[None, :, :]), block)
    return out
