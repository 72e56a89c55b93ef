"""Inertia of a symmetric sparse matrix: how many of its eigenvalues are negative, and how many are zero.

Sylvester: a congruence keeps the signs. In reverse Cuthill-McKee order the matrix is block tridiagonal; the blocks are
eliminated one after the other, A_k+1 - B^T S_k^-1 B, and the inertia is the sum over the Schur complements S_k. Cost:
linear in the number of unknowns, n times the square of the bandwidth.

A Schur complement may be singular although the matrix is not: a constraint that comes before its coordinates, the part
of a chain before its support. So it is first tried with S = L D L^T (Bunch-Kaufman), in either order; a chain held at
one end is regular from there. Where S^-1 blows up what it adds to the next block, both are refused, and every S is
diagonalized by an orthogonal transformation, ten times as dear. A direction with eigenvalue s and coupling b to the
next block is eliminated if b^T b / |s| is not large; else it is handed on to the next block (a delayed pivot), except
where s and b are rounding: such a direction is an eigenvector with the eigenvalue zero and is counted at once, so that
no more directions wait than a block has columns. What is left behind the last block is zero too.
"""

import numpy as np

from spacar.arrays import EPS, Array, Index

SINGLE = 60  # unknowns up to which one block is faster
SMALLEST_BLOCK = 16  # unknowns; below, the call of the eigenvalue solver costs more than its work
FACTORED_BLOCK = 48  # the same for L D L^T
EQUILIBRATIONS = 3  # passes; rows and columns are then within a factor of two of size one
GROWTH = 10.0  # of the entries (of size one) in one elimination: one of their digits is lost at most
CLEAR = float(np.sqrt(EPS))  # pivots above it have their sign whatever rounding does


class Inertia:
    """Counts for matrices of order n with entries at (rows, columns); repeated ones add up. Ordered once.

    `rank` (n,): a symmetric order with a narrow band, if known.
    """

    def __init__(self, n: int, rows: Index, columns: Index, rank: Index | None = None) -> None:
        self.n, self.rows, self.columns = n, rows, columns
        if n <= SINGLE:
            return
        from spacar.linear_systems.ordering import bandwidths, order

        self._rank = order(n, rows, columns)[0] if rank is None else rank
        self._bandwidth = max(bandwidths(self._rank[rows], self._rank[columns]))
        self._backwards = False

    def __call__(self, entries: Array) -> tuple[int, int]:
        """Negative and zero eigenvalues.

        The matrix is scaled to rows of size one first. Zero then means below n eps, the size that rounding gives a zero
        eigenvalue.
        """
        n = self.n
        if n == 0:
            return 0, 0
        values = self._equilibrated(entries)
        if n <= SINGLE:
            A = np.bincount(self.rows * n + self.columns, values, n * n).reshape(n, n)
            spectrum = np.linalg.eigvalsh((A + A.T) / 2.0)
            zero = n * EPS
            return int(np.sum(spectrum < -zero)), int(np.sum(np.abs(spectrum) <= zero))
        for backwards in (self._backwards, not self._backwards):
            negative = _by_factors(n, self._blocks(values, backwards, FACTORED_BLOCK))
            if negative is not None:
                self._backwards = backwards
                return negative, 0
        return _by_spectra(n, self._blocks(values, False, SMALLEST_BLOCK))

    def _equilibrated(self, entries: Array) -> Array:
        """D A D with rows of size about one (D. Ruiz, Rutherford Appleton Laboratory, RAL-TR-2001-034)."""
        values = entries
        for _ in range(EQUILIBRATIONS):
            size = np.zeros(self.n)
            np.maximum.at(size, self.rows, np.abs(values))
            d = 1.0 / np.sqrt(np.where(size > 0.0, size, 1.0))
            values = values * d[self.rows] * d[self.columns]
        return values

    def _blocks(self, values: Array, backwards: bool, smallest: int) -> Array:
        """(count, width, 2 width): every diagonal block and the one to its right, side by side."""
        width = max(smallest, self._bandwidth)
        rank = self.n - 1 - self._rank if backwards else self._rank
        i, j = rank[self.rows], rank[self.columns]
        block, count = i // width, -(-self.n // width)
        upper = j // width >= block
        flat = (i * 2 * width + (j - block * width))[upper]
        return np.bincount(flat, values[upper], count * 2 * width * width).reshape(count, width, 2 * width)


