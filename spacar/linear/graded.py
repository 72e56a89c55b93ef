"""Modes of small systems whose frequencies lie many orders of magnitude apart, each to full relative accuracy.

K = A^T A + G and M = B^T B with the factors A = S^(1/2) We and B = M_x^(1/2) W that elements and nodes give: sums like
k1 + k2, in which the smaller number is lost, are not formed. With the triangular R of B (columns scaled, rows sorted,
pivots: Cox and Higham 1998) the frequencies without G are the singular values of X = A R^-1. Their error is eps times
the largest one, and that of Jacobi's method (LAPACK's dgejsv; Drmac and Veselic, SIAM J. Matrix Anal. Appl. 29, 2008)
eps times each, as far as X is well conditioned but for the sizes of its rows and columns. The remainder G (geometric
stiffness, gravity) is added in these modes: H = diag(sigma^2) + G is factored by Cholesky's method with unit diagonal,
moved by s^2 where it is not definite, and its modes are the singular values of the factor.

With damping, eigenvalues of P(z) = z^2 M + z C + K that are small beside the largest, which the QR algorithm knows to
eps times the largest only, come from Aberth's iteration z -= N/(1 - N sum 1/(z - z_j)), N = 1/trace(P^-1 P'), that
begins at those of QR, or at the roots of every undamped mode or coordinate alone (Bini and Noferini, Linear Algebra
Appl. 439, 2013). Its limit is the rounding of P, row and column scaled, at z itself.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import EPS, Array, Complex, Index
from spacar.linear_systems.linear_system import dense
from spacar.linearization.matrices import Linearization

SAME = 1e-12  # part of the sum of sizes by which factors may differ from the matrix that they stand for
JACOBI = 2e-6  # ratio of singular values below which those of NumPy have fewer than ten digits
SORTED = 1e-3  # ratio of the diagonal of R below which rows are sorted and columns exchanged
SMALL = 1e-5  # part of the largest eigenvalue below which others have fewer than ten digits
MOST = 400  # iterations: from starts many orders of magnitude away; the last digits take few
RIGID = 1e-29  # part of the largest omega^2 below which a motion has no stiffness: the square of what rounding leaves
SUFFICIENT = 1e-11  # relative correction that ends them; ROUGH: where rounding of the entries allows no less
ROUGH = 1e-6
TEN_DIGITS = 1e-10
MANY, WORK = 40, 1e8  # degrees of freedom; eigenvalues times n^3: all of MANY (80 ms) are 5e6


class Factors(NamedTuple):
    """A (m, n) and B (k, n) of K = A^T A + G, M = B^T B for the degrees of freedom q."""

    A: Array
    B: Array

    @classmethod
    def of_linearization(cls, L: Linearization, q: Index) -> "Factors | None":
        """None where stiffness or mass contain more than elements and nodes give, or one is not definite."""
        A, B = factor(dense(L.c.S)), factor(dense(L.c.M))
        if A is None or B is None:
            return None
        A, B = A @ L.We[:, q], B @ L.W[:, q]
        same = _is_product(A, L.k0[np.ix_(q, q)]) and _is_product(B, L.m0[np.ix_(q, q)])
        return cls(A, B) if same else None

    @classmethod
    def of_matrices(cls, K: Array, M: Array) -> "Factors | None":
        """Factors of the matrices themselves; a K that is not definite is all remainder."""
        A, B = factor(K, falling(K, M)), factor(M)
        return None if B is None else cls(np.zeros((0, len(M))) if A is None else A, B)


def falling(K: Array, M: Array) -> Index:
    """The order of falling K_ii/M_ii: triangular factors of both then grade X by rows."""
    return np.argsort(-np.abs(K.diagonal()) / M.diagonal(), kind="stable")


def factor(S: Array, order: Index | None = None) -> Array | None:
    """F (m, n) with F^T F = S, of a symmetric semidefinite S (n, n); None if it is not. Rows and columns are scaled.
    Triangular in this order of the columns."""
    n = len(S)
    d = np.sqrt(np.abs(S.diagonal()))
    own = np.flatnonzero(d) if order is None else order[d[order] > 0.0]
    if (S.diagonal() < 0.0).any() or np.abs(S - S.T).max(initial=0.0) > SAME * max(d.max(initial=0.0) ** 2, 0.0):
        return None
    if len(own) < n and (S[d == 0.0].any() or S[:, d == 0.0].any()):
        return None
    unit = S[np.ix_(own, own)] / np.outer(d[own], d[own])
    try:
        rows = np.linalg.cholesky(unit).T
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(unit)
        if (values < -64.0 * n * EPS).any():
            return None
        rows = (vectors * np.sqrt(np.maximum(values, 0.0))).T
    F = np.zeros((len(own), n))
    F[:, own] = rows * d[own]
    return F


def _is_product(A: Array, S: Array) -> bool:
    return bool((np.abs(A.T @ A - S) <= SAME * (np.abs(A).T @ np.abs(A)) + 1e-300).all())


def graded_modes(factors: Factors, K: Array) -> tuple[Array, Array] | None:
    """omega^2 (n,) ascending and shapes (n, n) with Phi^T M Phi = 1, K (n, n) symmetric. None where M is singular."""
    (A, B), n = factors, len(K)
    size = np.sqrt(np.einsum("ij,ij->j", B, B))
    if len(B) < n or not (size > 0.0).all():
        return None
    R, order = _triangular(B / size, falling(K, B.T @ B))
    if not (np.abs(R.diagonal()) > 0.0).all():
        return None
    size = size[order]
    G = (K - A.T @ A)[np.ix_(order, order)]
    known = np.abs(A).T @ np.abs(A)
    rounding = 16.0 * EPS * (known + np.abs(K))[np.ix_(order, order)]
    rest = np.where(np.abs(G) <= rounding, 0.0, G) / np.outer(size, size)
    sigma, V = singular(_right_divided(A[:, order] / size, R))
    squares, inner = sigma * sigma, V
    if rest.any():
        turned = _right_divided(_right_divided(rest, R).T, R)
        found = _with_remainder(squares, V.T @ (0.5 * (turned + turned.T)) @ V)
        if found is None:
            return None
        squares, inner = found[0], V @ found[1]
    shapes = np.zeros((n, n))
    shapes[order] = np.linalg.solve(R, inner) / size[:, None]
    ascending = np.argsort(squares, kind="stable")
    return squares[ascending], shapes[:, ascending]


def _triangular(B: Array, order: Index) -> tuple[Array, Index]:
    """R (n, n) of the columns of B = Q R, in this order unless B is ill conditioned, and the order."""
    R = np.asarray(np.linalg.qr(B[:, order], mode="r"))
    d = np.abs(R.diagonal())
    if d.min() > SORTED * d.max():
        return R, order
    from scipy.linalg import qr

    rows = np.argsort(-np.abs(B).max(axis=1), kind="stable")
    R, order = qr(B[rows], mode="r", pivoting=True)[:2]
    return R[: B.shape[1]], order


def _right_divided(X: Array, R: Array) -> Array:
    """X R^-1, column after column: rows of X keep their own sizes."""
    out = X.copy()
    for j in range(len(R)):
        out[:, j] = (out[:, j] - out[:, :j] @ R[:j, j]) / R[j, j]
    return out


def singular(X: Array) -> tuple[Array, Array]:
    """Singular values (n,), with relative accuracy, and right vectors (n, n) of X (m, n)."""
    n = X.shape[1]
    if len(X) < n:
        X = np.vstack((X, np.zeros((n - len(X), n))))
    _, sigma, Vt = np.linalg.svd(X, full_matrices=False)
    if sigma[0] == 0.0 or sigma[-1] > JACOBI * sigma[0]:
        return sigma, Vt.T
    from scipy.linalg.lapack import dgejsv

    norms = np.sqrt((X * X).sum(axis=0))
    own = np.flatnonzero(norms)
    values, _, V, work, _, failed = dgejsv(X[:, own], joba=2, jobu=3, jobv=0, jobr=0, jobt=0, jobp=0)
    if failed:
        return sigma, Vt.T
    sigma, vectors = np.zeros(n), np.zeros((n, n))
    sigma[: len(own)] = values[: len(own)] * (work[0] / work[1])
    vectors[own, : len(own)] = V
    vectors[np.setdiff1d(np.arange(n), own), np.arange(len(own), n)] = 1.0
    return sigma, vectors


def _with_remainder(squares: Array, G: Array) -> tuple[Array, Array] | None:
    """Squares and vectors of diag(squares) + G, G symmetric."""
    H = np.diag(squares) + G
    values = np.linalg.eigvalsh(H)
    largest = np.abs(values).max()
    clear = values[values > 64.0 * len(H) * EPS * largest]
    shifts = [0.0, 1e-3 * float(clear[0]) if len(clear) else largest]
    shifts.append(max(shifts[1], -2.0 * float(values[0])))
    for shift in shifts:
        moved = H + shift * np.eye(len(H))
        d = np.sqrt(np.abs(moved.diagonal()))
        if not (moved.diagonal() > 0.0).all():
            continue
        try:
            F = np.linalg.cholesky(moved / np.outer(d, d)).T * d
        except np.linalg.LinAlgError:
            continue
        sigma, V = singular(F)
        return sigma * sigma - shift, V
    return None


# -- damping -------------------------------------------------------------------------------------------------------
def eigenvalues(
    values: Complex, shapes: Complex, M: Array, C: Array, K: Array, squares: Array, Phi: Array
) -> tuple[Complex, Complex, NDArray[np.bool_]] | None:
    """Eigenvalues (2 n,) of z^2 M + z C + K, their shapes (n, 2 n), and which of them are not known to ten digits.

    values, shapes   of the QR algorithm;  squares, Phi: the undamped modes

    Of MANY degrees of freedom and more only those of `_doubtful` are iterated, if that is no more than WORK. None where
    all `values` that are known compare with the largest, and for motions without stiffness or damping (their
    eigenvalues are a double zero).
    """
    size = np.abs(values)
    if not size.min(initial=np.inf) < SMALL * size.max(initial=0.0):
        return None
    n, D = len(M), Phi.T @ C @ Phi
    still = np.abs(squares) <= RIGID * np.abs(squares).max(initial=0.0)
    if still.any() and n > MANY:
        return None
    squares = np.where(still, 0.0, squares)
    given, modal = (M, C, K), (np.eye(n), D, np.diag(squares))
    own = _of_single_modes(C.diagonal() / M.diagonal(), K.diagonal() / M.diagonal())
    of_modes = _of_single_modes(D.diagonal(), squares)
    ways = [(values, given), (of_modes, given), (own, given), (of_modes, modal)]
    if still.any() or not (keeps_digits(K) and keeps_digits(M)):
        ways = [ways[3], *ways[:3]][: 1 if still.any() else 4]
    with np.errstate(all="ignore"):
        doubtful = _doubtful(values, shapes, *given) if n > MANY else None
        chosen = np.arange(2 * n) if doubtful is None else np.flatnonzero(doubtful)
        sure = np.delete(values, chosen)
        for start, matrices in ways if len(chosen) * n**3 <= WORK else ():
            if not start.all() and not still.any():
                continue  # a zero counts as exact
            z = values.astype(complex)
            z[chosen] = start[chosen] if start is values else _others(start, sure)
            moved = _aberth(z, chosen, *matrices)
            if not (moved <= ROUGH).all() or _meet(z, chosen):
                continue
            vectors = np.array([_null_vector(of_one, *matrices) for of_one in z[chosen]]).reshape(-1, n)
            known = EPS * np.array([_condition(*pair, *matrices) for pair in zip(z[chosen], vectors, strict=True)])
            if (moved <= np.maximum(SUFFICIENT, 4.0 * n * known)).all():
                found, lost = shapes.astype(complex), np.zeros(2 * n, bool)
                found[:, chosen] = vectors.T if matrices is given else Phi @ vectors.T
                lost[chosen] = ~(known <= TEN_DIGITS)
                return z, found, lost
    return None if doubtful is None else (values, shapes, doubtful)


def _others(start: Complex, sure: Complex) -> Complex:
    """What is left of the starts (k,) when every sure eigenvalue (m,) has taken the nearest one, (k - m,)."""
    for z in sure:
        start = np.delete(start, np.argmin(np.abs(start - z)))
    return start


def _doubtful(z: Complex, v: Complex, M: Array, C: Array, K: Array) -> NDArray[np.bool_]:
    """Which of the eigenvalues (k,) Rayleigh's quotient moves by more than ten digits allow; v (n, k) their shapes.

    With symmetric matrices the step v.P(z) v / v.P'(z) v is wrong in the second order of the error of v.
    """
    doubtful = np.abs(z) < SMALL * np.abs(z).max()
    z, v = z[doubtful], v[:, doubtful]
    m, c, k = ((v * (A @ v)).sum(axis=0) for A in (M, C, K))
    doubtful[doubtful] = ~(np.abs(((z * m + c) * z + k) / (2.0 * z * m + c)) <= TEN_DIGITS * np.abs(z))
    return doubtful


def _condition(z: complex, v: Complex, M: Array, C: Array, K: Array) -> float:
    """Relative change of z by relative changes of the entries of symmetric M, C, K, to first order."""
    if z == 0.0:
        return 1.0
    a = np.abs(v)
    sizes = a @ (abs(z) ** 2 * np.abs(M) + abs(z) * np.abs(C) + np.abs(K)) @ a
    return float(sizes / (abs(z) * abs(v @ ((2.0 * z * M + C) @ v))))


def _meet(z: Complex, chosen: Index) -> bool:
    """Has one of the chosen come to another? It may be a double one, or the iteration has lost another."""
    apart = np.abs(z[:, None] - z[chosen])
    apart[chosen, np.arange(len(chosen))] = np.inf
    return bool((apart <= 1e-9 * np.abs(z[chosen])).any())


def keeps_digits(S: Array) -> bool:
    """Is S with unit diagonal definite with pivots that rounding leaves ten digits?"""
    d = np.sqrt(np.abs(S.diagonal()))
    if not (S.diagonal() > 0.0).all():
        return False
    try:
        return bool((np.linalg.cholesky(S / np.outer(d, d)).diagonal() > SORTED).all())
    except np.linalg.LinAlgError:
        return False


def _of_single_modes(d: Array, squares: Array) -> Complex:
    """Both roots of z^2 + d z + square of every mode (2 n,), without cancellation."""
    root = np.sqrt((0.25 * d * d - squares).astype(complex))
    far = -0.5 * d - np.where(d >= 0.0, 1.0, -1.0) * root
    near = np.where(far != 0.0, squares / np.where(far != 0.0, far, 1.0), 0.0)
    far = np.where(root.imag != 0.0, -0.5 * d + root, far)
    near = np.where(root.imag != 0.0, far.conj(), near)
    return np.concatenate((far, near))


def _scaled(z: Complex, M: Array, C: Array, K: Array) -> tuple[Complex, Complex, Array]:
    """P and P' at each of z (k,), (k, n, n), row and column scaled, and the factors (k, n)."""
    size, at = np.abs(z)[:, None], z[:, None, None]
    sizes = size**2 * np.abs(M.diagonal()) + size * np.abs(C.diagonal()) + np.abs(K.diagonal())
    s = 1.0 / np.sqrt(np.where(sizes > 0.0, sizes, 1.0))
    both = s[:, :, None] * s[:, None, :]
    return (at * at * M + at * C + K) * both, (2.0 * at * M + C) * both, s


