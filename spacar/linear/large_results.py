"""What is stored of a large model instead of dense matrices and transfer functions (reference/files.md section 5).

ktan  (entries, 3): row, column (from 1) and value of the tangent in mixed form, theory-system.md 6.7:
      unknowns dx of the calculable and dynamic coordinates, in the order of x, then all stresses over the typical
      stiffness. Of its inverse the rows and columns of the coordinates are dx/df: the compliance.
mtan  the same of the mass matrix of these coordinates.
eigxre, eigxim  (nx, n): motions of all coordinates in the modes of vibration;  bmodex (nx, n) in those of buckling

The pattern is the same at all steps; `spconvert(ktan)` of MATLAB and `coo_array((v, (i - 1, j - 1)))` of SciPy read it.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array, Index
from spacar.linear.buckling import BucklingModes
from spacar.linear.eigenmodes import Modes
from spacar.stationary.tangent import STATIC, SparseTangent


def sparse_matrices(tangent: SparseTangent) -> dict[str, Array]:
    """ktan and mtan of the present state."""
    n = tangent.nf + tangent.ne
    mass = tangent.parts["mass"]
    return {
        "ktan": _entries(*tangent.pattern(tuple(STATIC)), tangent.entries(STATIC)[0], n),
        "mtan": _entries(mass.rows, mass.columns, mass.values(), n),
    }


def vibration_motions(modes: Modes) -> dict[str, Array]:
    """eigxre and eigxim."""
    assert modes.motions is not None
    return {"eigxre": modes.motions.real, "eigxim": modes.motions.imag}


def buckling_motions(modes: BucklingModes, nx: int) -> dict[str, Array]:
    """bmodex; nan where there are no modes."""
    motions = modes.motions if modes.motions is not None else np.full((nx, len(modes.multipliers)), np.nan)
    return {"bmodex": motions}


def _entries(rows: Index, columns: Index, values: Array, n: int) -> Array:
    """Row, column, sum of the values, by columns; entries that happen to be zero stay."""
    places, slot = np.unique(columns.astype(np.int64) * n + rows, return_inverse=True)
    return np.column_stack((places % n + 1.0, places // n + 1.0, np.bincount(slot.ravel(), values, len(places))))
