"""The eigenvalues of largest modulus of a linear operator, by Arnoldi's method with implicit restarts (ARPACK).

R. Lehoucq, D. Sorensen, C. Yang, ARPACK Users' Guide, SIAM 1998. For the operators here, the inverse of a symmetric
matrix times another one, it is the method of Lanczos with full orthogonalization, which needs no definite matrix. From
one start vector it finds one vector of a repeated eigenvalue. So what was found, with the orthonormal basis Q, is
taken out of the operator, op - Q Q^T op, whose other eigenvalues are the same, and the largest ones of what is left are
asked for, from another vector, until none is as large as the wanted ones, which rough values tell where it is clear.
Values and vectors are those of Q^T op Q.

Where a block of vectors contains the whole range of the operator its eigenvalues are those of a small matrix at once.
"""

from collections.abc import Callable
from typing import Protocol, TypeVar

import numpy as np

from spacar.arrays import Array, Complex

Operator = Callable[[Array], Array]


class RefinedOperator(Protocol):
    """An operator that also gives the image to all digits that its entries have."""

    def __call__(self, x: Array, /, refined: bool = False) -> Array: ...


Shifted = TypeVar("Shifted", bound=Operator)

CONVERGED = 1e-10  # |op(v) - theta v| / |theta| of the Ritz vectors v of norm 1
SUFFICIENT = 1e-8  # accepted when it does not get better
ROUGH = 1e-2  # for the choice of a shift, and to see whether anything is left
CLEARLY = 10.0  # times that: what a value has to be smaller by
RESTARTS = 20
NOTHING = 1e-13  # theta below this fraction of the largest is zero
ALIKE = 1e-7  # relative: what is left is not larger than the smallest wanted one
SPARE = 28  # columns of a start block beside the wanted ones, if the range is so small
TRIALS = 12  # shifts that are tried, until one is right within a factor of ten


def dominant(
    operator: Operator, start: Array, wanted: int, rank: int, within: float = CONVERGED
) -> tuple[Complex, Complex]:
    """The `wanted` eigenvalues theta of largest modulus and their vectors (n, wanted) of norm 1.

    start   (n, p) start vectors;  rank  of the operator at most: with so many start vectors nothing is iterated

    Those that do not converge are nan; who uses them checks them, and says which are doubtful.
    """
    if start.shape[1] >= min(rank, len(start)):
        Q = np.linalg.qr(operator(np.linalg.qr(operator(start))[0]))[0]
        return _ritz(Q, operator(Q), wanted)
    Q, image = np.zeros((len(start), 0)), np.zeros((len(start), 0))
    theta, z = np.zeros(0, complex), np.zeros((len(start), 0), complex)
    least, count = 0.0, wanted
    for first in range(start.shape[1]):
        if least and within != ROUGH:
            left, _ = _arnoldi(operator, Q, start[:, first], 1, ROUGH)
            if (np.abs(left) < (1.0 - CLEARLY * ROUGH) * least).all():
                break
        found, vectors = _arnoldi(operator, Q, start[:, first], count, within)
        new = np.abs(found) > (1.0 + ALIKE) * least
        if new.any():
            Q, image = _extended(operator, Q, image, vectors[:, new])
            theta, z = _ritz(Q, image, wanted)
            least = float(np.abs(theta[-1])) if len(theta) == wanted else 0.0
        if (within == ROUGH and len(theta)) or (first and not new.any()):  # or none converges
            break
        count = max(1, wanted // 4)
    missing = min(wanted, rank) - len(theta)
    return np.append(theta, [np.nan] * missing), np.hstack((z, start[:, :missing]))


def with_shift(
    made: Callable[[float], Shifted],
    shift: float,
    better: Callable[[Complex, float], float],
    start: Array,
    wanted: int,
    rank: int,
) -> tuple[float, Shifted]:
    """A shift, and the operator `made` of it, for which `better`, by rough values of theta, gives the same one within a
    factor of ten. `shift` is the first one that is tried; the rest as in `dominant`."""
    for _ in range(TRIALS):
        operator = made(shift)
        before, shift = shift, better(dominant(operator, start, wanted, rank, ROUGH)[0], shift)
        if 0.1 < shift / before < 10.0:
            return before, operator
        if shift > before:  # whose values of theta are known by so small a shift
            break
    return shift, made(shift)


def _arnoldi(operator: Operator, Q: Array, start: Array, count: int, within: float) -> tuple[Complex, Complex]:
    """The largest eigenvalues of the operator without the subspace Q (n, k) that is invariant."""
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs

    n = len(start)

    def without(v: Array) -> Array:
        image = operator(v.reshape(n, 1))[:, 0]
        return np.asarray(image - Q @ (Q.T @ image))

    A, v0 = LinearOperator((n, n), matvec=without, dtype=float), without(start)
    for width, limit in (8 if within == ROUGH else 20, within), (60, max(within, SUFFICIENT)):
        basis = min(max(2 * count + 2, width), n - 1)
        try:
            found, vectors = eigs(A, count, v0=v0, ncv=basis, tol=limit, maxiter=RESTARTS)
        except ArpackNoConvergence as failure:
            found, vectors = failure.eigenvalues, failure.eigenvectors
            v0 = v0 + without(v0)
        else:
            break
    return found, vectors


def _extended(operator: Operator, Q: Array, image: Array, vectors: Complex) -> tuple[Array, Array]:
    """Q with a basis of the real and imaginary parts of vectors, and the image of the whole."""
    parts = np.hstack((vectors.real, vectors.imag))
    for _ in range(2):
        parts = parts - Q @ (Q.T @ parts)
    left, sizes, _ = np.linalg.svd(parts, full_matrices=False)  # of a block of few columns
    new = left[:, sizes > SUFFICIENT * sizes[0]]
    return np.hstack((Q, new)), np.hstack((image, operator(new)))


def _ritz(Q: Array, image: Array, wanted: int) -> tuple[Complex, Complex]:
    theta, c = np.linalg.eig(Q.T @ image)
    chosen = np.lexsort((-theta.imag, -np.abs(theta)))[:wanted]
    return theta[chosen].astype(complex), (Q @ c[:, chosen]).astype(complex)


def real_vectors(theta: Complex, vectors: Complex) -> Array:
    """Real vectors of an operator with real eigenvalues: the two of a repeated value may come as a complex pair."""
    out = vectors.real.copy()
    second = np.flatnonzero(theta.imag < 0.0)
    out[:, second] = vectors[:, second].imag
    return out / np.linalg.norm(out, axis=0)
