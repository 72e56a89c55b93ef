"""Eigenvalues of the linearized system (mode 7; theory-system.md 6.4).

Eigenvalues of the state matrix A of (15). Without damping and gyroscopic terms and with symmetric K, M the symmetric
problem K phi = omega^2 M phi is solved instead (more accurate, and repeated values keep full sets of vectors):
lambda = +-i omega, or +-sqrt(-omega^2) for an unstable mode. Eigenvectors are those of the state (ds, dqd), of
Euclidean norm 1, with a real largest position component. Order: decreasing modulus, conjugates together, positive
imaginary part first.

Every returned pair is checked (`spacar.linear.backward_error`); a doubtful one is kept, with a warning.
"""

from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import EPS, Array, Complex, Index
from spacar.errors import AnalysisError, Report
from spacar.linear import backward_error
from spacar.linear.graded import TEN_DIGITS, Factors, eigenvalues, graded_modes, keeps_digits
from spacar.linear_systems import DENSE_LIMIT
from spacar.linearization.matrices import MASSLESS, Linearization, assembled_state_matrix, require_mass, scaled_solution

FindFactors = Callable[[], Factors | None]
SYMMETRIC = 1e-9  # relative asymmetry below which a matrix counts as symmetric (rounding of assembled sums)
POLISHED = 1e-2  # modes with omega^2 below this fraction of the largest are improved; the others have n eps/POLISHED
FEW = 4  # one mode in so many, or fewer: those are computed alone
BESIDE = 4  # modes more than are wanted, which take the rest of themselves out of the vectors of the others
ROUNDING = 1e-12  # omega^2 below this fraction of the largest may be rigid motions
SPREAD = 1e-5  # of omega^2, from which on the entries of K have too few digits for the lowest
SINGULAR = 1e3  # of M, row and column scaled, from which on its entries have too few digits for the highest
MOST_GRADED = 200  # degrees of freedom: 60 ms


class Modes(NamedTuple):
    """values (n,), vectors (n_state, n): eigenvalues [rad/s] and state eigenvectors; n_positions rows are positions.

    motions (nx, n): displacements of the coordinates, where they are computed without transfer functions.
    """

    values: Complex
    vectors: Complex
    n_positions: int
    motions: Complex | None = None

    def stored(self, motions: bool) -> dict[str, Array]:
        """eigval, eigvre, eigvim; with the motions eigxre and eigxim."""
        found = {"eigval": np.column_stack((self.values.real, self.values.imag))}
        for name, vectors in (("eigv", self.vectors), ("eigx", self.motions if motions else None)):
            if vectors is not None:
                found |= {f"{name}re": vectors.real, f"{name}im": vectors.imag}
        return found

    def lowest(self, pairs: int) -> "Modes":
        """The last `pairs` pairs, conjugates never divided."""
        first = max(len(self.values) - 2 * pairs, 0)
        if first and self.values[first].imag < 0.0 and self.values[first - 1] == self.values[first].conj():
            first -= 1
        return Modes(self.values[first:], self.vectors[:, first:], self.n_positions)


def is_regular(K: Array) -> bool:
    """Is the symmetric part of a stiffness definite to ten digits? Then no eigenvalue is zero."""
    return keeps_digits(0.5 * (K + K.T))


def is_zero(values: Complex, K: Array) -> NDArray[np.bool_]:
    """Below sqrt(eps) times the largest modulus: a multiple zero eigenvalue cannot be computed more accurately.
    Values of a regular stiffness (n, n) may be as low beside a motion of hardly any mass; none of them is zero."""
    largest = 0.0 if is_regular(K) else float(np.max(np.abs(values), initial=0.0))
    return np.asarray(np.abs(values) <= np.sqrt(EPS) * largest)


def arranged(values: Complex, vectors: Complex, n_positions: int, motions: Complex | None = None) -> Modes:
    """Norm 1, real largest position component, decreasing modulus, conjugates together; motions (nx, n) alike. What
    belongs to values that are nan is nan."""
    n, every = len(vectors), vectors if motions is None else np.vstack((vectors, motions))
    every = every / np.linalg.norm(vectors, axis=0)
    if n_positions:
        largest = np.argmax(np.abs(every[:n_positions]), axis=0)
        pivot = every[largest, np.arange(len(values))]
        every *= np.where(pivot != 0.0, np.abs(pivot) / np.where(pivot != 0.0, pivot, 1.0), 1.0)
    every[:, np.isnan(values)] = np.nan
    modulus = np.abs(values)
    # conjugates have equal moduli up to rounding: compare with fewer digits, then by imaginary part
    size = 10.0 ** np.floor(np.log10(np.where(modulus > 0.0, modulus, 1.0)))
    rounded = np.round(modulus / size, 10) * size
    order = np.lexsort((-values.imag, -np.abs(values.imag), -rounded))
    every = every[:, order]
    return Modes(values[order], every[:n], n_positions, None if motions is None else every[n:])


