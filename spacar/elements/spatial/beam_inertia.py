"""Translational inertia of a bar on its cubic centre line (theory-spatial.md section 3.6).

Hermite interpolation with the end tangents l0 x'_p, l0 x'_q: r(s) = sum N_a y_a, y = [x_p, l0 R(lam_p) x',
x_q, l0 R(lam_q) x']. With J_y = dy/dx and ddy = J_y ddx + (convective part 2 l0 R(dlam/dt) x')

    M = J_y^T (C (x) I3) J_y,     M a + h = J_y^T w,     w = (C (x) I3) ddy.

A pipe adds forces w = D dy + A y with constant matrices of its own (section 10).
"""

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.rotations.rotation import director_tensor

_einsum = np.einsum
HERMITE_MASS = (
    np.array([[156.0, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420.0
)  # integral of N_a N_b over the unit length


class LineConstants(NamedTuple):
    """Constants of bars, element axis last.

    K     (2, 3, 4, 4, n) director tensors of x' at p and q with the factor l0 [m]
    C     (4, 4, n) mass matrix of y [kg]
    D, A  (4, 4, n) matrices of dy/dt and y of a fluid [kg/s], [kg/s^2]; None for a bar
    """

    K: Array
    C: Array
    D: Array | None = None
    A: Array | None = None


class LineState(NamedTuple):
    """Bars at x: l0 R x' and l0 B_x' at p and q."""

    p: LineConstants
    x: Array  # (2, 7, n)
    B: Array  # (2, 3, 4, n)


def line_constants(axis_p: Array, axis_q: Array, l0: Array, mass: Array) -> LineConstants:
    """Constants of bars with the tangents axis_p, axis_q (3, n), length l0 (n,) [m], mass (n,) [kg/m]."""
    K = np.ascontiguousarray(l0 * director_tensor(np.stack((axis_p, axis_q), axis=1)).transpose(3, 0, 1, 2, 4))
    return LineConstants(K, HERMITE_MASS[..., None] * (mass * l0))


def line_state(p: LineConstants, x: Array) -> LineState:
    """State at x (14, n)."""
    x7 = x.reshape(2, 7, *x.shape[1:])
    return LineState(p, x7, _einsum("sijk...,sk...->sij...", p.K, x7[:, 3:]))


def line_mass(c: LineState, out: Array) -> None:
    """Write M (14, 14, n)."""
    C = c.p.C.reshape(2, 2, 2, 2, *c.p.C.shape[2:])  # [node, position or tangent, node, position or tangent]
    view = out.reshape(2, 7, 2, 7, *out.shape[2:])
    for i in range(3):
        view[:, i, :, i] = C[:, 0, :, 0]
    mixed = (C[:, 0, :, 1, None, None] * c.B).swapaxes(1, 2)  # (2, 3, 2, 4, n)
    view[:, :3, :, 3:] = mixed
    view[:, 3:, :, :3] = mixed.swapaxes(0, 2).swapaxes(1, 3)
    CB = C[:, 1, :, 1, None, None] * c.B
    view[:, 3:, :, 3:] = _einsum("sij...,stik...->sjtk...", c.B, CB)


def _forces(c: LineState, v7: Array, a7: Array | None) -> Array:
    """w (2, 2, 3, n) [node, dual to position or tangent]."""
    p = c.p
    lam1 = v7[:, 3:]
    y2 = np.zeros((2, 2, 3, *v7.shape[2:]), np.result_type(c.B, v7))
    B1 = _einsum("sijk...,sk...->sij...", p.K, lam1)
    y2[:, 1] = _einsum("sij...,sj...->si...", B1, lam1)
    if a7 is not None:
        y2[:, 0] = a7[:, :3]
        y2[:, 1] += _einsum("sij...,sj...->si...", c.B, a7[:, 3:])
    w = _einsum("ab...,bi...->ai...", p.C, y2.reshape(4, *y2.shape[2:]))
    if p.D is not None:
        y1 = np.zeros_like(y2)
        y1[:, 0] = v7[:, :3]
        y1[:, 1] = _einsum("sij...,sj...->si...", c.B, lam1)
        w += _einsum("ab...,bi...->ai...", p.D, y1.reshape(4, *y2.shape[2:]))
    if p.A is not None:
        y = np.zeros_like(y2)
        y[:, 0] = c.x[:, :3]
        y[:, 1] = _einsum("sij...,sj...->si...", c.B, 0.5 * c.x[:, 3:])
        w += _einsum("ab...,bi...->ai...", p.A, y.reshape(4, *y2.shape[2:]))
    return np.asarray(w).reshape(y2.shape)


def line_force(c: LineState, v: Array, a: Array | None) -> Array:
    """M a + h (14, n)."""
    v7 = v.reshape(c.x.shape)
    w = _forces(c, v7, None if a is None else a.reshape(c.x.shape))
    f = np.empty(v7.shape, w.dtype)
    f[:, :3] = w[:, 0]
    f[:, 3:] = _einsum("sij...,si...->sj...", c.B, w[:, 1])
    return f.reshape(v.shape)


def line_gradient(c: LineState, v: Array, a: Array) -> tuple[Array, Array]:
    """d(M a + h)/dx and d(M a + h)/dv, each (14, 14, n)."""
    p = c.p
    v7, a7 = v.reshape(c.x.shape), a.reshape(c.x.shape)
    w = _forces(c, v7, a7)
    B1 = _einsum("sijk...,sk...->sij...", p.K, v7[:, 3:])
    B2 = _einsum("sijk...,sk...->sij...", p.K, a7[:, 3:])
    # variations of ddy, dy, y: tangents through lambda, positions directly
    wx = _tangent_columns(p.C, B2)
    wv = _tangent_columns(p.C, 2.0 * B1)
    if p.D is not None:
        wx += _tangent_columns(p.D, B1)
        wv += _tangent_columns(p.D, c.B) + _position_columns(p.D, c.B)
    if p.A is not None:
        wx += _tangent_columns(p.A, c.B) + _position_columns(p.A, c.B)
    fx, fv = _to_rows(c, wx), _to_rows(c, wv)
    wK = _einsum("si...,sijk...->sjk...", w[:, 1], p.K)  # J_y^T depends on lambda
    for s in range(2):
        fx[s, 3:, s, 3:] += wK[s]
    shape = (14, 14, *v.shape[1:])
    return fx.reshape(shape), fv.reshape(shape)


def _tangent_columns(C: Array, B: Array) -> Array:
    """(C (x) I3) diag(0, B) as (2, 2, 3, 2, 7, n) [node, part, component; node, coordinate]."""
    tail = B.shape[3:]
    C4 = C.reshape(2, 2, 2, 2, *C.shape[2:])
    out = np.zeros((2, 2, 3, 2, 7, *tail), B.dtype)
    out[:, :, :, :, 3:] = _einsum("sat...,tij...->saitj...", C4[:, :, :, 1], B)
    return out


def _position_columns(C: Array, like: Array) -> Array:
    """(C (x) I3) diag(I, 0) in the layout of `_tangent_columns`."""
    C4 = C.reshape(2, 2, 2, 2, *C.shape[2:])
    out = np.zeros((2, 2, 3, 2, 7, *like.shape[3:]), like.dtype)
    for i in range(3):
        out[:, :, i, :, i] = C4[:, :, :, 0]
    return out


def _to_rows(c: LineState, w: Array) -> Array:
    """J_y^T w (2, 7, 2, 7, n)."""
    f = np.empty((2, 7, *w.shape[3:]), w.dtype)
    f[:, :3] = w[:, 0]
    f[:, 3:] = _einsum("sij...,sitk...->sjtk...", c.B, w[:, 1])
    return f
