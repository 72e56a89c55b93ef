"""Sparse storage for meshes and tree-like mechanisms whose band is wide: SuperLU with COLAMD ordering."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu

from spacar.arrays import Array, Index
from spacar.linear_systems.linear_system import SingularMatrixError, parity


class SparseSystem:
    """The compressed pattern is built once; `factor` only fills values."""

    kind = "sparse"

    def __init__(self, n: int, rows: Index, columns: Index) -> None:
        self.n = n
        by_row = _order(rows, n)
        order = by_row[_order(columns[by_row], n)]
        i, j = rows[order], columns[order]
        new = np.concatenate(([True], (i[1:] != i[:-1]) | (j[1:] != j[:-1])))[: len(order)]
        self.slot = np.empty(len(order), np.int32)
        self.slot[order] = np.cumsum(new, dtype=np.int32) - 1
        self.nnz = int(np.count_nonzero(new))
        self.indices = i[new].astype(np.int32)
        self.indptr = np.concatenate(([0], np.cumsum(np.bincount(j[new], minlength=n)))).astype(np.int32)

    def assembled(self, entries: Array) -> Any:
        """The matrix, in compressed columns."""
        values = np.bincount(self.slot, entries, self.nnz)
        return csc_matrix((values, self.indices, self.indptr), (self.n, self.n))

    def factor(self, entries: Array) -> None:
        try:
            self.lu = splu(self.assembled(entries))
        except RuntimeError as error:
            raise SingularMatrixError(f"matrix of order {self.n} is singular ({error})") from None

    def solve(self, b: Array) -> Array:
        return np.asarray(self.lu.solve(b))

    def solve_transposed(self, b: Array) -> Array:
        return np.asarray(self.lu.solve(b, trans="T"))

    def determinant_sign(self) -> float:
        negative = int(np.sum(self.lu.U.diagonal() < 0.0))
        return parity(self.lu.perm_r) * parity(self.lu.perm_c) * (-1.0 if negative % 2 else 1.0)


def _order(keys: Index, n: int) -> Index:
    """The stable order of keys below n, with a third of the memory that sorting them takes: a matrix with one entry a
    row, by columns."""
    m = len(keys)
    rows = csr_matrix((np.ones(m, np.int8), keys.astype(np.int32), np.arange(m + 1, dtype=np.int32)), (m, n))
    return np.asarray(rows.tocsc().indices)
