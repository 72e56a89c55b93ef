"""Mixed matrices of frames and lattices, solved by their condensed matrix (theory-system.md 6.7).

    [ K  V^T ] [ x ]   [ f ]        C = 0 in the rows of constraints, blocks of elements in the others
    [ V  -C  ] [ y ] = [ g ]

Rows with C are eliminated element by element, K_c = K + V_e^T C^-1 V_e; constraints by an orthonormal basis N of the
null space of every group of rows that share unknowns, from V_c^T = Q T, which leaves R = N^T K_c N. Constraints in
large groups (frames without elongation) have springs instead, C = 1/w, of which the refinement
makes constraints again (augmented Lagrangian: J. Nocedal, S. Wright, Numerical Optimization, Springer 2006, section
17.3). R is factored without exchanges in minimum degree order, and every solution is refined on the mixed matrix until
its residual is rounding (N. J. Higham, Accuracy and Stability of Numerical Algorithms, SIAM 2002, section 12.2), so
that it does not matter how many digits the condensation has lost.

Without exchanges R = L D L^T if it is symmetric, and D has the signs of its eigenvalues (Sylvester). They count if the
solution for a load along the eigenvector of the smallest eigenvalue, in which errors of the factors are largest,
changes by less than CLEAR in its refinement: no eigenvalue is closer to zero than rounding has moved it. Springs w
instead of t constraints may add negative eigenvalues: with the block F of the inverse in their rows and columns as many
as diag(w) + F has (the inertia of a bordered matrix, E. Haynsworth, Linear Algebra Appl. 1 (1968) 73-81).

Where a pivot is zero or the refinement does not converge the mixed matrix itself is factored.
"""

from functools import cached_property
from typing import Any, cast

import numpy as np
from scipy.sparse import block_diag, csc_matrix, csr_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from spacar.arrays import EPS, Array, Index
from spacar.linear_systems.linear_system import LinearSystem, SingularMatrixError, compressed_sum, rows_of
from spacar.linear_systems.sparse import SparseSystem
from spacar.linear_systems.sparse_factors import SUFFICIENT, diagonal, narrow, refined

LOCAL = 60  # unknowns of a group of constraints up to which it has a dense basis,
LOCAL_MOTIONS, LARGEST = 24, 600  # and motions and unknowns of one that is a few rigid bodies
SPRING = 1e5  # of a constraint without a basis, over the largest stiffness of its unknowns
MOST_SPRINGS = 400  # whose block of the inverse is decomposed
SYMMETRIC = 1e-12  # relative: rounding of the element blocks
CLEAR = 0.1  # change of a solution in its first refinement below which no sign is in doubt
LOST = 3e-11  # the same, below which the inverse is given without refinement
POWERS = 3  # steps of the power method for the smallest eigenvalue


