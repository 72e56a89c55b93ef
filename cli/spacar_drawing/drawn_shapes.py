"""Drawable shapes in space, and the small solids of which pictures are made. Lengths in m, widths in points."""

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index

Colour = str | tuple[float, float, float]


@dataclass(frozen=True)
class Line:
    """A polyline: points (n, 3), or m of them that look alike: (m, n, 3). `layer` orders planar pictures and puts marks
    (layer >= 5) in front of solids."""

    points: Array
    colour: Colour = "#222222"
    width: float = 1.2
    layer: int = 2
    dashes: tuple[float, ...] = ()
    alpha: float = 1.0

    @property
    def pieces(self) -> Array:
        """(pieces, 2, 3) the straight pieces between the points."""
        return np.stack((self.points[..., :-1, :], self.points[..., 1:, :]), axis=-2).reshape(-1, 2, 3)


@dataclass(frozen=True)
class Faces:
    """Polygons with equally many corners: corners (n, k, 3), convex in spatial pictures; one colour or one per polygon
    (n, 3).

    `closed`: they enclose a solid, with corners counter-clockwise as seen from outside, so that those that look away
    from the viewer are never seen.
    """

    corners: Array
    colour: Colour | Array
    edge: Colour | None = None
    alpha: float = 1.0
    layer: int = 1
    light: bool = True
    width: float = 0.6
    closed: bool = False


@dataclass(frozen=True)
class Mark:
    """A round mark of constant size on paper at (3,), or several at (n, 3)."""

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
Key = TypeVar("Key", bound=Hashable)
Item = TypeVar("Item")


def together(items: Iterable[tuple[Key, Item]]) -> dict[Key, list[Item]]:
    """The items by what they have in common, in the order of the first of each kind."""
    found: dict[Key, list[Item]] = {}
    for key, item in items:
        found.setdefault(key, []).append(item)
    return found


def marks_alike(shapes: Sequence[Shape]) -> list[tuple[Mark, Array]]:
    """Marks that look alike: the first of each kind, and where all of them are (n, 3)."""
    kinds = together(((s.size, s.face, s.edge, s.layer), s) for s in shapes if isinstance(s, Mark))
    return [(alike[0], np.concatenate([m.at.reshape(-1, 3) for m in alike])) for alike in kinds.values()]


def unit(v: Array) -> Array:
    """Vectors (..., 3) of length one; zero stays zero."""
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)


def bordered(
    outlines: Array, face: Colour, edge: Colour, width: float, layers: tuple[int, int], alpha: float = 1.0
) -> list[Shape]:
    """Areas of a planar picture, (k, 3) or (n, k, 3), with a line around each; `layers` of both."""
    around = np.concatenate((outlines, outlines[..., :1, :]), axis=-2)
    areas = outlines.reshape(-1, *outlines.shape[-2:])
    return [Faces(areas, face, None, alpha, layers[0], False), Line(around, edge, width, layers[1])]


def arrow_head(tip: Array, base: Array, side: Array, colour: Colour) -> Faces:
    """A triangle from `side` to the one and the other side of its base."""
    return Faces(np.stack((tip, base + side, base - side))[None], colour, None, 1.0, 7, False)


def circle(
    centre: Array, u: Array, v: Array, radius: float, n: int, span: tuple[float, float] = (0.0, 2 * np.pi)
) -> Array:
    """(n, 3) points of a circle, or of the arc between two angles [rad], in the plane of the unit vectors u, v."""
    angle = np.linspace(*span, n)[:, None]
    return centre + radius * (np.cos(angle) * u + np.sin(angle) * v)


