"""Over- and under-constraints after mode 0, from the stored derivative of the deformations (theory-system.md 1.1).

The part of bigd with the rows fixed, input, dynamic and the columns calculable, kinematic is made dimensionless
(lengths by the size of the mechanism) and decomposed: left null vectors are stresses that no load explains, right
null vectors are motions that no deformation feels. Singular values below sqrt(eps) times the largest count as zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES
from spacar.kinematics.null_space import norm_estimate, null_space
from spacar_drawing.scene import Scene

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from spacar_drawing.picture_source import PictureSource

ZERO = float(np.sqrt(np.finfo(float).eps))


@dataclass(frozen=True)
class Redundancy:
    """over (over-constraints, elements): share of every element number (squares, sum 1 with the normalizations);
    under (under-constraints, nx): motions."""

    over: Array
    under: Array


def stored_gradient(source: PictureSource, step: int) -> Array | csr_array:
    """bigd (ne, nx) of a step, sparse where it is stored as `bigds`. UsageError when neither is there."""
    entries = source.read("bigds", step)
    if entries is None:
        return source.get("bigd", step)
    from scipy.sparse import coo_array

    rows, columns = entries[:, :2].T.astype(int) - 1
    size = int(source.scene.nep.sum()), int(source.scene.nxp.sum())
    return coo_array((entries[:, 2], (rows, columns)), size).tocsr()


def redundancy(scene: Scene, bigd: Array | csr_array, extent: float) -> Redundancy:
    """The constraint analysis of a configuration; bigd (ne, nx), dense or sparse, extent the size of the mechanism [m].
    """
    nx, ne = int(scene.nxp.sum()), int(scene.nep.sum())
    column_scale, row_scale = np.ones(nx), np.ones(ne)
    k = 2 if scene.planar else 3
    column_scale[scene.lnp[scene.position_nodes - 1, :k] - 1] = extent
    owner = np.full(ne, -1)
    for e in scene.elements:
        for mode, (_, unit) in enumerate(ELEMENT_TYPES[e.keyword].modes, 1):
            i = scene.le[e.number - 1, mode - 1] - 1
            owner[i] = e.number - 1
            if unit == "m":
                row_scale[i] = extent
    rows = int(scene.nep[0] + scene.nep[2] + scene.nep[3])
    fixed = int(scene.nxp[0])
    columns = np.r_[fixed : fixed + scene.nxp[1], nx - scene.nxp[4] : nx]
    if not rows or not len(columns):
        return Redundancy(np.zeros((0, len(scene.keywords))), np.zeros((0, nx)))
    if isinstance(bigd, np.ndarray):
        D = (bigd * column_scale / row_scale[:, None])[:rows][:, columns]
        left, s, right = np.linalg.svd(D)
        rank = int(np.sum(s > ZERO * s[0]))
        stresses, motions = left[:, rank:], right[rank:].T
    else:
        part = bigd.multiply(column_scale).multiply(1.0 / row_scale[:, None]).tocsr()[:rows][:, columns]
        size = norm_estimate(part)
        stresses, motions = null_space(part.T.tocsr(), size, ZERO)[0], null_space(part, size, ZERO)[0]
    over = np.zeros((stresses.shape[1], len(scene.keywords)))
    for j, vector in enumerate(stresses.T):
        mine = owner[:rows] >= 0
        np.add.at(over[j], owner[:rows][mine], vector[mine] ** 2)
    under = np.zeros((motions.shape[1], nx))
    under[:, columns] = motions.T * column_scale[columns]
    return Redundancy(over, under)