class CondensedSystem(LinearSystem):
    """The first `nf` unknowns are x. Raises SingularMatrixError where constraints repeat each other."""

    kind = "condensed"
    A = lu = R = N = _NT = _G = _K = _V = _SV = cast(Any, None)

    def __init__(self, n: int, rows: Index, columns: Index, nf: int) -> None:
        self.n, self.nf = n, nf
        self._whole = SparseSystem(n, rows, columns)
        self._C: Array | None = None
        self.was_mixed = False  # was the mixed matrix once factored instead?
        self.forget()

    def forget(self) -> None:
        """What depends on the entries: two of them would take twice the memory."""
        self._entries, self._mixed = np.zeros(0), False
        for name in ("A", "lu", "R", "N", "_NT", "_G", "_K", "_V", "_SV", "pivots", "lost"):
            self.__dict__.pop(name, None)

    def factor(self, entries: Array) -> None:
        """Nothing is done for the entries that were factored last; they are kept, not copied."""
        if np.array_equal(entries, self._entries):
            return
        self.forget()
        A = self.assembled(entries)
        self.A = csr_array(A)
        try:
            self._condense(A)
        except RuntimeError:  # a pivot is zero, or rows were exchanged
            self._use_mixed(entries)
        self._entries = entries

    def assembled(self, entries: Array) -> Any:
        return self._whole.assembled(entries)

    def _use_mixed(self, entries: Array) -> None:
        self._mixed = self.was_mixed = True
        self._whole.factor(entries)

    # -- condensation ---------------------------------------------------------------------------------------------
    def _condense(self, A: Any) -> None:
        nf = self.nf
        K, low = csr_array(A[:nf, :nf]), csr_array(A[nf:])
        V, C = csr_array(low[:, :nf]), csr_array(low[:, nf:])
        if self._C is None or not np.array_equal(C.data, self._C):
            self._split(V, -C, K)
            self._C = C.data
        self._V = csr_array(V[self._elastic])
        self._SV = csr_array(self._S @ self._V)
        self._K = csr_array(K + self._V.T @ self._SV)
        self._bases(csr_array(V[self._constraints]))
        self.R = csr_array(self._NT @ self._K @ self.N)
        self.lu = _factors(self.R)

    def _split(self, V: Any, C: Any, K: Any) -> None:
        """Which rows are elastic, and which constraints, in groups that share unknowns, have a basis."""
        held = np.ones(len(V.indptr) - 1, bool)
        held[rows_of(C)[C.data != 0.0]] = False
        elastic, given = np.flatnonzero(~held), np.flatnonzero(held)
        S, self._positive = _inverted(C[elastic][:, elastic])
        Vc = csr_array(V[given])
        width = np.diff(Vc.indptr)
        if not width.all():
            raise SingularMatrixError("a constraint has no unknowns")
        pattern = csr_array((np.ones(len(Vc.indices)), Vc.indices, Vc.indptr), Vc.shape)
        count, label = connected_components(pattern @ pattern.T, directed=False)
        members = np.bincount(label, minlength=count)
        alone = np.flatnonzero(members[label] == 1)
        groups = []
        for w in np.unique(width[alone]):
            i = alone[width[alone] == w]
            groups.append((i[:, None], Vc.indices[Vc.indptr[i][:, None] + np.arange(w)]))
        same: dict[tuple[int, int], list[tuple[Index, Index]]] = {}
        sprung = [np.zeros(0, np.int64)]
        order, ends = np.argsort(label, kind="stable"), np.cumsum(members)
        for k in np.flatnonzero(members > 1):
            i = order[ends[k] - members[k] : ends[k]]
            j = np.unique(np.concatenate([Vc.indices[Vc.indptr[m] : Vc.indptr[m + 1]] for m in i]))
            if len(j) > LOCAL and (len(j) > LARGEST or len(j) - len(i) > LOCAL_MOTIONS):
                sprung.append(i)
            else:
                same.setdefault((len(i), len(j)), []).append((i, j))
        groups += [(np.array([i for i, _ in g]), np.array([j for _, j in g])) for g in same.values()]
        springs = np.sort(np.concatenate(sprung))
        kept = np.delete(np.arange(len(given)), springs)
        place = np.full(len(given), -1)
        place[kept] = np.arange(len(kept))
        self._groups = [(place[i], j) for i, j in groups]
        self._constraints, self._sprung = given[kept], given[springs]
        self.weights = _springs(csr_array(V[elastic]), S, csr_array(Vc[springs]), K)
        self._elastic = np.concatenate((elastic, self._sprung))
        self._S = csr_array(block_diag((S, diagonal(self.weights))))

    def _bases(self, V: Any) -> None:
        """N (nf, ...) and G = V_c^T (V_c V_c^T)^-1."""
        parts, inverses = [], []
        free, first = np.ones(self.nf, bool), 0
        for i, j in self._groups:
            k, r, c = len(i), i.shape[1], j.shape[1]
            free[j] = False
            Q, T = np.linalg.qr(_blocks(V, i, j).transpose(0, 2, 1), mode="complete")
            size = np.abs(np.einsum("kii->ki", T[:, :r]))
            if r > c or not (size.min(axis=1) > c * EPS * size.max(axis=1)).all():
                raise SingularMatrixError("constraints repeat each other")
            at = first + np.arange(k * (c - r)).reshape(k, c - r)
            parts.append(_places(j, at, Q[:, :, r:]))
            inverses.append(_places(j, i, np.matmul(Q[:, :, :r], np.linalg.inv(T[:, :r]).transpose(0, 2, 1))))
            first += k * (c - r)
        rest = np.flatnonzero(free)
        parts.append((rest, first + np.arange(len(rest)), np.ones(len(rest))))
        self.N = compressed_sum(parts, (self.nf, first + len(rest)))
        self._NT = csr_array(self.N.T)
        self._G = compressed_sum(inverses, (self.nf, V.shape[0]))

    @cached_property
    def pivots(self) -> Array:
        """D. SuperLU copies its factors to show them, so they are asked for where signs are."""
        return np.asarray(self.lu.U.diagonal())

    # -- solutions --------------------------------------------------------------------------------------------------
    def solve_transposed(self, b: Array) -> Array:
        return self.solve(b, True)

    def solve(self, b: Array, transposed: bool = False) -> Array:
        if not self._mixed:
            A = self.A.T if transposed else self.A
            z, error = refined(lambda right: self._direct(right, transposed), A, abs(A), np.asarray(b, float))
            if error <= SUFFICIENT:
                return z
            self._use_mixed(self._entries)  # the residual does not become rounding
        return self._whole.solve_transposed(b) if transposed else self._whole.solve(b)

    def displacement(self, force: Array, refined: bool = False) -> Array:
        """Without refinement where the condensation has lost less than LOST; every `solve` is refined."""
        if not self._mixed and self.lost < LOST:
            return np.asarray(self.N @ self.lu.solve(self._NT @ force))
        return super().displacement(force)

    @property
    def storage(self) -> str:
        mixed = "; where its factors were not accurate, the mixed matrix" if self.was_mixed else ""
        return f"condensed matrix{mixed}"

    def _direct(self, b: Array, transposed: bool = False) -> Array:
        """Not refined, with springs in the place of some constraints."""
        K = self._K.T if transposed else self._K
        f, e, c = b[: self.nf], b[self.nf + self._elastic], b[self.nf + self._constraints]
        f = f + self._SV.T @ e
        x = self._G @ c
        x = x + self.N @ self.lu.solve(self._NT @ (f - K @ x), "T" if transposed else "N")
        z = np.empty_like(b)
        z[: self.nf] = x
        z[self.nf + self._elastic] = self._S @ (self._V @ x - e)
        z[self.nf + self._constraints] = self._G.T @ (f - K @ x)
        return z

    def inverse_diagonal(self) -> Array | None:
        """(nf,) of the inverse; None: the matrix is not symmetric, there are too many springs, or the condensation has
        lost more than LOST."""
        if self._mixed or len(self._sprung) > MOST_SPRINGS or not self._symmetric() or not self.lost < LOST:
            return None
        from spacar.linear_systems.selected_inverse import selected_inverse

        pairs = csr_array(abs(self._NT) @ abs(self.N)) + abs(self.R)
        rows, place = rows_of(pairs), self.lu.perm_c
        Z = selected_inverse(self.lu.L, self.pivots, place[rows], place[pairs.indices])
        inverse = csr_array((Z, pairs.indices, pairs.indptr), pairs.shape)
        diagonal = np.asarray((csr_array(self.N @ inverse) * self.N).sum(axis=1)).ravel()
        if len(self._sprung):  # the inverse with springs, M^-1 - M^-1 E (diag(w) + F)^-1 E^T M^-1 without
            B, F = self._of_springs()
            diagonal -= np.sum(np.linalg.solve(np.diag(self.weights) + F, B.T).T * B, axis=1)
        return diagonal

    def _of_springs(self) -> tuple[Array, Array]:
        """Columns of the springs of the inverse with springs: their rows x (nf, t), and their own (t, t)."""
        unit = np.zeros((self.n, len(self._sprung)))
        unit[self.nf + self._sprung, np.arange(len(self._sprung))] = 1.0
        z = self._direct(unit)
        return z[: self.nf], z[self.nf + self._sprung]

    # -- signs --------------------------------------------------------------------------------------------------------
    def determinant_sign(self) -> float:
        if not self._mixed and len(self._sprung):
            negative = self.negative()
            if negative is not None:
                return -1.0 if negative % 2 else 1.0
            self._use_mixed(self._entries)
        if self._mixed:
            return self._whole.determinant_sign()
        negative = int(np.count_nonzero(self.pivots < 0.0)) + self._positive + len(self._constraints)
        return -1.0 if negative % 2 else 1.0

    def negative(self) -> int | None:
        """None where rounding may decide."""
        if self._mixed or not self._symmetric() or not self.lost < CLEAR:
            return None
        negative = int(np.count_nonzero(self.pivots < 0.0))
        springs = len(self._sprung)
        if negative and springs:
            if springs > MOST_SPRINGS:
                return None
            F = self._of_springs()[1] / self.weights
            negative -= int(np.count_nonzero(np.linalg.eigvalsh(np.eye(springs) + (F + F.T) / 2.0) < 0.0))
        return negative + self._positive + springs + len(self._constraints)

    def _symmetric(self) -> bool:
        difference = self.R - self.R.T
        return bool(np.abs(difference.data).max(initial=0.0) <= SYMMETRIC * np.abs(self.R.data).max(initial=0.0))

    @cached_property
    def lost(self) -> float:
        """Relative change of a solution along the eigenvector of the smallest eigenvalue in its first refinement: that
        part of this eigenvalue is rounding."""
        n = self.R.shape[0]
        if not n:
            return 0.0
        scale = np.sqrt(np.abs(self.R.diagonal()))
        if not scale.all():
            return np.inf
        u = (1.0 + np.arange(n) / max(n - 1.0, 1.0)) * np.where(np.arange(n) % 2, -1.0, 1.0)
        for _ in range(POWERS):
            u = scale * self.lu.solve(scale * u)
            size = float(np.linalg.norm(u))
            if not 0.0 < size < np.inf:
                return np.inf
            u /= size
        b = np.zeros(self.n)
        b[: self.nf] = self.N @ (scale * u)
        z = self._direct(b)
        change = self._NT @ self._direct(b - self.A @ z)[: self.nf]
        size = float(np.linalg.norm(scale * (self._NT @ z[: self.nf])))
        found = float(np.linalg.norm(scale * change))
        return found / size if 0.0 < size < np.inf else np.inf


