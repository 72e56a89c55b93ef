"""Euler parameters lambda = (cos t/2, sin t/2 * axis), component first (theory-spatial.md section 1).

The homogeneous form of the rotation is used throughout,

    R(lam) c = (lam0^2 - lv.lv) c + 2 (lv.c) lv + 2 lam0 lv x c,

which does not assume |lam| = 1. It is quadratic, so with the constant tensor K_c = d2(R c)/dlam2 ("director
tensor") everything an element needs is a contraction:

    R(lam) c = 1/2 K_c lam lam,   B_c(lam) = d(R c)/dlam = K_c lam,   Hessian of w.(R c): 2 N(w, c) = w.K_c.

The parameters of q relative to p are bilinear: mu0 = lam_p.lam_q, mu_e = lam_p Z(e) lam_q.
"""

import numpy as np

from spacar.arrays import Array


def _director_coefficients() -> Array:
    """T[i, j, k, m] with K_c[i, j, k] = sum_m T[i, j, k, m] c_m, from the second derivatives of R(lam) c."""
    T = np.zeros((3, 4, 4, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        T[i, 0, 0, i] = 2.0
        T[i, [0, 1 + j], [1 + j, 0], k] += 2.0  # (e_j x c)_i = c_k for i, j, k cyclic
        T[i, [0, 1 + k], [1 + k, 0], j] -= 2.0
        for a in range(3):
            T[i, 1 + a, 1 + a, i] -= 2.0
            T[i, 1 + i, 1 + a, a] += 2.0
            T[i, 1 + a, 1 + i, a] += 2.0
    return T


_DIRECTOR = _director_coefficients()
_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])
_CROSS = np.zeros((3, 3, 3))  # Levi-Civita symbol
_CROSS[[0, 1, 2], [1, 2, 0], [2, 0, 1]] = 1.0
_CROSS[[0, 1, 2], [2, 0, 1], [1, 2, 0]] = -1.0


def _rate_coefficients(sign: float) -> Array:
    """[-v | lam0 I + sign v~] as a tensor (3, 4, 4) that is contracted with lam = (lam0, v)."""
    T = np.zeros((3, 4, 4))
    T[:, 0, 1:] = -np.eye(3)
    T[:, 1:, 0] = np.eye(3)
    T[:, 1:, 1:] = sign * _CROSS.swapaxes(1, 2)
    return T


_BODY, _GLOBAL = _rate_coefficients(-1.0), _rate_coefficients(1.0)


def identity(size: int, axes: int = 1) -> Array:
    """The identity matrix with so many element axes of length one behind it."""
    return np.eye(size).reshape(size, size, *(1,) * axes)


def director_tensor(c: Array) -> Array:
    """K_c (3, 4, 4, n) of body-fixed vectors c (3, n): R c = 1/2 K_c lam lam, symmetric in the 4s."""
    return np.einsum("ijkm,m...->ijk...", _DIRECTOR, c)


def relative_parameters(frame_p: Array, frame_q: Array) -> Array:
    """F (4, 2, 4, 4, n): parameters of the frame at q relative to that at p, in components along the frame at p.

    mu_i = lam_p F[i, 0] lam_q; the gradient with respect to lam_p is F[i, 0] lam_q, to lam_q it is F[i, 1] lam_p.
    Frames that coincide at the start, the usual case, give mu0 = lam_p.lam_q and mu_i = lam_p Z(e_i) lam_q.
    """
    n = frame_p.shape[-1]
    F = np.zeros((4, 2, 4, 4, n), np.result_type(frame_p, frame_q))
    F[0, 0] = identity(4)
    F[1:, 0] = -body_dual(frame_p).transpose(2, 0, 1, 3)  # Z(e) = -K(e)
    if frame_p is not frame_q and not np.array_equal(frame_p, frame_q):
        F[:, 0] = _follow(F[:, 0], frame_p, frame_q)
    F[:, 1] = F[:, 0].swapaxes(1, 2)
    return F


def _follow(F: Array, frame_p: Array, frame_q: Array) -> Array:
    """F with lam_q o lam_start for lam_q: at the start the frame at q is turned by frame_q frame_p^T."""
    vector = parameters_of_frame(np.einsum("ian,jan->ijn", frame_q, frame_p))
    return np.asarray(np.einsum("aijn,jkn->aikn", F, right_product(vector)))


def right_product(r: Array) -> Array:
    """(4, 4, n): lam o r = right_product(r) lam for Euler parameters r (4, n)."""
    return r[0] * identity(4) + body_dual(r[1:])


def parameters_of_frame(R: Array) -> Array:
    """Euler parameters (4, n), scalar first, of rotation matrices (3, 3, n); the largest is positive.

    Of the products 4 lam_i lam_j, which are linear in R, the column with the largest square (Shepperd).
    """
    four = np.zeros((4, 4, R.shape[-1]), R.dtype)
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    four[0, 0] = 1.0 + trace
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        four[1 + i, 1 + i] = 1.0 + 2.0 * R[i, i] - trace
        four[0, 1 + i] = four[1 + i, 0] = R[k, j] - R[j, k]
        four[1 + i, 1 + j] = four[1 + j, 1 + i] = R[i, j] + R[j, i]
    largest = np.argmax(np.einsum("iin->in", four).real, axis=0)
    lam = four[:, largest, np.arange(R.shape[-1])]
    return np.asarray(lam / np.sqrt((lam * lam).sum(0)))


def skew(v: Array) -> Array:
    """v~ (3, 3, n) with v~ w = v x w, for v (3, n)."""
    return np.einsum("ikj,k...->ij...", _CROSS, v)


def cross(a: Array, b: Array) -> Array:
    """a x b for component-first arrays that broadcast against each other behind the first axis."""
    return a.take(_NEXT, 0) * b.take(_LAST, 0) - a.take(_LAST, 0) * b.take(_NEXT, 0)


def rotate(lam: Array, c: Array) -> Array:
    """R(lam) c (3, n) for lam (4, n) and c (3, n)."""
    v = lam[1:]
    return (lam[0] ** 2 - (v * v).sum(0)) * c + 2.0 * ((v * c).sum(0) * v + lam[0] * cross(v, c))


def body_matrix(lam: Array) -> Array:
    """Lambda (3, 4, n): w' = 2 Lambda dlam/dt is the angular velocity in body components."""
    return np.einsum("ijk,k...->ij...", _BODY, lam)


def global_matrix(lam: Array) -> Array:
    """Lambda-bar (3, 4, n): w = 2 Lambda-bar dlam/dt is the angular velocity in global components."""
    return np.einsum("ijk,k...->ij...", _GLOBAL, lam)


def body_dual(w: Array) -> Array:
    """K(w) (4, 4, n) = [0, -w^T; w, -w~] (skew): Lambda(a)^T w = K(w) a. With +w~ it is `global_dual`."""
    return _dual(w, -1.0)


def global_dual(w: Array) -> Array:
    """K-bar(w) (4, 4, n) = [0, -w^T; w, w~] (skew): Lambda-bar(a)^T w = K-bar(w) a.

    A constant global moment M on an orientation node is the force 2 K-bar(M) lam on its parameters.
    """
    return _dual(w, 1.0)


def _dual(w: Array, sign: float) -> Array:
    K = np.zeros((4, 4, *w.shape[1:]), w.dtype)
    K[0, 1:] = -w
    K[1:, 0] = w
    K[1:, 1:] = sign * skew(w)
    return K