def vibration_modes(
    L: Linearization, q: Index, s: Index, report: Report, static: Index | None = None, wanted: int | None = None,
) -> Modes:  # fmt: skip
    """Eigenvalues and eigenvectors about the linearization point for the rows q, s (see chosen_rows): all, or at least
    the `wanted` pairs of lowest modulus.

    `static` are degrees of freedom that may have no inertia: those without mass and damping follow the others by
    K alone, and only the finite eigenvalues are returned (theory-warping.md section 1).
    """
    M, C, K, ak0, bk0 = L.chosen(q, s)
    if static is not None and len(static) and np.array_equal(q, s):
        still = np.isin(q, static) & ~M.any(axis=1) & ~C.any(axis=1) & ~C.any(axis=0)
        if still.any():
            return _condensed(M, C, K, still, report)
    require_mass(L, q)
    return modes_of_matrices(M, C, K, ak0, bk0, report, wanted, lambda: Factors.of_linearization(L, q))


def _condensed(M: Array, C: Array, K: Array, still: NDArray[np.bool_], report: Report) -> Modes:
    """The finite modes when the rows `still` of M and C are zero: there K q = 0 gives q = T q_moving."""
    moving, still_ = np.flatnonzero(~still), np.flatnonzero(still)
    T = np.zeros((len(K), len(moving)))
    T[moving] = np.eye(len(moving))
    held = K[np.ix_(still_, still_)]
    scale = np.sqrt(np.abs(np.diag(held)))
    if not (scale > 0.0).all():
        text = "a twist rate has neither inertia nor stiffness: FIX its warping node, or add EM or ESTIFF"
        raise AnalysisError(text, "dynamics.singular-mass")
    T[still_] = -np.linalg.solve(held / np.outer(scale, scale), K[np.ix_(still_, moving)] / scale[:, None])
    T[still_] /= scale[:, None]
    n = len(moving)
    full = K[moving] @ T
    if is_symmetric(K):
        full = 0.5 * (full + full.T)  # rounding of the elimination
    block, rest = np.ix_(moving, moving), np.zeros((n, n))
    modes = modes_of_matrices(M[block], C[block], full, np.eye(n), rest, report)
    vectors = np.vstack((T @ modes.vectors[:n], T @ modes.vectors[n:]))
    return arranged(modes.values, vectors, len(K))


def modes_of_matrices(
    M: Array, C: Array, K: Array, ak0: Array, bk0: Array, report: Report, wanted: int | None = None,
    factors: FindFactors | None = None,
) -> Modes:  # fmt: skip
    """The same from M, C (q, q), K (q, s) and the kinematic matrices ak0 (s, q), bk0 (s, s).

    Raises AnalysisError for a singular or indefinite mass matrix.
    """
    if K.shape[0] == K.shape[1] and is_symmetric(K) and is_symmetric(M):
        if matters(C, M, K):
            return damped_modes(K, C, M, report, factors)
        return undamped_modes(K, M, report, wanted, factors)
    values, vectors = _eig(assembled_state_matrix(M, C, K, ak0, bk0), report)
    if K.shape[0] == K.shape[1] and np.array_equal(ak0, np.eye(len(K))) and not bk0.any():
        values, vectors = _with_low_modes_of_the_inverse(M, C, K, values, vectors)
    return arranged(values, vectors, K.shape[1])


