"""Spatial hinge, keyword HINGE (theory-spatial.md section 5).

Coordinates lambda_p (4), lambda_q (4). With the relative parameters mu_i = lam_p F[i] lam_q (mu0 = cos of
half the relative rotation, mu1..mu3 along the local axes):

    e1 = 2 atan2(mu1, mu0)            rotation of q relative to p about x', counted over many turns [rad]
    e2 = 2 (mu0 mu2 - mu1 mu3),   e3 = 2 (mu0 mu3 + mu1 mu2)      misalignment [rad]

So e = f(mu) with mu bilinear in lambda_p and lambda_q; below f_i, f_ij, f_ijk are derivatives with respect to
mu. The screw uses the same functions.
"""

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, GeometryError, arc_tangent
from spacar.elements.rotations.local_frames import axis_frame, rows
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
    mu: Array  # (4, n)
    dmu: Array  # (4, 2, 4, n)
    f_i: Array  # (3, 4, n)


class Turning:
    """e1, e2, e3 of frames (3, 3, n) at q relative to those at p and their derivatives, as `Family` has them."""

    def __init__(self, frame: Array) -> None:
        self._relative = relative_parameters(frame, frame)

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> HingeState:
        """e1 on the branch closest to branch[0]."""
        F, lam = self._relative, x.reshape(2, 4, *x.shape[1:])
        dmu = _einsum("asij...,sj...->asi...", F, lam[::-1])
        mu = _einsum("ai...,i...->a...", dmu[:, 0], lam[0])
        m0, m1 = mu[0], mu[1]
        half_r = 0.5 * (m0 * m0 + m1 * m1)
        f = np.zeros((3, *mu.shape), mu.dtype)
        f[0, 0], f[0, 1] = -m1 / half_r, m0 / half_r
        f[1:] = _einsum("eab,b...->ea...", _MISALIGNMENT, mu)
        e1 = 2.0 * arc_tangent(m1, m0)
        np.add(e1, _TURN * np.round((branch[0] - e1.real) / _TURN), out=e[0])
        e[1:] = _einsum("ea...,a...->e...", f[1:], 0.5 * mu)  # homogeneous quadratic in mu
        _rows(f, dmu, V)
        return HingeState(F, mu, dmu, f)

    def convective_strain(self, c: HingeState, v: Array, out: Array) -> None:
        mu1, _, mu2 = _rates(c, v)
        out[...] = _einsum("ea...,a...->e...", _second(c, mu1), mu1) + _einsum("ea...,a...->e...", c.f_i, mu2)

    def gradient_rate(self, c: HingeState, v: Array, out: Array) -> None:
        mu1, dmu1, _ = _rates(c, v)
        _rows(_second(c, mu1), c.dmu, out)
        out += _einsum("ea...,asi...->esi...", c.f_i, dmu1).reshape(out.shape)

    def rate_gradient(self, c: HingeState, v: Array, out: Array) -> None:
        mu1, dmu1, mu2 = _rates(c, v)
        along = _second(c, mu2)
        along[0, :2] += _third(c, mu1)
        _rows(along, c.dmu, out)
        out += 2.0 * _einsum("ea...,asi...->esi...", _second(c, mu1), dmu1).reshape(out.shape)

    def geometric_stiffness(self, c: HingeState, sigma: Array, out: Array) -> None:
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
        out[...] = H.reshape(out.shape)


def _rows(f: Array, dmu: Array, out: Array) -> None:
    """Write f_a dmu_a for f (3, 4, n)."""
    out[...] = _einsum("ea...,asi...->esi...", f, dmu).reshape(out.shape)


def _rates(c: HingeState, v: Array) -> tuple[Array, Array, Array]:
    """Rates of mu and of its gradient, and second rate of mu at zero accelerations."""
    lam1 = v.reshape(2, 4, *v.shape[1:])
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


class SpatialHinge(Turning, Family):
    """All HINGE elements of a model. Raises GeometryError for a missing or zero axis."""

    definition = "hinge"
    n_coordinates = 8
    frame_p: Array
    n_deformations = 3

    def __init__(self, group: ElementGroup) -> None:
        self._take(group)
        if set(map(len, group.geometry)) != {3}:
            k, count = next((k, len(v)) for k, v in enumerate(group.geometry) if len(v) != 3)
            raise GeometryError(k, f"the axis of rotation needs 3 components, {count} are given")
        frame = axis_frame(np.array(group.geometry).T, 0, "axis of rotation")
        self.frame_p = self.frame_q = rows(frame)
        Turning.__init__(self, frame)

    def parameters(self) -> Array:
        return self.frame_p.T
