"""Local frames of spatial elements in the start configuration (theory-spatial.md section 2).

A frame is an array (3, 3) whose columns are x', y', z'; frames of a group are (3, 3, n), element axis last. The
functions take one element, without that axis, or a group; `index` is the place of the (first) element in its group.
"""

from collections.abc import Sequence

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import GeometryError
from spacar.elements.rotations.rotation import cross

# The first is a chosen bound (the reference refuses the same angle): digits of a file, not rounding.
PARALLEL = 1e-5  # smallest sine of the angle between a direction vector and the axis it shall supplement
# Chosen: a real element is longer, nodes meant to be one are nearer.
SHORT = 1e-10  # smallest element length as a fraction of the extent of all elements of the group
# Components of unit vectors are known to a few eps; eps d/l for elements of the length l at the distance d.
EQUAL = 1e-12  # components within this count as equal in `pick`


def pick(ex: Array) -> Array:
    """Standard basis vectors at the largest angle with ex (3, n); of equals those with the highest index."""
    return np.eye(3).take((np.abs(ex).T - EQUAL * np.arange(3)).argmin(-1), 1)


def unit(v: Sequence[float] | Array, index: int, what: str) -> Array:
    """v / |v| (3, n). Raises GeometryError for a zero or non-finite vector; `what` names it in the message."""
    a = np.asarray(v)
    size = np.abs(a).max(0)
    bad = np.flatnonzero(~((size > 0.0) & (size < np.inf)))
    if bad.size:
        text = f"the {what} is the zero vector; give a vector with a direction"
        raise GeometryError(index + int(bad[0]), text)
    return normalized(a / size)  # squares of other numbers may under- or overflow


def normalized(a: Array) -> Array:
    """a / |a| of vectors (3, n) with components of about 1."""
    return np.asarray(a / np.sqrt((a * a).sum(0)))


def supplemented(ex: Array, g: Sequence[float] | Array, index: int, what: str) -> Array:
    """Frames (3, 3, n) with the given unit x' and y' in the plane of x' and g, both (3, n).

    Raises GeometryError where g is parallel to x' within `PARALLEL`; `what` names g.
    """
    g = unit(g, index, what)
    ey = g - (g * ex).sum(0) * ex
    sine = np.sqrt((ey * ey).sum(0))
    parallel = np.flatnonzero(sine.real < PARALLEL)
    if parallel.size:
        angle = np.degrees(sine.real.flat[parallel[0]])
        raise GeometryError(
            index + int(parallel[0]),
            f"the {what} is parallel to the local x' axis (angle {angle:.3g} degrees); choose another direction",
        )
    return completed(ex, ey / sine)


def completed(ex: Array, ey: Array) -> Array:
    """Frames (3, 3, n) of x' and y' (3, n)."""
    return np.array((ex, ey, cross(ex, ey))).swapaxes(0, 1)


def chord_frames(ex: Array, directions: Sequence[Sequence[float] | None]) -> Array:
    """Frames (3, 3, n) of BEAMs: x' (3, n) given, y' from the directions or, where there is none, from `pick`."""
    given = [k for k, direction in enumerate(directions) if direction]
    own = np.array([directions[k] for k in given]).reshape(-1, 3).T
    g = pick(ex).astype(own.dtype)
    g[:, given] = own
    return supplemented(ex, g, 0, "direction of the local y' axis")


def axis_frame(axis: Sequence[float] | Array, index: int, what: str) -> Array:
    """Frames (3, 3, n) of HINGEs or SCREWs: x' along the axes (3, n), y' along x' x pick(x')."""
    ex = unit(axis, index, what)
    return completed(ex, normalized(cross(ex, pick(ex))))


def chords(d: Array, x: Array) -> tuple[Array, Array]:
    """Lengths (n,) and unit vectors (3, n) of d (3, n) [m]; x (6, n) are the positions of p and q.

    Raises GeometryError for an element shorter than `SHORT` times the extent of the group.
    """
    l = np.sqrt((d * d).sum(0))
    points = x.real.reshape(2, 3, -1)
    shortest = SHORT * (points.max((0, 2)) - points.min((0, 2))).max()
    for k in np.flatnonzero(~(l.real > shortest)).tolist():
        raise GeometryError(k, f"the length {l[k]:.3g} m between its nodes p and q is zero; check their coordinates")
    return l, d / l


def rows(frames: Array) -> Array:
    """Frames (3, 3, n) as rows x', y', z' one after the other, (n, 9): the layout of the result files."""
    return frames.swapaxes(0, 1).reshape(9, -1).T


def section_tensor(frame: Array, j: Array, length: Array) -> Array:
    """Rotary inertia (n, 3, 3) [kg m^2] of bars: R0 J' R0^T times a length (n,).

    frame (3, 3, n); j (n, 4) are Jx'x', Jy'y', Jz'z', Jy'z' per length [kg m]; Jx'y' = Jx'z' = 0.
    """
    J = np.zeros((len(j), 3, 3), j.dtype)
    J[:, [0, 1, 2], [0, 1, 2]] = j[:, :3]
    J[:, [1, 2], [2, 1]] = j[:, 3:4]
    return np.einsum("ian,nab,jbn,n->nij", frame, J, frame, length)
