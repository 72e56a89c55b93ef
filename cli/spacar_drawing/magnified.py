"""Deflections enlarged: configurations that lie further away from the start than the computed ones.

Positions and planar angles: x0 + f (x - x0). Euler parameters: the rotation from the start, exp(f theta), with theta
its rotation vector, q = (cos f|theta|/2, sin f|theta|/2 theta/|theta|) o q0 (theory-spatial.md section 1). For small
deflections both are what a linear theory enlarges; of a large one f = 1 alone is the truth.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.scene import Scene


def start_of(source: PictureSource) -> Array:
    """(nx,) the coordinates at the start. Raises UsageError for a result that does not hold them."""
    return np.ravel(stored(source, "X0", "the coordinates at the start"))


def stored(source: PictureSource, name: str, what: str) -> Array:
    """A table of the header. Raises UsageError when the result was written before there was such a table."""
    if name not in source.header:
        raise UsageError(
            f"{source.name} does not hold {what} ({name.lower()}): an earlier version wrote it; run the analysis again",
            "draw.missing",
        )
    return np.asarray(source.header[name], float)


def magnified(scene: Scene, x0: Array, x: Array, factor: float) -> Array:
    """(nx,) the configuration whose deflection from x0 is `factor` times that of x."""
    y = x0 + factor * (np.ravel(x) - x0)
    if scene.planar:
        return y
    rows = scene.lnp[scene.orientation_nodes - 1] - 1
    q0, q = x0[rows], np.ravel(x)[rows]
    turn = product(q, q0 * [1, -1, -1, -1])
    turn = turn * np.where(turn[:, :1] < 0, -1.0, 1.0)  # the shorter way round
    sine = np.linalg.norm(turn[:, 1:], axis=1, keepdims=True)
    angle = factor * np.arctan2(sine, turn[:, :1])
    axis = turn[:, 1:] / np.maximum(sine, 1e-300)
    y[rows] = product(np.concatenate((np.cos(angle), np.sin(angle) * axis), axis=1), q0)
    return y


def product(a: Array, b: Array) -> Array:
    """(n, 4) products of quaternions: the rotation b, then a."""
    s, t, u, v = a[:, :1], b[:, :1], a[:, 1:], b[:, 1:]
    scalar = s * t - np.sum(u * v, axis=1, keepdims=True)
    return np.concatenate((scalar, s * v + t * u + np.cross(u, v)), axis=1)
