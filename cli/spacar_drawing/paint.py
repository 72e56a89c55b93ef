"""Shapes onto matplotlib axes: projected, sorted from far to near, shaded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.arrays import Array
from spacar_drawing.camera import Camera
from spacar_drawing.drawn_shapes import Faces, Label, Line, Mark, Shape
from spacar_drawing.labels import place_labels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FRONT = 5  # marks from this layer on are drawn over solids
LIGHT = (-0.35, 0.65, 0.68)  # direction of the light in axes right, up, near
DARKEST = 0.55


def paint(axes: Axes, camera: Camera, shapes: Sequence[Shape]) -> list[Any]:
    """Add the shapes to the axes; returns the artists, to be removed before the next frame."""
    artists: list[Any] = _planar(axes, camera, shapes) if camera.planar else _spatial(axes, camera, shapes)
    marks: dict[tuple[object, ...], list[Mark]] = {}
    for mark in (s for s in shapes if isinstance(s, Mark)):
        marks.setdefault((mark.size, mark.face, mark.edge, mark.layer), []).append(mark)
    for alike in marks.values():
        x, y = camera.project(np.concatenate([m.at.reshape(-1, 3) for m in alike])).T
        first = alike[0]
        look: dict[str, Any] = {
            "ms": first.size,
            "mfc": first.face,
            "mec": first.edge,
            "mew": 0.8,
            "zorder": 10 + first.layer,
        }
        artists += axes.plot(x, y, "o", scalex=False, scaley=False, **look)
    return artists + paint_labels(axes, camera, shapes)


def paint_labels(axes: Axes, camera: Camera, shapes: Sequence[Shape]) -> list[Any]:
    """Only the labels among the shapes, beside the others."""
    labels = [s for s in shapes if isinstance(s, Label)]
    return place_labels(axes, camera, labels, shapes) if labels else []


def _planar(axes: Axes, camera: Camera, shapes: Sequence[Shape]) -> list[Any]:
    """Every layer: faces, then lines, in collections of their own."""
    from matplotlib.collections import LineCollection, PolyCollection

    artists: list[Any] = []
    for layer in sorted({s.layer for s in shapes if isinstance(s, Faces)}):
        polygons: list[Array] = []
        faces, edges, widths = [], [], []
        for s in (s for s in shapes if isinstance(s, Faces) and s.layer == layer):
            colour = rgba(s.colour, s.alpha, len(s.corners))
            many = isinstance(s.colour, np.ndarray)  # edges in the colour of the face close the hairlines between them
            closed = colour if many and s.alpha >= 1 else colour * [1, 1, 1, 0]
            polygons.append(camera.project(s.corners))
            faces.append(colour)
            edges.append(rgba(s.edge, 1.0, len(colour)) if s.edge else closed)
            widths.append(np.full(len(colour), s.width if s.edge or (many and s.alpha >= 1) else 0.0))
        face = PolyCollection(
            list(_alike(polygons)),
            facecolors=np.concatenate(faces),
            edgecolors=np.concatenate(edges),
            linewidths=np.concatenate(widths),
        )
        face.set_zorder(10 + layer)
        artists.append(axes.add_collection(face, autolim=False))
    layers = sorted({(s.layer, s.alpha >= 1) for s in shapes if isinstance(s, Line)})
    for layer, opaque in layers:
        lines = [s for s in shapes if isinstance(s, Line) and (s.layer, s.alpha >= 1) == (layer, opaque)]
        collection = LineCollection(
            **_polylines(camera, lines),
            capstyle="round" if opaque else "butt",  # round ends of pale lines would show where two meet
            joinstyle="round",
        )
        collection.set_zorder(10.5 + layer)
        artists.append(axes.add_collection(collection, autolim=False))
    return artists


def _spatial(axes: Axes, camera: Camera, shapes: Sequence[Shape]) -> list[Any]:
    """All faces and pieces of lines in one collection, far ones first (painter's algorithm)."""
    from matplotlib.collections import LineCollection, PolyCollection

    polygons: list[Array] = []
    depths, faces, edges, widths = [], [], [], []
    front: list[Line] = []
    for s in shapes:
        if isinstance(s, Faces):
            colour = rgba(s.colour, s.alpha, len(s.corners))
            if s.light:
                colour[:, :3] *= brightness(camera, s.corners)[:, None]
            polygons.append(camera.project(s.corners))
            depths.append(camera.depth(s.corners).mean(1))
            faces.append(colour)
            # an edge in the colour of the face closes the hairlines between neighbours; with transparency it would show
            edges.append(
                rgba(s.edge, 1.0, len(colour)) if s.edge else colour if s.alpha >= 1 else colour * [1, 1, 1, 0]
            )
            widths.append(np.full(len(colour), s.width if s.edge else 0.4))
        elif isinstance(s, Line):
            if s.layer >= FRONT or s.dashes:
                front.append(s)
                continue
            pieces = np.stack((s.points[..., :-1, :], s.points[..., 1:, :]), axis=-2).reshape(-1, 2, 3)
            colour = rgba(s.colour, s.alpha, len(pieces))
            polygons.append(camera.project(pieces))
            depths.append(camera.depth(pieces).mean(1))
            faces.append(colour * [1, 1, 1, 0])
            edges.append(colour)
            widths.append(np.full(len(pieces), s.width))
    artists: list[Any] = []
    if polygons:
        order = np.argsort(np.concatenate(depths), kind="stable")
        collection = PolyCollection(
            list(_alike(polygons)[order]),
            facecolors=np.concatenate(faces)[order],
            edgecolors=np.concatenate(edges)[order],
            linewidths=np.concatenate(widths)[order],
            joinstyle="round",
        )
        collection.set_zorder(10)
        artists.append(axes.add_collection(collection, autolim=False))
    if front:
        lines = LineCollection(**_polylines(camera, front))
        lines.set_zorder(15)
        artists.append(axes.add_collection(lines, autolim=False))
    return artists


def _polylines(camera: Camera, lines: Sequence[Line]) -> dict[str, Any]:
    """Arguments of a LineCollection."""
    points = [camera.project(s.points).reshape(-1, *s.points.shape[-2:-1], 2) for s in lines]
    look: dict[str, list[Any]] = {"segments": [p for many in points for p in many]}
    look |= {"colors": [], "linewidths": [], "linestyles": []}
    for s, many in zip(lines, points, strict=True):
        look["colors"] += [rgba(s.colour, s.alpha)[0]] * len(many)
        look["linewidths"] += [s.width] * len(many)
        look["linestyles"] += [(0, s.dashes) if s.dashes else "solid"] * len(many)
    return look


def _alike(polygons: Sequence[Array]) -> Any:
    """(n, k, 2) polygons with equally many corners, by repeating the last one: matplotlib takes them in one piece."""
    k = max(p.shape[1] for p in polygons)
    return np.concatenate([np.concatenate((p, np.repeat(p[:, -1:], k - p.shape[1], axis=1)), axis=1) for p in polygons])


def brightness(camera: Camera, corners: Array) -> Array:
    """(n,) between DARKEST and 1 of polygons (n, k, 3): a lamp over the viewer's left shoulder, both sides lit."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    normal *= np.where(normal @ camera.near < 0, -1.0, 1.0)[:, None]
    lamp = np.array(LIGHT) @ np.stack((camera.right, camera.up, camera.near))
    lamp /= np.linalg.norm(lamp)
    return DARKEST + (1 - DARKEST) * np.clip(normal @ lamp, 0.0, 1.0) ** 0.8


def rgba(colour: Any, alpha: float, n: int = 1) -> Array:
    """(n, 4) of one colour, or of an array (n, 3)."""
    from matplotlib.colors import to_rgba, to_rgba_array

    if isinstance(colour, np.ndarray) and colour.ndim == 2:
        rgba = to_rgba_array(colour).astype(float)
        rgba[:, 3] = alpha
        return rgba
    return np.tile(to_rgba(colour, alpha), (n, 1)).astype(float)