def normal_pair(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors normal to an axis (3,) and to each other."""
    axis = unit(axis)
    u = unit(np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))]))
    return u, np.cross(axis, u)


def placed(outline: Array, centre: Array, y: Array, z: Array) -> Array:
    """(..., k, 3) the outline (k, 2) at places (..., 3) with axes y, z."""
    return centre[..., None, :] + outline[:, 0, None] * y[..., None, :] + outline[:, 1, None] * z[..., None, :]


def sweep(outline: Array, centre: Array, y: Array, z: Array) -> Array:
    """Quadrilaterals (... (m - 1) k, 4, 3) of an outline (k, 2) moved along centre (..., m, 3) with axes y, z."""
    rings = placed(outline, centre, y, z)
    near, far = rings[..., :-1, :, :], rings[..., 1:, :, :]
    return np.stack((near, np.roll(near, -1, axis=-2), np.roll(far, -1, axis=-2), far), axis=-2).reshape(-1, 4, 3)


def convex_pieces(outline: Array) -> Index:
    """Corners of the convex pieces of a simple polygon (k, 2), counter-clockwise: itself, or triangles."""
    corners = list(range(len(outline)))

    def turn(a: int, b: int, c: int) -> float:
        u, v = outline[b] - outline[a], outline[c] - outline[b]
        return float(u[0] * v[1] - u[1] * v[0])

    if all(turn(corners[i - 2], corners[i - 1], corners[i]) >= 0 for i in corners):
        return np.array([corners])
    pieces = []
    while len(corners) > 3:
        for i in range(len(corners)):
            a, b, c = corners[i - 1], corners[i], corners[(i + 1) % len(corners)]
            others = [o for o in corners if o not in (a, b, c)]
            if turn(a, b, c) > 0 and not any(min(turn(a, b, o), turn(b, c, o), turn(c, a, o)) >= 0 for o in others):
                break
        else:
            break  # corners on one line: nothing is left to cut
        pieces.append((a, b, c))
        corners.pop(i)
    return np.array([*pieces, tuple(corners[:3])])


def disc_outline(radius: float, n: int = 16) -> Array:
    angle = np.linspace(0.0, 2 * np.pi, n, endpoint=False)
    return radius * np.stack((np.cos(angle), np.sin(angle)), axis=-1)


def solid(
    outline: Array, centre: Array, y: Array, z: Array, colour: Colour | Array, alpha: float = 1.0, light: bool = True,
    hole: Array | None = None, edge: Colour | None = None, ends: NDArray[np.bool_] | None = None,
) -> list[Shape]:  # fmt: skip
    """Swept solids with closed ends, along centre (..., m, 3); with `hole` (k, 2), tubes.

    One colour, or one per piece (..., m - 1, 3); `ends` (..., 2) says which ends are closed, default all.
    """
    look: dict[str, Any] = {"edge": edge, "alpha": alpha, "light": light, "width": 0.3, "closed": hole is None}
    along = np.repeat(colour, len(outline), axis=-2).reshape(-1, 3) if isinstance(colour, np.ndarray) else colour
    shapes: list[Shape] = [Faces(sweep(outline, centre, y, z), along, **look)]
    for end in (0, -1):
        chosen: Any = ... if ends is None else ends[..., end]
        a, b, c = (v[..., end, :][chosen] for v in (centre, y, z))
        if not a.size:
            continue
        if hole is None:
            pieces = convex_pieces(outline)
            corners = placed(outline, a, b, c)[..., pieces, :].reshape(-1, pieces.shape[1], 3)
            corners = corners[:, ::-1] if end == 0 else corners
        else:
            outer, inner = placed(outline, a, b, c), placed(hole, a, b, c)
            corners = np.stack((outer, np.roll(outer, -1, -2), np.roll(inner, -1, -2), inner), axis=-2)
            corners = corners.reshape(-1, 4, 3)
        paint = colour
        if isinstance(colour, np.ndarray):
            own = colour[..., end, :][chosen].reshape(-1, 3)
            paint = np.repeat(own, len(corners) // len(own), axis=0)
        shapes.append(Faces(corners, paint, **look))
    if hole is not None:
        shapes.append(Faces(sweep(hole, centre, y, z), along, None, alpha, light=light))
    return shapes


def cylinder(
    a: Array, b: Array, radius: float, colour: Colour, n: int = 18, alpha: float = 1.0, light: bool = True
) -> list[Shape]:
    """A closed cylinder between two points (3,), in pieces short enough to be sorted by depth."""
    rings = int(np.clip(np.linalg.norm(b - a) / (1.5 * radius), 6, 40)) + 1
    line = np.linspace(a, b, rings)
    u, v = (np.tile(w, (rings, 1)) for w in normal_pair(b - a))
    return solid(disc_outline(radius, n), line, u, v, colour, alpha, light)


def torus(centre: Array, axis: Array, turn: Array, radius: float, tread: float, colour: Colour) -> list[Shape]:
    """A torus about the unit vector axis; `turn` (3,) is a radial direction that turns with it."""
    radial = circle(np.zeros(3), turn, np.cross(axis, turn), 1.0, 37)
    quads = sweep(disc_outline(tread, 10), centre + radius * radial, radial, np.broadcast_to(-axis, radial.shape))
    return [Faces(quads, colour, closed=True)]


def merge_bounds(shapes: Sequence[Shape]) -> tuple[Array, Array] | None:
    """Smallest and largest coordinates (3,) of shapes; None when there are none."""
    parts = [s.points if isinstance(s, Line) else s.corners if isinstance(s, Faces) else s.at for s in shapes]
    if not parts:
        return None
    stacked = np.concatenate([part.reshape(-1, 3) for part in parts])
    return stacked.min(0), stacked.max(0)


def wider(bounds: tuple[Array, Array], shapes: Sequence[Shape]) -> tuple[Array, Array]:
    box = merge_bounds(shapes)
    return bounds if box is None else (np.minimum(bounds[0], box[0]), np.maximum(bounds[1], box[1]))
