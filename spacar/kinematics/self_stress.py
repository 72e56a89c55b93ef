"""Self-stresses of rigid deformations: which of them are redundant, so that the release of one frees nothing.

A combination c of rows of R = dD/dx (over the coordinates that can move) with c R = 0 is a state of self-stress. It
means a redundant constraint only if it exists along the motion too. At a dead point (two collinear bars, a folded
crank) it exists in that position alone; the stress then resists the motions v with R v = 0 by its geometric
stiffness. Along a true redundancy all e of the rows stay zero, so D2e_i(v, v) + D e_i a = 0 and

    sum_i c_i D2e_i(v, v) = -c R a = 0          for all v with R v = 0,

which is the test, to the second order: those self-stresses mean a redundancy whose geometric stiffness vanishes on the
null space of R. It does when v^T K(c) v is zero for some random motions v, more of them than there are stresses (with
probability one).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array, Index
from spacar.kinematics.constraint_matrices import ZERO, entries_of, scaled_difference_matrix
from spacar.kinematics.element_sweep import ElementSweep, geometric_blocks
from spacar.kinematics.null_space import LARGEST_DECOMPOSED, norm_estimate, null_space, on_null_space
from spacar.mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from scipy.sparse import csr_array

MORE_MOTIONS = 8  # random motions beyond the number of stresses


def redundancies(mechanism: Mechanism, rows: Index, x: Array | None = None) -> Array:
    """Orthonormal self-stresses (len(rows), k) of the scaled deformations `rows` that mean a redundancy.

    x (nx,) is the configuration, the reference configuration by default. Of mechanisms with wheels the second-order
    test is left out, because slips have no second derivative of their own.
    """
    n = mechanism.numbering
    sweep = ElementSweep.at(mechanism, x)
    moving = np.arange(n.x_class["fixed"].stop, n.nx)
    large = max(len(rows), len(moving)) > LARGEST_DECOMPOSED
    if large:
        R = scaled_part(mechanism, sweep, rows, moving)
        norm = norm_estimate(R)
        stresses = null_space(R.T.tocsr(), norm, ZERO)[0]
    else:
        D = scaled_difference_matrix(mechanism, entries_of(sweep), rows, moving)
        if not D.size:
            return np.zeros((len(rows), 0))
        left, s, right = np.linalg.svd(D)
        rank = int(np.sum(s > ZERO * s[0]))
        stresses = left[:, rank:]
    count = stresses.shape[1]
    if not count or not n.holonomic:
        return np.asarray(stresses)
    v = np.zeros((n.nx, count + MORE_MOTIONS))
    any_motions = np.random.default_rng(1).standard_normal((len(moving), v.shape[1]))
    v[moving] = on_null_space(R, norm, any_motions) if large else right[rank:].T @ (right[rank:] @ any_motions)
    v *= mechanism.scale[:, None]
    work, size = np.zeros((v.shape[1], count)), 0.0
    for j, c in enumerate(stresses.T):
        sigma = np.zeros(n.ne)
        sigma[rows] = c / mechanism.deformation_scale[rows]
        square = 0.0
        for b, block in geometric_blocks(sweep, sigma):
            part, scale = v[b.x], mechanism.scale[b.x]
            work[:, j] += np.einsum("ink,ijn,jnk->k", part, block, part, optimize=True)
            square += float(np.sum((block * scale[:, None] * scale[None]) ** 2))
        size = max(size, float(np.sqrt(square)))
    _, s, right = np.linalg.svd(work, full_matrices=True)
    resisting = int(np.sum(s > ZERO * size))
    return np.asarray(stresses @ right[resisting:].T)


def scaled_part(mechanism: Mechanism, sweep: ElementSweep, rows: Index, columns: Index) -> csr_array:
    """The rows and columns of V at the sweep, dimensionless and sparse."""
    from scipy.sparse import coo_array

    scaled = sweep.v_entries * mechanism.scale[sweep.v_columns] / mechanism.deformation_scale[sweep.v_rows]
    V = coo_array((scaled, (sweep.v_rows, sweep.v_columns)), (sweep.ne, sweep.nx)).tocsr()
    return V[rows][:, columns]
