"""The true elastic line of a beam: Hermite cubic through both ends, with the shear deflection added.

Centre line r(xi) = sum N_k(xi) y_k, y = (x_p, l0 t_p, x_q, l0 t_q), t the directions normal to the end sections
(theory-planar.md 3.4 (9), theory-spatial.md 3.6). With shear flexibility the sections are not normal to the centre
line; the exact shape functions of a Timoshenko beam without distributed load are (N_k + Phi L_k)/(1 + Phi) with
L = (1 - xi, (xi - xi^2)/2, xi, -(xi - xi^2)/2) and Phi = 12 EI/(GAk l0^2). The difference to the cubic,
Phi/(1 + Phi) sum (L_k - N_k) y_k, is taken in each of the two bending directions with its own Phi.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array


def shape_functions(xi: Array) -> tuple[Array, Array]:
    """N and L, each (4, n), at xi (n,) from 0 to 1."""
    s2, s3, b = xi**2, xi**3, 0.5 * (xi - xi**2)
    N = np.stack((1 - 3 * s2 + 2 * s3, xi - 2 * s2 + s3, 3 * s2 - 2 * s3, s3 - s2))
    L = np.stack((1 - xi, b, xi, -b))
    return N, L


def elastic_line(ends: Array, tangents: Array, l0: Array | float, across: Array, Phi: Array, n: int) -> Array:
    """(..., n, 3) points of elastic lines [m]; any number of beams in the leading axes.

    ends (..., 2, 3) x_p, x_q [m]; tangents (..., 2, 3) unit vectors normal to the end sections; l0 (...) undeformed
    length [m]; across (..., 2, 3) unit vectors of the bending directions y', z'; Phi (..., 2) shear parameters of
    bending along y', z'.
    """
    N, L = shape_functions(np.linspace(0.0, 1.0, n))
    slopes = np.asarray(l0)[..., None, None] * tangents
    y = np.stack((ends[..., 0, :], slopes[..., 0, :], ends[..., 1, :], slopes[..., 1, :]), axis=-2)
    points = N.T @ y
    if np.any(Phi):
        shear = (L - N).T @ y
        for k in (0, 1):
            direction, value = across[..., k, :], Phi[..., k]
            share = (value / (1.0 + value))[..., None, None]
            points = points + share * (shear @ direction[..., :, None]) * direction[..., None, :]
    return points


def section_axes(points: Array, y_p: Array, y_q: Array, slopes: Array | None = None) -> tuple[Array, Array]:
    """y', z' (..., n, 3) along lines of points (..., n, 3), y' normal to the line.

    It turns linearly from y_p to y_q (..., 3); with `slopes` (..., 2) [rad], twist rates at the ends times the length,
    as the cubic with these slopes (theory-warping.md section 3).
    """
    tangent = _unit(np.gradient(points, axis=-2))
    xi = np.linspace(0.0, 1.0, points.shape[-2])[:, None]
    y = (1 - xi) * y_p[..., None, :] + xi * y_q[..., None, :]
    y = _unit(y - np.sum(y * tangent, axis=-1, keepdims=True) * tangent)
    z = np.cross(tangent, y)
    if slopes is not None:
        last, first = y[..., -1, :], (y[..., 0, :], z[..., 0, :])
        twist = np.arctan2(np.sum(last * first[1], axis=-1), np.sum(last * first[0], axis=-1))[..., None, None]
        p, q = slopes[..., 0, None, None], slopes[..., 1, None, None]
        cubic = twist * (3 * xi**2 - 2 * xi**3) + p * (xi - 2 * xi**2 + xi**3) + q * (xi**3 - xi**2)
        more = cubic - twist * xi
        y, z = np.cos(more) * y + np.sin(more) * z, np.cos(more) * z - np.sin(more) * y
    return y, z


def chord_axes(ends: Array, y_p: Array, y_q: Array) -> Array:
    """(..., 2, 3) y', z' normal to the chords of ends (..., 2, 3), midway between the ends: the directions in which the
    shear part acts."""
    d = _unit(ends[..., 1, :] - ends[..., 0, :])
    y = y_p + y_q
    y = _unit(y - np.sum(y * d, axis=-1, keepdims=True) * d)
    return np.stack((y, np.cross(d, y)), axis=-2)


def _unit(v: Array) -> Array:
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)