def _by_factors(n: int, blocks: Array) -> int | None:
    """Negative eigenvalues; None where a Schur complement is nearly singular."""
    from scipy.linalg.lapack import dsysv

    negative, width = 0, blocks.shape[1]
    update = np.zeros((width, width))
    for k, block in enumerate(blocks):
        m = min(width, n - k * width)
        coupling = block[:m, width:]
        columns = np.flatnonzero(coupling.any(axis=0))
        b = coupling[:, columns]
        S = block[:m, :m] - update[:m, :m]
        factor, pivots, x, info = dsysv(S, b if len(columns) else coupling[:, :1], lower=1)
        signs = _signs(factor, pivots) if info == 0 else None
        if signs is None:
            return None
        change = b.T @ x[:, : len(columns)]
        if not np.max(np.abs(change), initial=0.0) <= GROWTH:
            return None
        negative += signs
        update = np.zeros((width, width))
        update[columns[:, None], columns] = change
    return negative


def _signs(factor: Array, pivots: Index) -> int | None:
    """Negative eigenvalues of D, which has blocks of one or two; None if a pivot may be rounding.

    Blocks of two are indefinite: Bunch and Kaufman take them where the diagonal is small beside the other entry.
    """
    d = np.diagonal(factor)
    single = pivots > 0
    if not np.min(np.abs(d[single]), initial=1.0) > CLEAR:
        return None
    first = np.flatnonzero(~single)[::2]
    other = factor[first + 1, first]
    if not np.min(np.abs(other), initial=1.0) > CLEAR:
        return None
    return int(np.count_nonzero(d[single] < 0.0)) + len(first)


def _by_spectra(n: int, blocks: Array) -> tuple[int, int]:
    """Negative and zero eigenvalues, with directions that wait."""
    width = blocks.shape[1]
    negative, uncoupled, zero = 0, 0, n * EPS
    waiting, waiting_coupling = np.zeros(0), np.zeros((0, width))
    update = np.zeros((width, width))
    for k, block in enumerate(blocks):
        w, m = len(waiting), min(width, n - k * width)
        S = np.zeros((w + m, w + m))
        S[w:, w:] = block[:m, :m] - update[:m, :m]
        if w:
            S.flat[: w * (w + m) : w + m + 1] = waiting
            S[w:, :w] = waiting_coupling[:, :m].T
        spectrum, Q = np.linalg.eigh(S)  # of the lower triangle
        size = np.abs(spectrum)
        coupling = Q[w:].T @ block[:m, width:]
        zero = max(zero, n * EPS * float(size.max()))
        taken = (size > zero) & (np.einsum("ij,ij->i", coupling, coupling) <= GROWTH * size)
        negative += int(np.count_nonzero(spectrum[taken] < 0.0))
        B = coupling[taken]
        update = B.T @ (B / spectrum[taken, None])
        waiting, waiting_coupling = spectrum[~taken], coupling[~taken]
        small = np.abs(waiting) <= zero
        if small.any():  # any combination of these is as good: those that are coupled apart from the others
            U, s, _ = np.linalg.svd(waiting_coupling[small])
            coupled = int(np.sum(s > zero))
            uncoupled += len(U) - coupled
            waiting = np.concatenate((waiting[~small], np.zeros(coupled)))
            waiting_coupling = np.vstack((waiting_coupling[~small], U[:, :coupled].T @ waiting_coupling[small]))
    return negative, len(waiting) + uncoupled
