"""Wheels on the flat ground z = 0, keywords WHEEL (disk) and TWHEEL (torus) (theory-spatial.md section 8).

Coordinates x_p (3, centre), lambda_p (4), x_q (3, contact point). With the spin axis a = R a0, n = (0, 0, 1),
d = x_q - x_p, the transverse radius rho (0 for a disk), r = d + rho n from the centre to the centre of the tread circle:

    e1 = |r| - r0   radial [m]            e3 = z of x_q     height above the ground [m]
    e2 = a.r        axial [m]             e4 = r.(a x n)    the contact is the lowest point [m]
    de5/dt = t.(dx_p + w x d), t = r x a  longitudinal slip, |t| = r0
    de6/dt = s.(dx_q - rho w x n), s = n x t                lateral slip, |s| = r0 while upright

The slips are rates only: e5 = e6 = 0, and their rows W of V are no gradients (`slip_hessian`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spacar.elements.base import Array, ElementGroup, Family, GeometryError, Trouble
from spacar.elements.frames import rows, stack, unit
from spacar.elements.hinge import diagonal
from spacar.elements.rotation import cross, director_tensor, expand, global_matrix

_einsum = np.einsum
UP = np.array([0.0, 0.0, 1.0])
START = 1e-4  # largest error of the given contact point as a fraction of the radius
LEFT = 1e-6  # largest height of the contact point over the ground as a fraction of the radius
FLAT = 1e-3  # smallest sine of the angle between spin axis and vertical


class WheelState(NamedTuple):
    """Vectors of the wheels at x."""

    K: Array  # (3, 4, 4, n) director tensor of a0
    rho: Array  # (n,)
    lam: Array  # (4, n)
    d: Array  # (3, n)
    B: Array  # (3, 4, n) da/dlam
    a: Array  # (3, n)
    r: Array  # (3, n)
    l: Array  # (n,) |r|
    G: Array  # (3, 4, n) w = G dlam
    t: Array  # (3, n)
    s: Array  # (3, n)


class WheelRates(NamedTuple):
    """Rates for velocities v at zero accelerations."""

    lam: Array  # (4, n)
    p: Array  # (3, n) dx_p
    q: Array  # (3, n) dx_q
    d: Array  # (3, n)
    B: Array  # (3, 4, n)
    a: Array  # (3, n)
    a2: Array  # (3, n) second rate of a
    n1: Array  # (3, n) rate of r/|r|
    w: Array  # (3, n)
    t: Array  # (3, n)


def around(v: Array) -> Array:
    """n x v for the vertical n; v x n is its opposite."""
    return np.stack((-v[1], v[0], np.zeros_like(v[0])))


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(_einsum("i...,i...->...", a, b))


def _down(B: Array, w: Array) -> Array:
    """B^T w."""
    return np.asarray(_einsum("ai...,a...->i...", B, w))


def wheel_state(K: Array, rho: Array, x: Array) -> WheelState:
    """State at x (10, n)."""
    lam, d = x[3:7], x[7:] - x[:3]
    B = _einsum("ijk...,k...->ij...", K, lam)
    a = _einsum("ij...,j...->i...", B, 0.5 * lam)
    r = d.copy()
    r[2] += rho
    t = cross(r, a)
    return WheelState(K, rho, lam, d, B, a, r, np.sqrt(_dot(r, r)), 2.0 * global_matrix(lam), t, around(t))


def wheel_rates(c: WheelState, v: Array) -> WheelRates:
    """Rates for v (10, n)."""
    lam, d = v[3:7], v[7:] - v[:3]
    B = _einsum("ijk...,k...->ij...", c.K, lam)
    a = _einsum("ij...,j...->i...", c.B, lam)
    n = c.r / c.l
    n1 = (d - _dot(n, d) * n) / c.l
    w = _einsum("ij...,j...->i...", c.G, lam)
    t = cross(d, c.a) + cross(c.r, a)
    return WheelRates(lam, v[:3], v[7:], d, B, a, _einsum("ij...,j...->i...", B, lam), n1, w, t)


def slip_hessian(c: WheelState) -> Array:
    """H[e, i, j] = dW_e,i/dx_j of the two slips, (2, 10, 10, n); not symmetric in i, j."""
    at, y = _along_coordinates(c)
    a, r, t, s, d, G, rho, B = at.a, at.r, at.t, at.s, at.d, at.G, at.rho, at.B
    yd, ylam = y[7:] - y[:3], y[3:7]
    da = _einsum("ij...,j...->i...", B, ylam)
    dt = cross(yd, a) + cross(r, da)
    ds = around(dt)
    dG = 2.0 * global_matrix(ylam)
    H = np.zeros((2, 10, *da.shape[1:]), da.dtype)
    H[0, :3] = dt
    H[0, 3:7] = _down(dG, cross(d, t)) + _down(G, cross(yd, t) + cross(d, dt))
    H[1, 3:7] = -rho * (_down(dG, around(s)) + _down(G, around(ds)))
    H[1, 7:] = ds
    return H


def slip_rate_gradient(c: WheelState, k: WheelRates) -> Array:
    """Gradient of the slip accelerations at zero accelerations, (2, 10, n)."""
    at, y = _along_coordinates(c)
    k = WheelRates(*(part[..., None, :] if part.ndim == 2 else part[:, :, None] for part in k)) if False else _insert(k)
    yd, ylam = y[7:] - y[:3], y[3:7]
    da = _einsum("ij...,j...->i...", at.B, ylam)
    dt = cross(yd, at.a) + cross(at.r, da)
    dt1 = cross(k.d, da) + cross(yd, k.a) + cross(at.r, _einsum("ij...,j...->i...", k.B, ylam))
    dw = 2.0 * _einsum("ij...,j...->i...", global_matrix(ylam), k.lam)
    out = np.empty((2, *dt.shape[1:]), dt.dtype)
    out[0] = _dot(dt1, k.p + cross(k.w, at.d)) + _dot(k.t, cross(dw, at.d) + cross(k.w, yd))
    out[0] += _dot(dt, cross(k.w, k.d)) + _dot(at.t, cross(dw, k.d))
    out[1] = _dot(around(dt1), k.q + at.rho * around(k.w)) + at.rho * _dot(around(k.t), around(dw))
    return out


