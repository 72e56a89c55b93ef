"""Local frames of spatial elements in the start configuration (theory-spatial.md section 2).

A frame is an array (3, 3) whose columns are x', y', z'; frames of a group are (3, 3, n), element axis last. The
functions take one element, without that axis, or a group; `index` is the place of the (first) element in its group.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import GeometryError

# The first is a chosen bound (the reference refuses the same angle): digits of a file, not rounding.
PARALLEL = 1e-5  # smallest sine of the angle between a direction vector and the axis it shall supplement
# Chosen: a real element is longer, nodes meant to be one are nearer.
SHORT = 1e-10  # smallest element length as a fraction of the extent of all elements of the group
# Components of unit vectors are known to a few eps; eps d/l for elements of the length l at the distance d.
EQUAL = 1e-12  # components within this count as equal in `pick`
MODERATE = 1e-140, 1e140  # lengths of vectors whose squares are known to all digits


def pick(ex: Array) -> Array:
    """Standard basis vectors at the largest angle with ex (3, n); of equals those with the highest index."""
    return _BASIS.take((np.abs(ex).T - _PREFERENCE).argmin(-1), 1)


_BASIS, _PREFERENCE = np.eye(3), EQUAL * np.arange(3)


def unit(v: Sequence[float] | Array, index: int, what: str) -> Array:
    """v / |v| (3, n). Raises GeometryError for a zero or non-finite vector; `what` names it in the message."""
    a = np.asarray(v)
    least, most = MODERATE
    if np.abs(a).max() < most:
        square = inner(a, a)
        if square.real.min() > least**2:
            return a / np.sqrt(square)
    size = np.maximum.reduce(np.abs(a))
    if not (np.minimum.reduce(size, None) > 0.0 and np.maximum.reduce(size, None) < np.inf):
        k = index + int(np.flatnonzero(~((size > 0.0) & (size < np.inf)))[0])
        raise GeometryError(k, f"the {what} is the zero vector; give a vector with a direction")
    return normalized(a / size)


def normalized(a: Array) -> Array:
    """a / |a| of vectors (3, n) with components of about 1."""
    return a / np.sqrt(inner(a, a))


def supplemented(ex: Array, g: Sequence[float] | Array, index: int, what: str) -> Array:
    """Frames (3, 3, n) with the given unit x' and y' in the plane of x' and g, both (3, n).

    Raises GeometryError where g is parallel to x' within `PARALLEL`; `what` names g.
    """
    g = np.asarray(g)
    least, most = MODERATE
    longest = 2.0 * np.abs(g).max()  # no |g| is longer
    if longest < most:
        ey = _across(ex, g)
        square = inner(ey, ey)
        if square.real.min() > max(least, PARALLEL * longest) ** 2:
            return completed(ex, ey / np.sqrt(square))
    g = unit(g, index, what)
    ey = _across(ex, g)
    sine = np.sqrt(inner(ey, ey))
    if sine.real.min() < PARALLEL:
        k = int(np.flatnonzero(sine < PARALLEL)[0])
        angle = np.degrees(sine.flat[k])
        raise GeometryError(
            index + k,
            f"the {what} is parallel to the local x' axis (angle {angle:.3g} degrees); choose another direction",
        )
    return completed(ex, ey / sine)


def _across(ex: Array, g: Array) -> Array:
    """The part of vectors g (3, n) across the unit vectors ex (3, n)."""
    return g - inner(g, ex) * ex


def completed(ex: Array, ey: Array) -> Array:
    """Frames (3, 3, n) of x' and y' (3, n)."""
    return np.array((ex, ey, cross(ex, ey))).swapaxes(0, 1)


def inner(a: Array, b: Array) -> Array:
    """a . b of vectors (3, n), in three equal rows: vectors times numbers of the same shape take half the time of a
    product that has to repeat them, and of few the product with ones is faster than `sum`."""
    return _ONES.dot(a * b)


_ONES = np.ones((3, 3))


def cross(a: Array, b: Array) -> Array:
    """a x b of vectors (3, n): np.cross takes ten times as long, and models are built often."""
    return _DIFFERENCE.dot(a.take(_LEFT, 0) * b.take(_RIGHT, 0))


_DIFFERENCE = np.hstack((np.eye(3), -np.eye(3)))
_LEFT, _RIGHT = np.array([1, 2, 0, 2, 0, 1]), np.array([2, 0, 1, 1, 2, 0])


def chord_frame(ex: Array, direction: Sequence[float] | Array | None, index: int) -> Array:
    """Frames (3, 3, n) of BEAMs: x' given, y' from directions (3, n) or, where there are none, from `pick`."""
    if direction is None:
        return completed(ex, normalized(_across(ex, pick(ex))))
    return supplemented(ex, direction, index, "direction of the local y' axis")


def chord_frames(ex: Array, directions: Sequence[Sequence[float] | None]) -> Array:
    """`chord_frame` for x' (3, n) of elements some of which have a direction."""
    if all(directions):
        return chord_frame(ex, columns(directions), 0)  # type: ignore[arg-type]
    if not any(directions):
        return chord_frame(ex, None, 0)
    missing = [not d for d in directions]
    g = np.array([d or (0.0, 0.0, 0.0) for d in directions]).T
    return chord_frame(ex, np.where(missing, pick(ex), g), 0)


