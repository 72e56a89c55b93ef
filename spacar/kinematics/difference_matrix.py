"""The difference matrix dD/dx made comparable: lengths and rotations without dimension (theory-system.md 1.1)."""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.mechanism.mechanism import Mechanism

ZERO = float(np.sqrt(np.finfo(float).eps))  # singular values below this part of the largest count as zero


def scaled_difference_matrix(mechanism: Mechanism, V: Array) -> Array:
    """V (ne, nx) with dimensionless rows and columns."""
    return V * mechanism.scale / mechanism.deformation_scale[:, None]