def _with_low_modes_of_the_inverse(
    M: Array, C: Array, K: Array, values: Complex, vectors: Complex
) -> tuple[Complex, Complex]:
    """The same, the lower half from the inverse [-K^-1 C, -K^-1 M; 1, 0] of the state matrix, with the values 1/lambda.

    Each computation leaves an error of eps times its largest value squared in all squares: relative to lambda eps
    (|lambda|max/|lambda|)^2/2 and eps (|lambda|/|lambda|min)^2/2, which are equal at the geometric mean of both ends.
    The lowest value comes from the inverse as well: of a spread beyond 1/sqrt(eps) the state matrix has no digit of it.
    Left alone where K is singular to rounding.
    """
    size = np.abs(values)
    high, low = size.max(initial=0.0), size.min(initial=np.inf)
    if not low**2 < POLISHED * high**2 or not (low**2 > ROUNDING * high**2 or is_regular(K)):
        return values, vectors
    n = len(K)
    d = 1.0 / np.sqrt(np.abs(np.diag(K)) + low**2 * np.diag(M))
    inverse = np.zeros((2 * n, 2 * n))
    try:
        inverse[:n] = -scaled_solution(K, np.hstack((C, M)), d)
    except np.linalg.LinAlgError:
        return values, vectors
    inverse[n:, :n] = np.eye(n)
    pairs: tuple[Complex, Complex] = np.linalg.eig(inverse)
    reciprocal, shapes = pairs
    ascending = np.argsort(size, kind="stable")
    first = np.argsort(-np.abs(reciprocal), kind="stable")
    found = np.abs(reciprocal[first])
    count = int(np.sum(found > np.sqrt(found[0] / high)))
    same = 1.0 - np.sqrt(EPS)
    while 0 < count < 2 * n and found[count] > same * found[count - 1]:
        count -= 1  # a pair stays together
    kept: Complex = np.concatenate((1.0 / reciprocal[first[:count]], values[ascending[count:]]))
    return kept, np.hstack((shapes[:, first[:count]], vectors[:, ascending[count:]]))


def damped_modes(K: Array, C: Array, M: Array, report: Report, factors: FindFactors | None = None) -> Modes:
    """Modes of M qdd + C qd + K q = 0, K symmetric, in the coordinates of the undamped modes.

    With q = Phi p, Phi^T M Phi = 1, Phi^T K Phi = Omega^2 the state (w p, pd), w = |Omega| (1 where Omega = 0), has
    the graded matrix [0 w; -Omega^2/w -Phi^T C Phi], from the highest to the lowest mode: low modes keep their
    relative accuracy.
    """
    squares, Phi = accurate(K, M, factors)
    order = np.argsort(-np.abs(squares), kind="stable")
    squares, Phi = squares[order], Phi[:, order]
    w = np.sqrt(np.abs(squares))
    w = np.where(w > np.sqrt(ROUNDING) * w.max(initial=0.0), w, w[w > 0.0].min(initial=1.0))
    n = len(K)
    A = np.zeros((2 * n, 2 * n))
    pairs = np.arange(n)
    A[2 * pairs, 2 * pairs + 1], A[2 * pairs + 1, 2 * pairs] = w, -squares / w
    A[1::2, 1::2] = -Phi.T @ C @ Phi
    values, z = _eig(A, report)
    vectors = np.vstack((Phi @ (z[0::2] / w[:, None]), Phi @ z[1::2]))
    found = eigenvalues(values, vectors[:n], M, C, K, squares, Phi)
    if found is not None:
        values, shapes, lost = found
        vectors = np.vstack((shapes, shapes * values))
        if lost.any():
            size = np.abs(values[lost]).max()
            report.add(
                f"warning: masses, dampers and springs differ so much that {int(lost.sum())} eigenvalues, up to"
                f" {size:.3g} rad/s, are known to fewer than ten digits; other degrees of freedom (DYNX, DYNE) may help"
            )
    return arranged(values, vectors, n)


def _eig(A: Array, report: Report) -> tuple[Complex, Complex]:
    """Eigenvalues and eigenvectors of a state matrix, and a warning about doubtful ones."""
    if not np.isfinite(A).all():
        text = "the linearized equations overflow: masses, stiffnesses or rates differ by too many orders of magnitude"
        raise AnalysisError(text, "linear.overflow")
    values, vectors = np.linalg.eig(A)
    eta = backward_error.of_matrix(A, values, vectors)
    if eta.max(initial=0.0) > backward_error.rounding(len(A)):
        # balancing has blown up the rounding of structural zeros: the QZ algorithm does not balance
        from scipy.linalg import eig

        other = eig(A, np.eye(len(A)))
        eta_other = backward_error.of_matrix(A, *other)
        if eta_other.max() < eta.max():
            (values, vectors), eta = other, eta_other
    backward_error.warn(report, eta, values, "eigenvalues")
    return values, vectors


