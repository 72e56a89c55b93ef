"""Drawable shapes in space, and the small solids of which pictures are made. Lengths in m, widths in points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array

Colour = str | tuple[float, float, float]


@dataclass(frozen=True)
class Line:
    """A polyline: points (n, 3). `layer` orders planar pictures and puts marks (layer >= 5) in front of solids."""

    points: Array
    colour: Colour = "#222222"
    width: float = 1.2
    layer: int = 2
    dashes: tuple[float, ...] = ()
    alpha: float = 1.0


@dataclass(frozen=True)
class Faces:
    """Polygons with equally many corners: corners (n, k, 3); one colour or one per polygon (n, 3)."""

    corners: Array
    colour: Colour | Array
    edge: Colour | None = None
    alpha: float = 1.0
    layer: int = 1
    light: bool = True
    width: float = 0.6


@dataclass(frozen=True)
class Mark:
    """A round mark of constant size on paper at (3,)."""

    at: Array
    size: float = 3.0
    face: Colour = "#222222"
    edge: Colour = "#222222"
    layer: int = 6


@dataclass(frozen=True)
class Label:
    """Text beside a place (3,)."""

    at: Array
    text: str
    colour: Colour = "#222222"
    boxed: bool = False


Shape = Line | Faces | Mark | Label


def circle(
    centre: Array, u: Array, v: Array, radius: float, n: int = 48, span: tuple[float, float] | None = None
) -> Array:
    """(n, 3) points of a circle, or of the arc between two angles [rad], in the plane of the unit vectors u, v."""
    a, b = span if span is not None else (0.0, 2 * np.pi)
    angle = np.linspace(a, b, n)[:, None]
    return centre + radius * (np.cos(angle) * u + np.sin(angle) * v)


def normal_pair(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors normal to an axis (3,) and to each other."""
    axis = axis / max(float(np.linalg.norm(axis)), 1e-300)
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    u = np.cross(axis, other)
    u /= np.linalg.norm(u)
    return u, np.cross(axis, u)


def sweep(outline: Array, centre: Array, y: Array, z: Array) -> Array:
    """Quadrilaterals ((m - 1) k, 4, 3) of an outline (k, 2) moved along centre (m, 3) with axes y, z (m, 3)."""
    rings = centre[:, None] + outline[:, 0, None] * y[:, None] + outline[:, 1, None] * z[:, None]
    after = np.roll(rings, -1, axis=1)
    quads = np.stack((rings[:-1], after[:-1], after[1:], rings[1:]), axis=2)
    return quads.reshape(-1, 4, 3)


def cap(outline: Array, centre: Array, y: Array, z: Array) -> Array:
    """(1, k, 3) the outline (k, 2) at one place."""
    return (centre + outline[:, :1] * y + outline[:, 1:] * z)[None]


def disc_outline(radius: float, n: int = 16) -> Array:
    angle = np.linspace(0.0, 2 * np.pi, n, endpoint=False)
    return radius * np.stack((np.cos(angle), np.sin(angle)), axis=-1)


def solid(
    outline: Array,
    centre: Array,
    y: Array,
    z: Array,
    colour: Colour | Array,
    alpha: float = 1.0,
    light: bool = True,
    hole: Array | None = None,
    edge: Colour | None = None,
) -> list[Shape]:
    """A swept solid with closed ends; with `hole` (k, 2), a tube. One colour, or one per piece (m - 1, 3)."""
    k = len(outline)
    along = np.repeat(colour, k, axis=0) if isinstance(colour, np.ndarray) else colour
    shapes: list[Shape] = [Faces(sweep(outline, centre, y, z), along, edge, alpha, light=light, width=0.3)]
    for end, at in ((0, 0), (-1, -1)):
        paint: Colour = (colour[end][0], colour[end][1], colour[end][2]) if isinstance(colour, np.ndarray) else colour
        if hole is None:
            shapes.append(Faces(cap(outline, centre[at], y[at], z[at]), paint, edge, alpha, light=light, width=0.3))
        else:
            ring = np.stack((outline, np.roll(outline, -1, 0), np.roll(hole, -1, 0), hole), axis=1)
            corners = centre[at] + ring[..., :1] * y[at] + ring[..., 1:] * z[at]
            shapes.append(Faces(corners, paint, edge, alpha, light=light))
    if hole is not None:
        shapes.append(Faces(sweep(hole, centre, y, z), along, None, alpha, light=light))
    return shapes


def cylinder(
    a: Array, b: Array, radius: float, colour: Colour, n: int = 18, alpha: float = 1.0, light: bool = True
) -> list[Shape]:
    """A closed cylinder between two points (3,), in pieces short enough to be sorted by depth."""
    u, v = normal_pair(b - a)
    rings = int(np.clip(np.linalg.norm(b - a) / (1.5 * radius), 6, 40)) + 1
    m = np.ones((rings, 1))
    line = a + np.linspace(0.0, 1.0, rings)[:, None] * (b - a)
    return solid(disc_outline(radius, n), line, m * u, m * v, colour, alpha, light)


def torus(
    centre: Array, axis: Array, turn: Array, radius: float, tread: float, colour: Colour, n: int = 36
) -> list[Shape]:
    """A torus about the unit vector axis; `turn` (3,) is a radial direction that turns with it."""
    u = turn
    v = np.cross(axis, u)
    angle = np.linspace(0.0, 2 * np.pi, n + 1)[:, None]
    radial = np.cos(angle) * u + np.sin(angle) * v
    quads = sweep(disc_outline(tread, 10), centre + radius * radial, radial, np.broadcast_to(axis, radial.shape))
    return [Faces(quads, colour)]


def merge_bounds(shapes: Sequence[Shape]) -> tuple[Array, Array] | None:
    """Smallest and largest coordinates (3,) of shapes; None when there are none."""
    parts = []
    for s in shapes:
        if isinstance(s, Line):
            parts.append(s.points)
        elif isinstance(s, Faces):
            parts.append(s.corners.reshape(-1, 3))
        else:
            parts.append(s.at[None])
    if not parts:
        return None
    stacked = np.concatenate(parts)
    return stacked.min(0), stacked.max(0)