def _aberth(z: Complex, chosen: Index, M: Array, C: Array, K: Array) -> Array:
    """The iteration of the chosen eigenvalues, in place; the last relative correction of each. One zero is exact."""
    last = np.zeros(len(z))
    last[chosen] = np.where(z[chosen] == 0.0, 0.0, np.inf)
    for _ in range(MOST):
        active = np.flatnonzero(~(last <= SUFFICIENT))
        if not len(active):
            break
        now = z[active]
        P, slope, _ = _scaled(now, M, C, K)
        try:
            newton = 1.0 / np.trace(np.linalg.solve(P, slope), axis1=1, axis2=2)
        except np.linalg.LinAlgError:  # exactly at one of them
            there = np.linalg.slogdet(P)[0] == 0.0
            P[there] = np.eye(len(M))
            newton = np.where(there, 0.0, 1.0 / np.trace(np.linalg.solve(P, slope), axis1=1, axis2=2))
        others = now[:, None] - z
        others = np.where(others == 0.0, EPS * np.abs(now)[:, None], others)
        others[np.arange(len(active)), active] = np.inf
        steps = newton / (1.0 - newton * np.sum(1.0 / others, axis=1))
        z[active] -= steps
        last[active] = np.abs(steps) / np.abs(z[active])
    return last[chosen]


def _null_vector(z: complex, M: Array, C: Array, K: Array) -> Complex:
    """v with P(z) v = 0, by inverse iteration."""
    (P,), _, (s,) = _scaled(np.array([z]), M, C, K)
    v = np.exp(1j * np.arange(len(s)))
    for lift in (EPS, 4.0 * EPS, 16.0 * EPS):
        try:
            v = np.linalg.solve(P + lift * np.eye(len(v)), v)
        except np.linalg.LinAlgError:
            continue
        v /= np.linalg.norm(v)
    return np.asarray(s * v)