def undamped_modes(
    K: Array, M: Array, report: Report, wanted: int | None = None, factors: FindFactors | None = None
) -> Modes:
    """Modes of M qdd + K q = 0 from the symmetric eigenproblem, all or the `wanted` of lowest modulus. Raises
    AnalysisError for an indefinite mass matrix."""
    squares, shapes = accurate(K, M, factors, wanted)
    if wanted is not None and wanted < len(squares):
        lowest = np.abs(squares).argsort(kind="stable")[:wanted]
        lowest.sort()
        squares, shapes = squares[lowest], shapes[:, lowest]
    eta = backward_error.of_pencil(K, M, squares, shapes, 1.0 / np.sqrt(M.diagonal()))
    backward_error.warn(report, eta, squares, "omega^2", backward_error.rounding(len(K)))
    values, shapes = both_of(squares, shapes)
    return arranged(values, np.vstack((shapes, shapes * values)), len(K))


def both_of(squares: Array, shapes: Array) -> tuple[Complex, Complex]:
    """The eigenvalues +-i omega, or +-kappa of an unstable mode, of every omega^2 (n,), and their shapes (., 2 n)."""
    root = np.sqrt(squares.astype(complex))
    return np.concatenate((1j * root, -1j * root)), np.hstack((shapes, shapes)).astype(complex)


def symmetric_pencil(K: Array, M: Array, wanted: int | None = None) -> tuple[Array, Array]:
    """omega^2 (n,) ascending and vectors (n, n) of K phi = omega^2 M phi, M positive definite; of few `wanted` these
    and some more, if none of them is negative."""
    diagonal = np.diag(M)
    if np.any(diagonal <= 0.0):
        raise AnalysisError(MASSLESS, "dynamics.singular-mass")
    scale = 1.0 / np.sqrt(diagonal)
    product = scale[:, None] * scale
    try:
        squares, vectors = _pencil(K * product, M * product, wanted)
    except np.linalg.LinAlgError:
        raise AnalysisError(
            "the mass matrix is not positive definite; a motion carries no mass", "dynamics.singular-mass"
        ) from None
    return squares, vectors * scale[:, None]


def _pencil(K: Array, M: Array, wanted: int | None = None) -> tuple[Array, Array]:
    """omega^2 ascending and vectors, M of unit diagonal. Larger ones, for which SciPy is loaded anyway, take half of
    the time of NumPy, and the few lowest a third of that; where its routines fail NumPy decides. Raises LinAlgError
    when M is not positive definite."""
    n = len(K)
    if n > DENSE_LIMIT:
        from scipy.linalg import eigh

        with suppress(np.linalg.LinAlgError):
            if wanted is not None and wanted * FEW <= n:
                squares, vectors = eigh(K, M, subset_by_index=(0, wanted + BESIDE - 1), check_finite=False)
                # None of a matrix with nan; with a negative one those of lowest modulus may not be among them.
                if (squares[:1] >= 0.0).any():
                    return squares, vectors
            found: tuple[Array, Array] = eigh(K, M, check_finite=False)
            return found
    return by_factor(K, np.linalg.cholesky(M))


def by_factor(A: Array, lower: Array) -> tuple[Array, Array]:
    """lambda ascending and vectors v of A v = lambda L L^T v with A symmetric, L = `lower` triangular."""
    reduced = np.linalg.solve(lower, np.linalg.solve(lower, A).T)
    values, vectors = np.linalg.eigh((reduced + reduced.T) / 2)
    return values, np.linalg.solve(lower.T, vectors)


def accurate(K: Array, M: Array, factors: FindFactors | None = None, wanted: int | None = None) -> tuple[Array, Array]:
    """omega^2 ascending and vectors, as `symmetric_pencil` gives them, polished; by `graded` where that would
    not give ten digits. Raises AnalysisError for a singular mass matrix."""
    n = len(K)
    try:
        pairs = symmetric_pencil(K, M, wanted)
    except AnalysisError:
        found = factors() if factors is not None and n <= MOST_GRADED else None
        graded = None if found is None else graded_modes(found, K)
        if graded is None:
            raise
        return graded
    squares, shapes = polished(K, M, *pairs)
    if n > MOST_GRADED or not n or _has_ten_digits(K, M, squares, shapes):
        return squares, shapes
    found = (None if factors is None else factors()) or Factors.of_matrices(K, M)
    return (None if found is None else graded_modes(found, K)) or (squares, shapes)


