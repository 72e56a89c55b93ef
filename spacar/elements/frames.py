"""Local frames of spatial elements in the start configuration (theory-spatial.md section 2).

A frame is an array (3, 3) whose columns are x', y', z'; frames of a group are stacked to (3, 3, n), element
axis last.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from spacar.elements.base import Array, GeometryError

PARALLEL = 1e-5  # smallest sine of the angle between a direction vector and the axis it shall supplement
SHORT = 1e-10  # smallest element length as a fraction of the extent of all elements of the group
EQUAL = 1e-12  # components within this count as equal in `pick`


def pick(ex: Array) -> Array:
    """Standard basis vector at the largest angle with ex (3,); of equals the one with the highest index."""
    size = np.abs(ex)
    e = np.zeros(3)
    e[np.flatnonzero(size <= size.min() + EQUAL)[-1]] = 1.0
    return e


def unit(v: Sequence[float] | Array, index: int, what: str) -> Array:
    """v / |v| (3,). Raises GeometryError for a zero or non-finite vector; `what` names it in the message."""
    a = np.asarray(v, float)
    size = float(np.max(np.abs(a)))
    if not 0.0 < size < np.inf:
        raise GeometryError(index, f"the {what} is the zero vector; give a vector with a direction")
    a = a / size
    return a / np.sqrt(a @ a)


def supplemented(ex: Array, g: Array, index: int, what: str) -> Array:
    """Frame (3, 3) with the given unit x' and y' in the plane of x' and g.

    Raises GeometryError where g is parallel to x' within `PARALLEL`; `what` names g.
    """
    g = unit(g, index, what)
    ey = g - (g @ ex) * ex
    sine = float(np.sqrt(ey @ ey))
    if sine < PARALLEL:
        raise GeometryError(
            index,
            f"the {what} is parallel to the local x' axis (angle {np.degrees(sine):.3g} degrees); "
            "choose another direction",
        )
    ey /= sine
    return np.column_stack((ex, ey, cross(ex, ey)))


def cross(a: Array, b: Array) -> Array:
    """a x b of two vectors (3,): np.cross takes ten times as long, and models are built often."""
    (a0, a1, a2), (b0, b1, b2) = a, b
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])


def chord_frame(ex: Array, direction: Sequence[float] | None, index: int) -> Array:
    """Frame (3, 3) of a BEAM: x' given, y' from the direction vector of the statement or from `pick`."""
    g = pick(ex) if direction is None else np.asarray(direction, float)
    return supplemented(ex, g, index, "direction of the local y' axis")


def axis_frame(axis: Sequence[float], index: int, what: str) -> Array:
    """Frame (3, 3) of a HINGE or SCREW: x' along the axis, y' along x' x pick(x')."""
    ex = unit(axis, index, what)
    ey = unit(cross(ex, pick(ex)), index, what)
    return np.column_stack((ex, ey, cross(ex, ey)))


def chords(d: Array, x: Array) -> tuple[Array, Array]:
    """Lengths (n,) and unit vectors (3, n) of d (3, n) [m]; x (6, n) are the positions of p and q.

    Raises GeometryError for an element shorter than `SHORT` times the extent of the group.
    """
    l = np.sqrt((d * d).sum(0))
    points = x.reshape(2, 3, -1)
    extent = float(np.ptp(points, axis=(0, 2)).max(initial=0.0)) if points.size else 0.0
    bad = np.flatnonzero(~(l > SHORT * extent))
    if bad.size:
        k = int(bad[0])
        raise GeometryError(
            k, f"the length {l[k]:.3g} m between its nodes p and q is zero; check their coordinates"
        )
    return l, d / l


def rows(frames: Array) -> Array:
    """Frames (3, 3, n) as rows x', y', z' one after the other, (n, 9): the layout of the result files."""
    return np.ascontiguousarray(frames.transpose(2, 1, 0).reshape(-1, 9))


def stack(frames: Sequence[Array]) -> Array:
    """Frames (3, 3) of single elements as one array (3, 3, n)."""
    return np.stack(frames, axis=-1) if frames else np.zeros((3, 3, 0))


def section_tensor(frame: Array, j: Array, length: Array) -> Array:
    """Rotary inertia (n, 3, 3) [kg m^2] of bars: R0 J' R0^T times a length (n,).

    frame (3, 3, n); j (n, 4) are Jx'x', Jy'y', Jz'z', Jy'z' per length [kg m]; Jx'y' = Jx'z' = 0.
    """
    J = np.zeros((len(j), 3, 3))
    J[:, [0, 1, 2], [0, 1, 2]] = j[:, :3]
    J[:, [1, 2], [2, 1]] = j[:, 3:4]
    return np.einsum("ian,nab,jbn,n->nij", frame, J, frame, length)
