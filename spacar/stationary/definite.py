"""A proof that the tangent stiffness has no negative eigenvalue, at a tenth of the price of counting them.

With the rows V_c of the deformations that are given and V_e of those with element stiffness S, and any springs w > 0,

    P = K_g + V_e^T S V_e + V_c^T w V_c

is the tangent stiffness with springs in place of the constraints. On motions that keep the constraints the springs do
nothing: if P is positive definite, so is the tangent stiffness on these motions, and the mixed matrix, if it is
regular, has one negative eigenvalue for every stress and no more. (The reverse needs springs that are stiff enough:
P. Finsler, Comment. Math. Helv. 9 (1937) 188-192.) Whether P is positive definite is told by one Cholesky factorization
of the order of the coordinates. Where it fails nothing is proved, and the eigenvalues are counted.

Rounding must not prove anything: P is scaled to a diagonal of the sum of the sizes of its terms, n eps SAFE times the
largest term are taken off this diagonal, and a factorization that succeeds then is that of a positive definite matrix
(N. J. Higham, Accuracy and Stability of Numerical Algorithms, SIAM 2002, theorem 10.7: n eps of the diagonal is what
rounding can change).
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import EPS, Array
from spacar.linear_systems import DENSE_LIMIT
from spacar.mechanism.mechanism import Batch
from spacar.stationary.tangent import STATIC, SparseTangent

SAFE = 16.0
WEIGHT = 100.0  # springs of the constraints over the largest stiffness, each times the square of its length


class DefiniteStiffness:
    """Asked with the entries of the static matrix of one model, at the configuration where its sweep is."""

    def __init__(self, tangent: SparseTangent) -> None:
        self.t = t = tangent
        sweep, C, m = t.dynamics.sweep, t.flexibility, t.dynamics.mechanism
        self.n = n = t.nf
        self._blocks: list[tuple[Batch, Array, Array]] = []
        rows, columns = [t.parts[k].rows for k in STATIC], [t.parts[k].columns for k in STATIC]
        self._loading = sum(len(r) for r in rows)  # entries of K_g, which come first in the static matrix
        self._keep: list[Array] = []
        for b in sweep.strained:
            held = C.constrained[b.e] / m.deformation_scale[b.e] ** 2  # of those that are given
            S = np.zeros((len(held), *held.shape))
            if b.index in C.active:
                active = C.coupled[b.e] * ~C.constrained[b.e]
                S = b.family.stiffness()[0] * active[:, None] * active
            self._blocks.append((b, S.transpose(2, 0, 1), held.T))
            place = t.place[b.x].T
            i, j = (np.broadcast_to(p, (*place.shape, place.shape[1])).ravel()
                    for p in (place[:, :, None], place[:, None, :]))  # fmt: skip
            keep = np.flatnonzero((i >= 0) & (j >= 0))
            self._keep.append(keep)
            rows.append(i[keep])
            columns.append(j[keep])
        self._rows, self._columns = np.concatenate(rows), np.concatenate(columns)
        scale = m.scale[t.F]
        self._scales = scale[self._rows[: self._loading]] * scale[self._columns[: self._loading]]
        # The largest stiffness times the square of the largest length [N m].
        self._elastic = C.size * float(np.max(m.deformation_scale)) ** 2 if C.elastic else 0.0
        self._diagonal = np.flatnonzero(self._rows == self._columns)
        self._on_diagonal = self._rows[self._diagonal]
        self._banded = n > DENSE_LIMIT
        self.applies = n > 0
        if not self._banded:
            self._flat = self._rows * n + self._columns
            return
        from spacar.linear_systems.ordering import bandwidths, order

        rank, _ = order(n, self._rows, self._columns)
        i, j = rank[self._rows], rank[self._columns]
        self._width = bandwidths(i, j)[0]
        self._lower = np.flatnonzero(i >= j)
        self._flat = (j * (self._width + 1) + i - j)[self._lower]

    def proved(self, entries: Array) -> bool:
        """Is the tangent stiffness positive definite, by `entries` of the static matrix? False: it is not known."""
        loading = entries[: self._loading]
        size = max(self._elastic, float(np.max(np.abs(loading) * self._scales, initial=0.0)))
        if not (self.applies and 0.0 < size < np.inf):
            return False
        values = [loading]
        for (b, S, held), keep in zip(self._blocks, self._keep, strict=True):
            V = self.t.dynamics.sweep.V[b.index].transpose(2, 0, 1)
            spring = np.matmul(S, V)
            spring += (WEIGHT * size * held)[:, :, None] * V
            values.append(np.matmul(V.transpose(0, 2, 1), spring).ravel().take(keep))
        P = np.concatenate(values)
        size_of = np.bincount(self._on_diagonal, np.abs(P[self._diagonal]), self.n)
        if not (size_of > 0.0).all():
            return False
        d = 1.0 / np.sqrt(size_of)
        P *= d[self._rows] * d[self._columns]
        return self._positive(P, self.n * EPS * SAFE * max(1.0, float(np.max(np.abs(P)))))

    def _positive(self, values: Array, less: float) -> bool:
        """Has the matrix of these entries, with `less` taken off its diagonal, a Cholesky factorization?"""
        n = self.n
        if not self._banded:
            A: Array = np.bincount(self._flat, values, n * n)
            A[:: n + 1] -= less
            try:
                np.linalg.cholesky(A.reshape(n, n))
            except np.linalg.LinAlgError:
                return False
            return True
        from scipy.linalg.lapack import dpbtrf

        height = self._width + 1
        band: Array = np.bincount(self._flat, values[self._lower], height * n)
        band[::height] -= less
        return bool(dpbtrf(band.reshape(n, height).T, lower=1, overwrite_ab=1)[1] == 0)