def _has_ten_digits(K: Array, M: Array, squares: Array, shapes: Array) -> bool:
    """Are polished modes known to ten digits? Not where M is nearly singular, so that the highest are far above
    K_ii/M_ii. Low ones far below the highest are where K, row and column scaled, keeps its digits in a factorization
    and the entries of M give phi^T M phi = 1 without cancellation."""
    expected = float(np.max(np.abs(K.diagonal()) / M.diagonal()))
    largest = max(float(np.max(np.abs(squares))), expected)
    if largest > SINGULAR * expected:
        return False
    low = np.abs(squares) <= SPREAD * largest
    if not low.any():
        return True
    if squares.min() <= ROUNDING * largest or not keeps_digits(K):
        return False
    sizes = np.abs(shapes[:, low])
    return bool(EPS * (sizes * (np.abs(M) @ sizes)).sum(axis=0).max() <= TEN_DIGITS)


def polished(K: Array, M: Array, squares: Array, shapes: Array) -> tuple[Array, Array]:
    """The same with accurate low modes: one step of inverse iteration and a Rayleigh-Ritz projection.

    The reduction to a standard problem leaves an error of eps times the largest omega^2 in all of them. For the low
    ones X, with F = M X and Y = Q^-1 F of the shifted matrix Q = K + s^2 M, the projected problem (Y^T M Y) c = theta
    (F^T Y) c has theta = 1/(omega^2 + s^2) with small relative errors: K itself is not multiplied. Left alone where
    it does not apply (an unstable mode that is not among the low ones).
    """
    size = np.abs(squares)
    largest = float(size.max(initial=0.0))
    if len(squares) < len(K):  # the largest is not among them, but at least this
        largest = max(largest, float(np.max(K.diagonal() / M.diagonal())))
    low = (size < POLISHED * largest).nonzero()[0]
    if not len(low):
        return squares, shapes
    positive = squares[squares > ROUNDING * largest]
    s2 = 1e-3 * float(positive[0]) if len(positive) else POLISHED * largest
    s2 = max(s2, -2.0 * float(squares[low[0]]))  # unstable modes have theta > 0 too
    Q = K + s2 * M
    d = 1.0 / np.sqrt(np.maximum(np.abs(K.diagonal()) + s2 * M.diagonal(), 1e-300))
    F = M @ shapes[:, low]
    try:
        Y = scaled_solution(Q, F, d)
        size = np.sqrt(np.abs(squares[low]) + s2)
        Y, F = Y * size, F * size
        energy, work = F.T @ Y, Y.T @ (M @ Y)
        lower = np.linalg.cholesky((energy + energy.T) / 2)
    except np.linalg.LinAlgError:  # unstable or exactly singular
        return squares, shapes
    theta, c = by_factor((work + work.T) / 2, lower)
    if not (theta > 0.0).all():
        return squares, shapes
    vectors = Y @ c / np.sqrt(theta)  # Y^T M Y -> 1
    squares, shapes = squares.copy(), shapes.copy()
    squares[low], shapes[:, low] = (1.0 / theta - s2)[::-1], vectors[:, ::-1]
    return squares, shapes


def is_symmetric(A: Array) -> bool:
    """Symmetric to rounding, row and column scaled so that units do not matter."""
    d = np.sqrt(np.abs(A.diagonal()))
    scale = np.where(d > 0.0, d, d.max(initial=0.0))
    if not scale.any():
        return not A.any() or bool(np.allclose(A, A.T, rtol=SYMMETRIC, atol=0.0))
    S = A / np.outer(scale, scale)
    difference = float(np.abs(S - S.T).max())
    return difference <= SYMMETRIC or difference <= SYMMETRIC * float(np.abs(S).max())


def matters(C: Array, M: Array, K: Array) -> bool:
    """Is C more than the rounding of zero, compared with sqrt(m k) of its row and column?"""
    if not C.any():
        return False
    size = np.sqrt(np.sqrt(np.abs(np.diag(M) * np.diag(K))))
    bound = 1e-14 * np.outer(size, size)
    return bool(np.any(np.abs(C) > bound))
