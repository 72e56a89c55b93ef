"""Spatial hinge, keyword HINGE (theory-spatial.md section 5).

Coordinates lambda_p (4), lambda_q (4). With the relative parameters mu_i = lam_p F[i] lam_q (mu0 = cos of
half the relative rotation, mu1..mu3 along the local axes):

    e1 = 2 atan2(mu1, mu0)            rotation of q relative to p about x', counted over many turns [rad]
    e2 = 2 (mu0 mu2 - mu1 mu3),   e3 = 2 (mu0 mu3 + mu1 mu2)      misalignment [rad]

So e = f(mu) with mu bilinear in lambda_p and lambda_q; below f_i, f_ij, f_ijk are derivatives with respect to
mu. The screw uses the same functions.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, GeometryError, arc_tangent
from spacar.elements.rotations.local_frames import axis_frame, columns, rows
from spacar.elements.rotations.rotation import relative_parameters

_einsum = np.einsum
_TURN = 2.0 * np.pi
# second derivatives of e2, e3 by mu: 2 (mu0 mu2 - mu1 mu3) and 2 (mu0 mu3 + mu1 mu2)
_MISALIGNMENT = np.zeros((2, 4, 4))
_MISALIGNMENT[0, [0, 2], [2, 0]] = 2.0
_MISALIGNMENT[0, [1, 3], [3, 1]] = -2.0
_MISALIGNMENT[1, [0, 1, 2, 3], [3, 2, 1, 0]] = 2.0


class HingeState(NamedTuple):
    """Relative parameters of the group at x."""

    F: Array  # (4, 2, 4, 4, n)
    lam: Array  # (2, 4, n)
    mu: Array  # (4, n)
    dmu: Array  # (4, 2, 4, n)
    f_i: Array  # (3, 4, n)


def hinge_state(F: Array, lam: Array) -> HingeState:
    """State for lam (2, 4, n)."""
    dmu = _einsum("asij...,sj...->asi...", F, lam[::-1])
    mu = _einsum("ai...,i...->a...", dmu[:, 0], lam[0])
    m0, m1 = mu[0], mu[1]
    half_r = 0.5 * (m0 * m0 + m1 * m1)
    f = np.zeros((3, *mu.shape), mu.dtype)
    np.divide(-m1, half_r, out=f[0, 0])
    np.divide(m0, half_r, out=f[0, 1])
    f[1:] = _einsum("eab,b...->ea...", _MISALIGNMENT, mu)
    return HingeState(F, lam, mu, dmu, f)


def hinge_deformations(c: HingeState, branch: Array) -> Array:
    """e1..e3 (3, n); e1 on the branch closest to branch (n,)."""
    e = np.empty((3, *c.mu.shape[1:]), c.mu.dtype)
    e1 = 2.0 * arc_tangent(c.mu[1], c.mu[0])
    np.add(e1, _TURN * np.round((branch - e1.real) / _TURN), out=e[0])
    e[1:] = _einsum("ea...,a...->e...", c.f_i[1:], 0.5 * c.mu)  # homogeneous quadratic in mu
    return e


def hinge_gradient(c: HingeState) -> Array:
    """de/dlam (3, 2, 4, n)."""
    return np.asarray(_einsum("ea...,asi...->esi...", c.f_i, c.dmu))


def hinge_convective(c: HingeState, lam1: Array) -> Array:
    """Second rate of e at zero accelerations, (3, n), for rates lam1 (2, 4, n) of lambda."""
    mu1, _, mu2 = _rates(c, lam1)
    return np.asarray(
        _einsum("ea...,a...->e...", _second(c, mu1), mu1) + _einsum("ea...,a...->e...", c.f_i, mu2)
    )


def hinge_rate_rows(c: HingeState, lam1: Array) -> Array:
    """[v, .] (3, 2, 4, n)."""
    mu1, dmu1, _ = _rates(c, lam1)
    return np.asarray(
        _einsum("ea...,asi...->esi...", _second(c, mu1), c.dmu) + _einsum("ea...,asi...->esi...", c.f_i, dmu1)
    )


def hinge_second_rate_rows(c: HingeState, lam1: Array) -> Array:
    """Third derivative [v, v, .] (3, 2, 4, n)."""
    mu1, dmu1, mu2 = _rates(c, lam1)
    along = _second(c, mu2)
    along[0, :2] += _third(c, mu1)
    return np.asarray(
        _einsum("ea...,asi...->esi...", along, c.dmu)
        + 2.0 * _einsum("ea...,asi...->esi...", _second(c, mu1), dmu1)
    )


def hinge_hessian(c: HingeState, sigma: Array) -> Array:
    """sum sigma_e d2(e) (2, 4, 2, 4, n)."""
    f_i = _einsum("e...,ea...->a...", sigma, c.f_i)
    f_ij = np.zeros((4, 4, *c.mu.shape[1:]), np.result_type(c.mu, sigma))
    taa, tab = _curvature(c)
    f_ij[0, 0] = sigma[0] * taa
    f_ij[1, 1] = -f_ij[0, 0]
    f_ij[0, 1] = f_ij[1, 0] = sigma[0] * tab
    f_ij += _einsum("e...,eab->ab...", sigma[1:], _MISALIGNMENT)
    H = _einsum("asi...,atj...->sitj...", c.dmu, _einsum("ab...,btj...->atj...", f_ij, c.dmu))
    cross = _einsum("a...,aij...->ij...", f_i, c.F[:, 0])
    H[0, :, 1] += cross
    H[1, :, 0] += cross.swapaxes(0, 1)
    return np.asarray(H)


def _rates(c: HingeState, lam1: Array) -> tuple[Array, Array, Array]:
    """Rates of mu and of its gradient, and second rate of mu at zero accelerations."""
    dmu1 = _einsum("asij...,sj...->asi...", c.F, lam1[::-1])
    return (
        _einsum("asi...,si...->a...", c.dmu, lam1),
        dmu1,
        _einsum("asi...,si...->a...", dmu1, lam1),
    )


def _curvature(c: HingeState) -> tuple[Array, Array]:
    """Second derivatives of 2 atan2(mu1, mu0): by mu0 mu0 (= minus mu1 mu1) and by mu0 mu1."""
    a, b = c.mu[0], c.mu[1]
    r = a * a + b * b
    return 4.0 * a * b / r**2, 2.0 * (b * b - a * a) / r**2


def _second(c: HingeState, m: Array) -> Array:
    """f_ij m_j (3, 4, n) for m (4, n)."""
    taa, tab = _curvature(c)
    f = np.zeros((3, *m.shape), np.result_type(c.mu, m))
    f[0, 0] = taa * m[0] + tab * m[1]
    f[0, 1] = tab * m[0] - taa * m[1]
    f[1:] = _einsum("eab,b...->ea...", _MISALIGNMENT, m)
    return f


def _third(c: HingeState, m: Array) -> Array:
    """f_1jk m_j m_k with respect to mu0, mu1, (2, n)."""
    a, b = c.mu[0], c.mu[1]
    r3 = (a * a + b * b) ** 3
    taaa = 4.0 * b * (b * b - 3.0 * a * a) / r3
    taab = 4.0 * a * (a * a - 3.0 * b * b) / r3
    square, product = m[0] ** 2 - m[1] ** 2, 2.0 * m[0] * m[1]
    return np.stack((taaa * square + taab * product, taab * square - taaa * product))


class SpatialHinge(Family):
    """All HINGE elements of a model. Raises GeometryError for a missing or zero axis."""

    definition = "hinge"
    n_coordinates = 8
    frame_p: Array
    n_deformations = 3

    def __init__(self, group: ElementGroup) -> None:
        self.keyword, self.numbers = group.keyword, group.numbers
        self.length = np.zeros(group.n)
        if set(map(len, group.geometry)) != {3}:
            k, count = next((k, len(v)) for k, v in enumerate(group.geometry) if len(v) != 3)
            raise GeometryError(k, f"the axis of rotation needs 3 components, {count} are given")
        frame = axis_frame(columns(group.geometry), 0, "axis of rotation")
        self.frame_p = self.frame_q = rows(frame)
        self._frame = frame
        self._coefficients = group.estiff[:, :3], group.edamp[:, :3]

    def parameters(self) -> Array:
        return self.frame_p.T

    @cached_property
    def _relative(self) -> Array:
        """Tensors of `relative_parameters`; a compiled run does not make them."""
        return relative_parameters(self._frame, self._frame)

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> HingeState:
        c = hinge_state(self._relative, x.reshape(2, 4, -1))
        e[...] = hinge_deformations(c, branch[0])
        V[...] = hinge_gradient(c).reshape(V.shape)
        return c

    def convective_strain(self, c: HingeState, v: Array, out: Array) -> None:
        out[...] = hinge_convective(c, v.reshape(c.lam.shape))

    def gradient_rate(self, c: HingeState, v: Array, out: Array) -> None:
        out[...] = hinge_rate_rows(c, v.reshape(c.lam.shape)).reshape(out.shape)

    def rate_gradient(self, c: HingeState, v: Array, out: Array) -> None:
        out[...] = hinge_second_rate_rows(c, v.reshape(c.lam.shape)).reshape(out.shape)

    def geometric_stiffness(self, c: HingeState, sigma: Array, out: Array) -> None:
        out[...] = hinge_hessian(c, sigma).reshape(out.shape)

    def stiffness(self) -> tuple[Array, Array]:
        """S1..S3 [N m/rad] and Sd1..Sd3 [N m s/rad]."""
        S, S_d = (diagonal(k) for k in self._coefficients)
        return S, S_d


def diagonal(k: Array) -> Array:
    """Diagonal matrices (m, m, n) of coefficients (n, m)."""
    modes = np.arange(k.shape[1])
    S = np.zeros((len(modes), len(modes), len(k)), k.dtype)
    S[modes, modes] = k.T
    return S