def axis_frame(axis: Sequence[float] | Array, index: int, what: str) -> Array:
    """Frames (3, 3, n) of HINGEs or SCREWs: x' along the axes (3, n), y' along x' x pick(x')."""
    ex = unit(axis, index, what)
    return completed(ex, normalized(cross(ex, pick(ex))))


def chords(d: Array, x: Array) -> tuple[Array, Array]:
    """Lengths (n,) and unit vectors (3, n) of d (3, n) [m]; x (6, n) are the positions of p and q.

    Raises GeometryError for an element shorter than `SHORT` times the extent of the group.
    """
    l = np.sqrt(inner(d, d))
    if not l.real.min() > 2.0 * SHORT * np.abs(x).max():  # which is more than the extent
        points = x.real.reshape(2, 3, -1)
        shortest = SHORT * (points.max((0, 2)) - points.min((0, 2))).max()
        for k in np.flatnonzero(~(l[0] > shortest)).tolist():
            text = f"the length {l[0, k]:.3g} m between its nodes p and q is zero; check their coordinates"
            raise GeometryError(k, text)
    return l[0], d / l


def columns(vectors: Sequence[Sequence[float]]) -> Array:
    """Vectors with equally many components as an array, the element axis last."""
    return np.array([*zip(*vectors, strict=True)])


def rows(frames: Array) -> Array:
    """Frames (3, 3, n) as rows x', y', z' one after the other, (n, 9): the layout of the result files."""
    return frames.swapaxes(0, 1).reshape(9, -1).T


def stack(frames: Sequence[Array]) -> Array:
    """Frames (3, 3) of single elements as one array (3, 3, n)."""
    return np.stack(frames, axis=-1) if frames else np.zeros((3, 3, 0))


def section_tensor(frame: Array, j: Array, length: Array) -> Array:
    """Rotary inertia (n, 3, 3) [kg m^2] of bars: R0 J' R0^T times a length (n,).

    frame (3, 3, n); j (n, 4) are Jx'x', Jy'y', Jz'z', Jy'z' per length [kg m]; Jx'y' = Jx'z' = 0.
    """
    J = np.zeros((len(j), 3, 3), j.dtype)
    J[:, [0, 1, 2], [0, 1, 2]] = j[:, :3]
    J[:, [1, 2], [2, 1]] = j[:, 3:4]
    return np.einsum("ian,nab,jbn,n->nij", frame, J, frame, length)
