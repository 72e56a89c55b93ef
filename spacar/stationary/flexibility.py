"""The constitutive law with the stresses as unknowns: e = C (sigma - sigma_0), C = S^-1 element by element.

Row by row of e, with the typical stiffness `size` (the largest entry of S), by which rows are multiplied to compare:

    fixed and prescribed     e - e_given = 0                         the stress is a multiplier
    with stiffness           e - C (sigma - sigma_0) = 0
    without                  (sigma - sigma_0) / size = 0
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError
from spacar.mechanism.mechanism import Batch


class Flexibility:
    """C of one model. `rows`, `columns` (k,) place its entries, `rigid` the rows of e without element stiffness.

    `released` (k,): prescribed rows of e that are free and without stiffness nevertheless.
    """

    def __init__(self, dynamics: Dynamics, released: Sequence[int] = ()) -> None:
        n, sweep = dynamics.numbering, dynamics.sweep
        self.ne = n.ne
        self.constrained = np.zeros(n.ne, bool)
        self.constrained[: n.e_class["input"].stop] = True
        self.constrained[list(released)] = False
        self.elastic = [b for b in sweep.strained if any(S.any() for S in b.family.stiffness())]
        self.active = {b.index: (b.e >= dynamics.law.first).astype(float) for b in self.elastic}
        self.rows, self.columns = squares([b.e for b in self.elastic])
        rigid = np.ones(n.ne, bool)
        rigid[self.rows] = False
        self.rigid = np.flatnonzero(rigid)
        # their diagonal: zero for a multiplier, else sigma / size alone
        self.rigid_diagonal = np.where(self.constrained[self.rigid], 0.0, 1.0)
        self._has_passive = bool(self.rigid_diagonal.any())
        self.values, self.coupled, self.size = self.inverse()

    def inverse(self, stiffness: float = 1.0, damping: float = 0.0) -> tuple[Array, Array, float]:
        """For A = stiffness x S + damping x S_d: entries of size x A^-1; the rows with an e, (ne,) 0 or 1; the size."""
        coupled, blocks = np.zeros(self.ne), []
        for b in self.elastic:
            S, Sd = b.family.stiffness()
            if stiffness != 1.0 or damping:
                S = stiffness * S + damping * Sd
            elastic = (_diagonal(S) != 0.0) * self.active[b.index]
            S = S * elastic[:, None] * elastic[None, :]
            coupled[b.e] = elastic
            blocks.append((b, S, elastic))
        size = max((float(np.abs(S).max()) for _, S, _ in blocks), default=1.0) or 1.0
        values = []
        for b, S, elastic in blocks:
            S = S / size
            diagonal = _diagonal(S)
            diagonal += 1.0 - elastic  # decoupled rows: sigma alone, or the multiplier below
            C = np.ascontiguousarray(_inverted(S, b))
            diagonal = _diagonal(C)
            diagonal -= self.constrained[b.e]
            values.append(C.ravel())
        coupled[self.constrained] = 1.0
        return np.concatenate(values) if values else np.zeros(0), coupled, size

    @property
    def definite(self) -> bool:
        """Is the stiffness of all elements positive (semi)definite?"""
        for b in self.elastic:
            S = b.family.stiffness()[0].transpose(2, 0, 1).copy()
            diagonal = np.einsum("nii->ni", S)
            diagonal += diagonal == 0.0  # rows without stiffness
            try:
                np.linalg.cholesky(S)
            except np.linalg.LinAlgError:
                return False
        return True

    def times(self, sigma: Array) -> Array:
        """C sigma of rows with stiffness, sigma / size of rows without, zero for multipliers, (ne,)."""
        out = np.bincount(self.rows, self.values * sigma.take(self.columns), self.ne) / self.size
        if self._has_passive:
            out[self.rigid] += self.rigid_diagonal * sigma[self.rigid] / self.size
        return out

    @property
    def entries(self) -> tuple[Index, Index, Array]:
        """Rows, columns, values of C x size, (ne, ne)."""
        rows, columns = (np.concatenate((part, self.rigid)) for part in (self.rows, self.columns))
        return rows, columns, np.concatenate((self.values, self.rigid_diagonal))


def _inverted(S: Array, batch: Batch) -> Array:
    """Inverse of each (n, n) block of S (n, n, elements). Raises AnalysisError for a singular one."""
    blocks = S.transpose(2, 0, 1)
    try:
        return np.linalg.inv(blocks).transpose(1, 2, 0)
    except np.linalg.LinAlgError:
        finite = np.isfinite(blocks).all((1, 2))
        worst = int(np.argmax(np.linalg.cond(blocks))) if finite.all() else int(np.argmin(finite))
        element = f"element {batch.family.numbers[worst]} ({batch.family.keyword})"
        text = f"the stiffness of {element} is singular to working precision: its deformations do not follow from its "
        text += "stresses; check ESTIFF (a beam that is extremely soft in shear has no bending stiffness of its own)"
        raise AnalysisError(text, "stationary.singular-stiffness") from None


def squares(places: Sequence[Index]) -> tuple[Index, Index]:
    """Rows and columns of square blocks over these places (rows, elements) of each batch."""
    empty = np.zeros(0, np.int64)
    rows = [at.repeat(len(at), axis=0).ravel() for at in places]
    columns = [np.concatenate([at] * len(at)).ravel() for at in places]
    return np.concatenate([empty, *rows]), np.concatenate([empty, *columns])


def _diagonal(S: Array) -> Array:
    """The diagonals of blocks (n, n, elements) that lie one after the other, a view (n, elements)."""
    n = len(S)
    return S.reshape(n * n, -1)[:: n + 1]
