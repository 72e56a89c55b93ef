"""Deformations of the spatial beam in the angle measure by its fourteen coordinates, and their derivatives.

The formulas are in `angle_measure`. x holds position (3) and Euler parameters (4) of the ends p and q; what comes in
the local coordinates L_p, L_q, d of that module goes to x with L = C lam and d = x_q - x_p. Second and third
derivatives come from power series along a line, or in the directions of the inner quantities (`taylor`).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.rotations.rotation import _DIRECTOR, identity, parameters_of_frame, right_product
from spacar.elements.spatial.angle_measure import (
    RELATIVE,
    AngleConstants,
    Inner,
    by_local,
    deformations,
    gradient,
    inner,
    inner_rows,
    outer,
    outer_gradient,
    rotation_factor,
)  # fmt: skip
from spacar.elements.spatial.taylor import Taylor, composed, contracted, stacked


class AngleState(NamedTuple):
    """What later calls at the same x reuse."""

    p: AngleConstants
    L: Array  # (2, 4, n)
    d: Array  # (3, n)
    inner: Inner
    G: Array  # (4, n): G and its derivatives by mu0
    E: Array  # (8, 6, n): derivatives of e by y, with warping (10, 8, n): by y and w


Gradient = Callable[[AngleConstants, Any, Any, Any], Any]  # of y, G and its derivative


def state(p: AngleConstants, x: Array, gradient: Gradient = gradient) -> AngleState:
    """The state at x (14, n)."""
    x7 = x.reshape(2, 7, *x.shape[1:])
    L = np.einsum("sij...,sj...->si...", p.C, x7[:, 3:])
    d = x7[1, :3] - x7[0, :3]
    c = inner(L, d)
    G = rotation_factor(c.y[0])
    return AngleState(p, L, d, c, G, gradient(p, c.y, G[0], G[1]))


def values(c: AngleState) -> Array:
    """The deformations (6, n)."""
    return np.asarray(deformations(c.p, c.inner.y, c.G[0]))


def along_line(c: AngleState, v: Array, terms: int) -> tuple[Inner, Any, Any]:
    """Inner quantities, G and its derivative as series of `terms` coefficients along v (14, n)."""
    v7 = v.reshape(2, 7, *v.shape[1:])
    L1 = np.einsum("sij...,sj...->si...", c.p.C, v7[:, 3:])
    d1 = v7[1, :3] - v7[0, :3]
    zero = [np.zeros_like(L1)] * (terms - 2), [np.zeros_like(d1)] * (terms - 2)
    along = inner(Taylor([c.L, L1, *zero[0]]), Taylor([c.d, d1, *zero[1]]))
    mu0 = along.y[0]
    return along, composed(mu0, *c.G[:3]), composed(mu0, *c.G[1:])


def rows(c: AngleState, local: Array, out: Array) -> None:
    """Write rows by the local coordinates, (6, 11, n), as rows by x to out (6, 14, n)."""
    out[:, 3:7] = np.einsum("ei...,ij...->ej...", local[:, 0:4], c.p.C[0])
    out[:, 10:14] = np.einsum("ei...,ij...->ej...", local[:, 4:8], c.p.C[1])
    out[:, 7:10] = local[:, 8:]
    np.negative(local[:, 8:], out=out[:, 0:3])


def first(c: AngleState, out: Array) -> None:
    """V (6, 14, n)."""
    rows(c, np.einsum("ye...,yj...->ej...", c.E, inner_rows(c.inner)), out)


def second_rate(c: AngleState, v: Array) -> Array:
    """H(v, v) (6, n)."""
    along, G, _ = along_line(c, v, 3)
    return np.asarray(2.0 * deformations(c.p, along.y, G).c[2])


def derivative_of_rows(c: AngleState, v: Array, order: int, out: Array) -> None:
    """d^order V/ds^order along v, order 1 (H1) or 2 (T), (6, 14, n)."""
    along, G, G1 = along_line(c, v, order + 1)
    local = contracted("ye...,yj...->ej...", gradient(c.p, along.y, G, G1), inner_rows(along))
    rows(c, order * local.c[order], out)


def rotation_rows(c: AngleState) -> Array:
    """dpsi/dx, (3, 14, n)."""
    Dy = inner_rows(c.inner)
    local = Dy[1:4] * c.G[0] + (c.inner.y[1:4] * c.G[1])[:, None] * Dy[0]
    out = np.zeros((3, 14, *local.shape[2:]), local.dtype)
    rows(c, local, out)
    return out


def hessian(c: AngleState, sigma: Array, out: Array) -> None:
    """sum_k sigma_k d2(e_k) (14, 14, n)."""
    y = c.inner.y
    tail = y.shape[1:]
    directions = identity(8, len(tail))
    line = Taylor([y[:, None], directions])
    mu0 = line[0]
    G = c.G[:, None]
    along, along1 = composed(mu0, *G[:2]), composed(mu0, *G[1:3])
    E = contracted("e...,ei...->i...", sigma, outer_gradient(c.p, line, along))  # of the sum
    curvature = stacked(by_local(E[None], line, along, along1)).c[1][:, 0]
    write_hessian(c, curvature, np.einsum("ye...,e...->y...", c.E, sigma), out)


def write_hessian(c: AngleState, curvature: Array, force: Array, out: Array) -> None:
    """The second derivative (14, 14, n) by x of a sum with the derivatives force (8, n), curvature (8, 8, n) by y."""
    y = c.inner.y
    tail = y.shape[1:]
    Dy = inner_rows(c.inner)
    H = np.einsum("yi...,yj...->ij...", Dy, np.einsum("yb...,bj...->yj...", curvature, Dy))
    # the stresses times the second derivatives of the inner quantities
    relative = np.einsum("a...,aij->ij...", force[0:4], RELATIVE)
    H[0:4, 4:8] += relative
    H[4:8, 0:4] += relative.swapaxes(0, 1)
    K = np.einsum("mjki,i...->mjk...", _DIRECTOR, force[4:7])
    of_s = np.einsum("mjk...,m...->jk...", K, c.d)
    mixed = np.einsum("mjk...,k...->jm...", K, c.L[0] + c.L[1])
    for a in (slice(0, 4), slice(4, 8)):
        H[a, 0:4] += of_s
        H[a, 4:8] += of_s
        H[a, 8:] += mixed
        H[8:, a] += mixed.swapaxes(0, 1)
    n = c.inner.n
    H[8:, 8:] += force[7] / y[7] * (identity(3, len(tail)) - n[:, None] * n)
    _of_local(c, H, out)


def _of_local(c: AngleState, H: Array, out: Array) -> None:
    """H (11, 11, n) by the local coordinates as one by x."""
    kept = ((slice(0, 4), slice(3, 7), 0), (slice(4, 8), slice(10, 14), 1))
    for here, there, s in kept:
        half = np.einsum("ij...,ik...->jk...", c.p.C[s], H[here])
        out[there, 7:10] = half[:, 8:]
        out[7:10, there] = half[:, 8:].swapaxes(0, 1)
        for other, place, t in kept:
            out[there, place] = np.einsum("ij...,jk...->ik...", half[:, other], c.p.C[t])
    out[7:10, 7:10] = H[8:, 8:]
    out[0:3, 3:] = -out[7:10, 3:]
    out[3:, 0:3] = -out[3:, 7:10]
    out[0:3, 0:3] = H[8:, 8:]


def orientations(frame_p: Array, frame_q: Array) -> Array:
    """C (2, 4, 4, n): lam o r of the start frames (3, 3, n); r_q has the sign for which mu0 > 0 at the start."""
    r_p, r_q = parameters_of_frame(frame_p), parameters_of_frame(frame_q)
    r_q = r_q * np.where((r_p * r_q).sum(0) < 0.0, -1.0, 1.0)
    return np.stack((right_product(r_p), right_product(r_q)))


def chord_of_arc(C: Array, x0: Array) -> Array:
    """Length of the chord as a fraction of that of the arc, from the start frames (section 2.5), (n,)."""
    n = x0.shape[1]
    one = np.ones(n)
    p = AngleConstants(C, one, one, 0.0 * one, np.ones((2, n)), np.zeros((2, n)), np.zeros((2, n)))
    c = state(p, x0)
    o = outer(p, c.inner.y, c.G[0])
    return np.asarray(1.0 - (o.psi[1] ** 2 + o.psi[2] ** 2) / 24.0 - (o.Ay**2 + o.Az**2) / 40.0)