def _factors(R: Any) -> Any:
    """Factors without exchanges. Raises RuntimeError where there are none."""
    A = narrow(csc_matrix, R.tocsc())
    lu = splu(A, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    if not np.array_equal(lu.perm_r, lu.perm_c):
        raise RuntimeError("rows were exchanged")
    return lu


def _inverted(C: Any) -> tuple[Any, int]:
    """Inverse of the block diagonal C, and how many of its eigenvalues are positive."""
    n = C.shape[0]
    label = connected_components(C, directed=False)[1] if n else np.zeros(0, np.int64)
    members = np.bincount(label)
    order, ends = np.argsort(label, kind="stable"), np.cumsum(members)
    parts, positive = [], 0
    for w in np.unique(members):
        i = order[(ends - members)[members == w][:, None] + np.arange(w)]
        block = _blocks(csr_array(C), i, i)
        positive += int(np.count_nonzero(np.linalg.eigvalsh(block) > 0.0))
        parts.append(_places(i, i, np.linalg.inv(block)))
    return compressed_sum(parts, (n, n)), positive


def _blocks(A: Any, i: Index, j: Index) -> Array:
    """Dense parts (k, r, c) of A in compressed rows: block m has the rows i[m] (r,) and the columns j[m] (c,), in which
    all entries of these rows are."""
    k, r, c = len(i), i.shape[1], j.shape[1]
    block, row, column = (np.full(A.shape[axis], -1) for axis in (0, 0, 1))
    block[i], row[i], column[j] = np.arange(k)[:, None], np.arange(r), np.arange(c)
    rows = rows_of(A)
    part = np.flatnonzero(block[rows] >= 0)
    at = (block[rows[part]] * r + row[rows[part]]) * c + column[A.indices[part]]
    return np.bincount(at, A.data[part], k * r * c).reshape(k, r, c)


def _places(i: Index, j: Index, blocks: Array) -> tuple[Index, Index, Array]:
    """Rows, columns and values of blocks (k, r, c) in the rows i (k, r) and the columns j (k, c)."""
    return (
        np.broadcast_to(i[:, :, None], blocks.shape).ravel(), np.broadcast_to(j[:, None, :], blocks.shape).ravel(),
        blocks.ravel(),
    )  # fmt: skip


def _springs(Ve: Any, S: Any, Vp: Any, K: Any) -> Array:
    """SPRING times the largest stiffness that the constraints of Vp meet, for each of them."""
    if not Vp.shape[0]:
        return np.zeros(0)
    stiffness = np.abs((K + Ve.T @ (S @ Ve)).diagonal())[Vp.indices]
    size = np.abs(Vp.data)
    large = size > 1e-3 * size.max()
    ratio = stiffness[large] / size[large] ** 2
    return np.full(Vp.shape[0], SPRING * (float(ratio.max(initial=0.0)) or 1.0))
