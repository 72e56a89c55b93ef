"""Deformations of the spatial beam and their derivatives (theory-spatial.md sections 3.1 to 3.4).

Raw deformations in a frame that follows the chord (d = x_q - x_p, l = |d|, n = d/l, P = (I - n n^T)/l):

    eb1 = l - l0,   eb2 = 2 l0 mu0 mu_x,   eb3..6 = n.U_k,   U_k = s_k l0 R(lam_k) c_k
    (s, lam, c) = (-, p, z'), (+, q, z'), (+, p, y'), (-, q, y')

and, unless LDEFORM switches them off, the second order terms e = eb + 1/2 eb Q_k eb with constant Q_k (section 3.2).

The four bending modes are one batch with the axes [c, s], c in (z', y'), s in (p, q). Rows W of first derivatives have
the shape (6, 2, 7, n): modes, node p or q, (position, lambda). They are filled for the position of q only; the columns
of the position of p are the opposite, which `put` writes at the end. In a beam everything that depends on the
orientation is K lam with constant per-element tensors K (see `rotation`), so no rotation matrix is formed.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.elements.rotations.rotation import director_tensor, identity, relative_parameters

_einsum = np.einsum


class BeamConstants(NamedTuple):
    """Constants of the beams of a group, element axis last.

    K     (2, 2, 3, 4, 4, n) director tensors of the bending modes [c, s] with the factor s_k l0 [m]
    F     (2, 2, 4, 4, n) mu0 and 2 l0 mu_x: gradients are F[i, s] lam_(other node)
    l0    (n,) undeformed length [m]
    g     (n,) factor of the second order terms: 1/l0, or 0 for LDEFORM [1/m]
    f     (n,) factor of the torsion-elongation term, f1/l0^3, or 0 for LDEFORM [1/m]
    Q     (6, 6, 6, n) `correction_coefficients`; one for all, n = 1, of beams without shear
    """

    K: Array
    F: Array
    l0: Array
    g: Array
    f: Array
    Q: Array


class BeamState(NamedTuple):
    """What later calls at the same x reuse."""

    p: BeamConstants
    lam: Array  # (2, 4, n)
    l: Array  # (n,)
    n: Array  # (3, n)
    B: Array  # (2, 2, 3, 4, n) dU/dlam
    U: Array  # (2, 2, 3, n)
    bend: Array  # (2, 2, n) eb3..6
    twist: Array  # (2, n) mu0 and 2 l0 mu_x
    dtwist: Array  # (2, 2, 4, n) their gradients
    raw: Array  # (6, n) eb
    W: Array  # (6, 2, 7, n) gradient of eb
    Q: Array | None  # (6, 6, n) Q_k eb, None for LDEFORM beams only


def correction_coefficients(shear: Array) -> Array:
    """Q (6, 6, 6, ...): l0 times the symmetric Q_k of section 3.2, without the torsion-elongation term, for the factors
    1/(1 + Phi_z), 1/(1 + Phi_y) of the antisymmetric bending (2, ...)."""
    u, y, a, z, b = bending_forms(6)
    sz, sy = shear
    Q = np.zeros((6, 6, 6, *shear.shape[1:]), shear.dtype)
    Q[0] = stretched(y, a, z, b, shear)
    Q[1] = times(sz, pair(a, z) / 2.0) - times(sy, pair(b, y) / 2.0)
    along, beside = times((sy - 1.0) / 4.0, pair(u, b)), times((1.0 - sz) / 4.0, pair(u, a))
    Q[2:4], Q[4:6] = along, beside
    third = _spread(pair(u, z) / 6.0, sz), _spread(pair(u, y) / 6.0, sz)
    Q[2] += third[0]
    Q[3] -= third[0]
    Q[4] -= third[1]
    Q[5] += third[1]
    return Q


def bending_forms(modes: int) -> Array:
    """(5, modes): eb2, eb3 + eb4, eb4 - eb3, eb5 + eb6, eb6 - eb5 as linear forms of the raw deformations."""
    forms = np.zeros((5, modes))
    forms[0, 1] = forms[1, 2] = forms[1, 3] = forms[2, 3] = forms[3, 4] = forms[3, 5] = forms[4, 5] = 1.0
    forms[2, 2] = forms[4, 4] = -1.0
    return forms


def stretched(y: Array, a: Array, z: Array, b: Array, shear: Array) -> Array:
    """l0 times the second derivative of the shortening (y^2 + z^2)/(24 l0) + (a^2/(1 + Phi_z)^2 + ...)/(40 l0)."""
    sz, sy = shear
    even = _spread((pair(y, y) + pair(z, z)) / 24.0, sz)
    return even + times(sz * sz, pair(a, a) / 40.0) + times(sy * sy, pair(b, b) / 40.0)


def pair(a: Array, b: Array) -> Array:
    """The second derivative of the product of two linear forms."""
    return np.outer(a, b) + np.outer(b, a)


def times(factor: Array, form: Array) -> Array:
    """A form (m, m) times factors (...), (m, m, ...)."""
    return np.multiply.outer(form, factor)


def _spread(form: Array, like: Array) -> Array:
    return times(np.ones_like(like), form)


def beam_constants(
    frame_p: Array, frame_q: Array, l0: Array, f1: Array, nonlinear: NDArray[np.bool_], Q: Array
) -> BeamConstants:
    """Constants of beams with frames (3, 3, n) at p and q, lengths l0 (n,) [m], coupling f1 (n,) [m^2] and Q."""
    c = np.stack((-frame_p[:, 2], frame_q[:, 2], frame_p[:, 1], -frame_q[:, 1]), axis=1)  # (3, 4, n)
    K = l0 * director_tensor(c).transpose(3, 0, 1, 2, 4)
    K = np.ascontiguousarray(K).reshape(2, 2, 3, 4, 4, len(l0))
    F = np.zeros((2, 2, 4, 4, len(l0)), l0.dtype)
    F[0], F[1] = relative_parameters(frame_p, frame_q)[:2]
    F[1] *= 2.0 * l0
    return BeamConstants(K, F, l0, nonlinear / l0, nonlinear * f1 / l0**3, Q)


def correction(p: BeamConstants, e: Array) -> Array:
    """Q_k e (6, 6, n) of raw deformations (or their rates) e (6, n)."""
    Q = products(p.Q, p.g * e)
    Q[0, 1] += p.f * e[1]
    return Q


def products(Q: Array, e: Array) -> Array:
    """Q_k e (m, m, n) of e (m, n), for Q (m, m, m, n) of every element or (m, m, m, 1) of all."""
    m = len(Q)
    if Q.size == m**3:
        return np.asarray((Q.reshape(m * m, m) @ e.reshape(m, -1)).reshape(m, *e.shape))
    return np.asarray(_einsum("kij...,j...->ki...", Q, e))


def second_order(Q: Array | None, e: Array) -> Array:
    """T e for rates e (6, n) of the raw deformations, T = I + Q."""
    return e if Q is None else e + _einsum("kj...,j...->k...", Q, e)


def corrected(Q: Array | None, W: Array) -> Array:
    """T W for rows W (6, 2, 7, n), T = I + Q."""
    return W if Q is None else W + times_rows(Q, W)


def times_rows(Q: Array, W: Array) -> Array:
    """Q W."""
    return np.asarray(_einsum("kj...,jsi...->ksi...", Q, W))


def put(W: Array, out: Array) -> None:
    """Write rows W (6, 2, 7, n) to out (6, 14, n) and give the position of p the opposite of that of q."""
    view = out.reshape(W.shape)
    view[...] = W
    np.negative(W[:, 1, :3], out=view[:, 0, :3])


def rows(stretch: Array, twist: Array, bend_d: Array, bend_lam: Array) -> Array:
    """W (6, 2, 7, n) from its parts (3, n), (2, 4, n), (2, 2, 3, n), (2, 2, 4, n)."""
    tail = stretch.shape[1:]
    W = np.zeros((6, 2, 7, *tail), bend_lam.dtype)
    W[0, 1, :3] = stretch
    W[1, :, 3:] = twist
    bending = W[2:].reshape(2, 2, 2, 7, *tail)
    bending[:, :, 1, :3] = bend_d
    bending[:, 0, 0, 3:] = bend_lam[:, 0]
    bending[:, 1, 1, 3:] = bend_lam[:, 1]
    return W


def state(p: BeamConstants, x: Array, second: bool) -> BeamState:
    """Raw deformations and their gradient at x (14, n); `second`: some beam has second order terms."""
    x7 = x.reshape(2, 7, *x.shape[1:])
    lam = x7[:, 3:]
    d = x7[1, :3] - x7[0, :3]
    l = np.sqrt(_einsum("i...,i...->...", d, d))
    n = d / l
    B = _einsum("csijk...,sk...->csij...", p.K, lam)
    U = _einsum("csij...,sj...->csi...", B, 0.5 * lam)
    bend = _einsum("csi...,i...->cs...", U, n)
    dtwist = _einsum("ksij...,sj...->ksi...", p.F, lam[::-1])
    twist = _einsum("ki...,i...->k...", dtwist[:, 0], lam[0])
    raw = np.empty((6, *l.shape), x.dtype)
    raw[0] = l - p.l0
    raw[1] = twist[0] * twist[1]
    raw[2:] = bend.reshape(4, *l.shape)
    W = rows(
        n,
        _einsum("k...,ksi...->si...", twist[::-1], dtwist),
        (U - bend[:, :, None] * n) / l,
        _einsum("csij...,i...->csj...", B, n),
    )
    return BeamState(p, lam, l, n, B, U, bend, twist, dtwist, raw, W, correction(p, raw) if second else None)


class BeamRates(NamedTuple):
    """Rates of the state with velocities v at zero accelerations (sections 3.3, 3.4)."""

    lam: Array  # (2, 4, n)
    d: Array  # (3, n)
    nu: Array  # (n,) n.ddot
    n1: Array  # (3, n) dn/dt
    kappa: Array  # (n,) ddot.dn/dt
    n2: Array  # (3, n) d2n/dt2
    B1: Array  # (2, 2, 3, 4, n) dB/dt
    U1: Array  # (2, 2, 3, n) dU/dt
    U2: Array  # (2, 2, 3, n) d2U/dt2
    twist1: Array  # (2, n)
    dtwist1: Array  # (2, 2, 4, n)
    twist2: Array  # (2, n)
    raw2: Array  # (6, n) second rate of eb


def rates(c: BeamState, v: Array) -> BeamRates:
    """Rates for v (14, n)."""
    p, n, l = c.p, c.n, c.l
    v7 = v.reshape(2, 7, *v.shape[1:])
    lam = v7[:, 3:]
    d = v7[1, :3] - v7[0, :3]
    nu = _einsum("i...,i...->...", n, d)
    n1 = (d - nu * n) / l
    kappa = _einsum("i...,i...->...", d, n1)
    n2 = (-2.0 * nu * n1 - kappa * n) / l
    B1 = _einsum("csijk...,sk...->csij...", p.K, lam)
    U1 = _einsum("csij...,sj...->csi...", c.B, lam)
    U2 = _einsum("csij...,sj...->csi...", B1, lam)
    dtwist1 = _einsum("ksij...,sj...->ksi...", p.F, lam[::-1])
    twist1 = _einsum("ksi...,si...->k...", c.dtwist, lam)
    twist2 = _einsum("ksi...,si...->k...", dtwist1, lam)
    bend2 = (
        _einsum("csi...,i...->cs...", c.U, n2)
        + _einsum("csi...,i...->cs...", U1, 2.0 * n1)
        + _einsum("csi...,i...->cs...", U2, n)
    )
    raw2 = np.empty((6, *nu.shape), bend2.dtype)
    raw2[0] = kappa
    raw2[1] = twist2[0] * c.twist[1] + c.twist[0] * twist2[1] + 2.0 * twist1[0] * twist1[1]
    raw2[2:] = bend2.reshape(4, *nu.shape)
    return BeamRates(lam, d, nu, n1, kappa, n2, B1, U1, U2, twist1, dtwist1, twist2, raw2)


def raw_rate(c: Any, v: Array) -> Array:
    """d(eb)/dt from the gradient rows, which lack the columns of the position of p; with warping too."""
    of_nodes = v.reshape(2, -1, *v.shape[1:]).copy()
    of_nodes[1, :3] -= of_nodes[0, :3]
    return np.asarray(_einsum("ksi...,si...->k...", c.W, of_nodes))


def _project(c: BeamState, U: Array) -> Array:
    """P U for U (2, 2, 3, n)."""
    return (U - _einsum("csi...,i...->cs...", U, c.n)[:, :, None] * c.n) / c.l


def _rate_of_projection(c: BeamState, r: BeamRates, U: Array) -> Array:
    """(dP/dt) U = -(nu P U + n (n1.U) + n1 (n.U))/l for U (2, 2, 3, n)."""
    nU = _einsum("csi...,i...->cs...", U, c.n)[:, :, None]
    n1U = _einsum("csi...,i...->cs...", U, r.n1)[:, :, None]
    return -(r.nu * (U - nU * c.n) / c.l + c.n * n1U + r.n1 * nU) / c.l


def rate_rows(c: BeamState, r: BeamRates) -> Array:
    """[v, .] of the raw deformations, (6, 2, 7, n)."""
    twist = _einsum("k...,ksi...->si...", c.twist[::-1], r.dtwist1) + _einsum(
        "k...,ksi...->si...", r.twist1[::-1], c.dtwist
    )
    bend_lam = _einsum("csij...,i...->csj...", c.B, r.n1) + _einsum("csij...,i...->csj...", r.B1, c.n)
    return rows(r.n1, twist, _rate_of_projection(c, r, c.U) + _project(c, r.U1), bend_lam)


def second_rate_rows(c: BeamState, r: BeamRates) -> Array:
    """Gradient of the second rate at zero accelerations, third derivative [v, v, .], (6, 2, 7, n)."""
    twist = _einsum("k...,ksi...->si...", r.twist2[::-1], c.dtwist) + 2.0 * _einsum(
        "k...,ksi...->si...", r.twist1[::-1], r.dtwist1
    )
    bend_lam = _einsum("csij...,i...->csj...", c.B, r.n2) + 2.0 * _einsum("csij...,i...->csj...", r.B1, r.n1)
    nU, n1U, n2U = (_einsum("csi...,i...->cs...", c.U, m)[:, :, None] for m in (c.n, r.n1, r.n2))
    PU = (c.U - nU * c.n) / c.l
    L3U = -(r.nu * PU + c.n * n1U + r.n1 * nU) / c.l
    L4U = -(2.0 * r.nu * L3U + r.n2 * nU + c.n * n2U + r.kappa * PU + 2.0 * r.n1 * n1U) / c.l
    return rows(r.n2, twist, L4U + 2.0 * _rate_of_projection(c, r, r.U1) + _project(c, r.U2), bend_lam)


def hessian(c: BeamState, sigma: Array, out: Array) -> None:
    """Write sum_k sigma_k d2(e_k) (14, 14, n)."""
    p, n, l = c.p, c.n, c.l
    if c.Q is not None:
        raw = sigma + _einsum("kj...,k...->j...", c.Q, sigma)
        weights = _weights(p, sigma)
    else:
        raw, weights = sigma, None
    tail = sigma.shape[1:]
    bend = raw[2:].reshape(2, 2, *tail)
    H: NDArray[Any] = np.zeros((2, 7, 2, 7, *tail), np.result_type(c.W, sigma))
    # twist: sigma2 (a' b' + b' a' + b a'' + a b'')
    ab = np.einsum("si...,tj...->sitj...", c.dtwist[0], c.dtwist[1])
    H[:, 3:, :, 3:] = raw[1] * (ab + ab.swapaxes(0, 2).swapaxes(1, 3))
    cross = raw[1] * _einsum("k...,kij...->ij...", c.twist[::-1], p.F[:, 0])
    H[0, 3:, 1, 3:] += cross
    H[1, 3:, 0, 3:] += cross.swapaxes(0, 1)
    # bending: lambda-lambda blocks n.K, position-lambda blocks P B
    nK = _einsum("cs...,csijk...,i...->sjk...", bend, p.K, n)
    B = _einsum("cs...,csij...->sij...", bend, c.B)
    PB = (B - n[:, None] * _einsum("i...,sij...->sj...", n, B)[:, None]) / l
    for s in range(2):
        H[s, 3:, s, 3:] += nK[s]
        H[1, :3, s, 3:] = PB[s]
        H[s, 3:, 1, :3] = PB[s].swapaxes(0, 1)
    # chord: sigma1 P + dP[U] with the weighted sum of the U
    U = _einsum("cs...,csi...->i...", bend, c.U)
    nU = _einsum("i...,i...->...", n, U)
    PU = (U - nU * n) / l
    nn = n[:, None] * n
    P = (identity(3, len(tail)) - nn) / l
    nPU = n[:, None] * PU
    H[1, :3, 1, :3] = raw[0] * P - (nU * P + nPU + nPU.swapaxes(0, 1)) / l
    if weights is not None:
        QW = _einsum("jk...,ksi...->jsi...", weights, c.W)
        H += _einsum("jsi...,jtk...->sitk...", c.W, QW)
    H[0, :3] -= H[1, :3]
    H[:, :, 0, :3] -= H[:, :, 1, :3]
    out[...] = H.reshape(14, 14, *tail)


def _weights(p: BeamConstants, sigma: Array) -> Array:
    """sum_k sigma_k Q_k (6, 6, n)."""
    Q = products(p.Q.swapaxes(0, 2), p.g * sigma)
    Q[1, 1] += p.f * sigma[0]
    return Q
