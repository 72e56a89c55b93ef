"""Shapes onto matplotlib axes: projected, sorted from far to near, shaded.

Numbers beside nodes and elements, moved so that they neither overlap each other nor cover the mechanism.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.arrays import Array
from spacar_drawing.drawn_shapes import Faces, Label, Line, Shape, marks_alike, together, unit
from spacar_drawing.stage import Camera

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS = 8.0  # size of the letters
DIRECTIONS = np.array([(np.cos(a), np.sin(a)) for a in np.pi * np.array([0.25, 0.75, 1.25, 1.75, 0.5, 1.5, 0.0, 1.0])])
RINGS = np.repeat([1.0, 1.7, 2.6], len(DIRECTIONS))  # distance of the candidate places, nearest first
AROUND = np.tile(DIRECTIONS, (3, 1))  # and their directions
OUTSIDE = 1e3  # what a place outside of the axes, among their numbers, counts: more than all that a label can cover
DOTS = 60  # of a line, that a label may cover
MOST_LABELS = 60  # of nodes, and of elements, that are shown: more cannot be read


def thin(labels: Sequence[Label]) -> tuple[list[Label], int]:
    """Of the labels of one kind the first, the last and every k-th; k is 1, 2, 5, 10 ..., so that few enough stay."""
    for k in (m * 10**e for e in range(9) for m in (1, 2, 5)):
        if len(labels) <= k * MOST_LABELS:
            return [label for i, label in enumerate(labels, 1) if i % k == 0 or i in (1, len(labels))], k
    raise AssertionError("so many labels do not fit in a memory")


def place_labels(axes: Axes, camera: Camera, labels: Sequence[Label], shapes: Sequence[Shape]) -> list[Any]:
    """Put every label inside the axes where it covers least of the lines, of numbers along the axes and notes, and of
    the labels before it; many labels are thinned out."""
    from matplotlib.patheffects import withStroke

    scale = axes.figure.dpi / 72.0
    to_pixels = axes.transData.transform
    kinds = [thin([label for label in labels if label.boxed == boxed]) for boxed in (False, True)]
    shown = [label for kind, _ in kinds for label in kind]
    few = [f"every {k}th number of {what}" for (_, k), what in zip(kinds, ("nodes", "elements"), strict=True) if k > 1]
    note = " and ".join(few).replace("every 2th", "every 2nd")
    artists: list[Any] = []
    if few:  # what is left out, in the corner of the picture
        artists.append(axes.text(
            0.995, 0.01, note, transform=axes.transAxes, fontsize=7, ha="right", color="#7d868e", zorder=31,
        ))  # fmt: skip
    covered = _samples(camera, shapes)
    sizes = [(0.62 * len(v.text) + (0.7 if v.boxed else 0.2)) * POINTS * scale for v in shown]
    h = 1.45 * POINTS * scale
    reach = np.max(RINGS) * 0.8 * POINTS * scale + max([h, *sizes])
    dots = to_pixels(covered) if len(covered) else np.zeros((0, 2))
    x0, y0, x1, y1 = axes.bbox.extents
    others = np.array([text.get_window_extent().extents for text in axes.texts]).reshape(-1, 4)
    boxes = np.concatenate((others, np.zeros((len(shown), 4))))
    for n, (label, w) in enumerate(zip(shown, sizes, strict=True), len(others)):
        at = to_pixels(camera.project(label.at))
        half = np.array([0.5 * w, 0.5 * h])
        centre = at + AROUND * (RINGS[:, None] * 0.8 * POINTS * scale + half)
        low, high = centre - half, centre + half  # (24, 2)
        near = dots[np.all(np.abs(dots - at) < reach, axis=1)]
        inside = np.all((near > low[:, None]) & (near < high[:, None]), axis=2).sum(1)
        before = boxes[:n]
        overlap = np.all((low[:, None] < before[:, 2:]) & (before[:, :2] < high[:, None]), axis=2).sum(1)
        outside = np.any((low < (x0, y0)) | (high > (x1, y1)), axis=1)
        best = int(np.argmin(inside + 40.0 * overlap + 1.5 * RINGS + OUTSIDE * outside))
        where, boxes[n] = centre[best], (*low[best], *high[best])
        frame = {"boxstyle": "round,pad=0.18", "fc": "white", "ec": label.colour, "lw": 0.7} if label.boxed else None
        text = axes.annotate(
            label.text, tuple(camera.project(label.at)), xytext=tuple((where - at) / scale), textcoords="offset points",
            fontsize=POINTS, color=label.colour, ha="center", va="center", bbox=frame, zorder=30, annotation_clip=False,
        )  # fmt: skip
        if not label.boxed:
            text.set_path_effects([withStroke(linewidth=2.5, foreground="white", alpha=0.85)])
        artists.append(text)
    return artists


def _samples(camera: Camera, shapes: Sequence[Shape]) -> Array:
    """Points along all lines, about DOTS each at equal distances, dense enough to see that a label covers one."""
    parts = []
    for s in shapes:
        if isinstance(s, Line):
            p = camera.project(s.points)
            step = np.diff(p, axis=-2)
            length = np.linalg.norm(step, axis=-1)
            whole = np.maximum(length.sum(axis=-1, keepdims=True), np.finfo(float).tiny)
            count = np.ceil(DOTS * length / whole).astype(np.int64).ravel()
            k = np.repeat(np.arange(len(count)), count)
            part = (np.arange(len(k)) - (np.cumsum(count) - count)[k]) / count[k]
            parts.append(p[..., :-1, :].reshape(-1, 2)[k] + part[:, None] * step.reshape(-1, 2)[k])
        elif isinstance(s, Faces) and not camera.planar:
            parts.append(camera.project(s.corners.mean(1)))
    return np.concatenate(parts) if parts else np.zeros((0, 2))


FRONT = 5  # marks from this layer on are drawn over solids
LIGHT = (-0.35, 0.65, 0.68)  # direction of the light in axes right, up, near
DARKEST = 0.55


def paint(axes: Axes, camera: Camera, shapes: Sequence[Shape]) -> list[Any]:
    """Add the shapes to the axes; returns the artists, to be removed before the next frame."""
    artists = _planar(axes, camera, shapes) if camera.planar else _spatial(axes, camera, shapes)
    for first, places in marks_alike(shapes):
        artists += axes.plot(
            *camera.project(places).T, "o", scalex=False, scaley=False, ms=first.size, mfc=first.face, mec=first.edge,
            mew=0.8, zorder=10 + first.layer,
        )  # fmt: skip
    return artists + paint_labels(axes, camera, shapes)


def paint_labels(axes: Axes, camera: Camera, shapes: Sequence[Shape]) -> list[Any]:
    """Only the labels among the shapes, beside the others."""
    labels = [s for s in shapes if isinstance(s, Label)]
    return place_labels(axes, camera, labels, shapes) if labels else []


def _planar(axes: Axes, camera: Camera, shapes: Sequence[Shape]) -> list[Any]:
    """Every layer: faces, then lines, in collections of their own."""
    from matplotlib.collections import LineCollection

    artists: list[Any] = []
    of_layers = together((s.layer, s) for s in shapes if isinstance(s, Faces))
    for layer, faces in sorted(of_layers.items()):
        artists.append(_polygons(axes, [_faces(camera, s) for s in faces], 10 + layer, False))
    kinds = together(((s.layer, s.alpha >= 1), s) for s in shapes if isinstance(s, Line))
    for (layer, opaque), lines in sorted(kinds.items(), key=lambda kind: kind[0]):
        ends = "round" if opaque else "butt"  # round ends of pale lines would show where two meet
        look = _polylines(camera, lines) | {"capstyle": ends, "joinstyle": "round", "zorder": 10.5 + layer}
        artists.append(axes.add_collection(LineCollection(**look), autolim=False))
    return artists


def _spatial(axes: Axes, camera: Camera, shapes: Sequence[Shape]) -> list[Any]:
    """All faces and pieces of lines in one collection, far ones first (painter's algorithm)."""
    from matplotlib.collections import LineCollection

    front, behind = in_front(shapes)
    artists: list[Any] = []
    if behind:
        parts = [_faces(camera, s) if isinstance(s, Faces) else _pieces(camera, s) for s in behind]
        artists.append(_polygons(axes, parts, 10, True))
    if front:
        artists.append(axes.add_collection(LineCollection(**_polylines(camera, front), zorder=15), autolim=False))
    return artists


def in_front(shapes: Sequence[Shape]) -> tuple[list[Line], list[Line | Faces]]:
    """Of a spatial picture the lines that are drawn over all others, and what is sorted by depth."""
    found = [s for s in shapes if isinstance(s, Line | Faces)]
    over = [s for s in found if isinstance(s, Line) and (s.layer >= FRONT or s.dashes)]
    return over, [s for s in found if isinstance(s, Faces) or (s.layer < FRONT and not s.dashes)]


Part = tuple[Array, Array, Array, Array, Array]  # polygons (n, k, 2), depths, colours of faces and of edges, widths


def _faces(camera: Camera, s: Faces) -> Part:
    colour = rgba(s.colour, s.alpha, len(s.corners))
    if s.light and not camera.planar:
        colour[:, :3] *= brightness(camera, s.corners)[:, None]
    # an edge in the colour of the face closes the hairlines between neighbours; with transparency it would show
    closed = s.alpha >= 1 and (not camera.planar or isinstance(s.colour, np.ndarray))
    edge = rgba(s.edge, 1.0, len(colour)) if s.edge else colour if closed else colour * [1, 1, 1, 0]
    width = s.width if s.edge or (closed and camera.planar) else 0.0 if camera.planar else 0.4
    return camera.project(s.corners), camera.depth(s.corners).mean(1), colour, edge, np.full(len(colour), width)


def _pieces(camera: Camera, s: Line) -> Part:
    """Pieces of lines as polygons that are only edges."""
    pieces = s.pieces
    colour = rgba(s.colour, s.alpha, len(pieces))
    widths = np.full(len(pieces), s.width)
    return camera.project(pieces), camera.depth(pieces).mean(1), colour * [1, 1, 1, 0], colour, widths


def _polygons(axes: Axes, parts: Sequence[Part], height: int, by_depth: bool) -> Any:
    from matplotlib.collections import PolyCollection

    polygons = _alike([part[0] for part in parts])
    depths, faces, edges, widths = (np.concatenate([part[i] for part in parts]) for i in range(1, 5))
    order = np.argsort(depths, kind="stable") if by_depth else np.arange(len(depths))
    collection = PolyCollection(
        list(polygons[order]), facecolors=faces[order], edgecolors=edges[order], linewidths=widths[order],
        joinstyle="round" if by_depth else None, zorder=height,
    )  # fmt: skip
    return axes.add_collection(collection, autolim=False)


def _polylines(camera: Camera, lines: Sequence[Line]) -> dict[str, Any]:
    """Arguments of a LineCollection."""
    points = [camera.project(s.points).reshape(-1, *s.points.shape[-2:-1], 2) for s in lines]
    each = [s for s, many in zip(lines, points, strict=True) for _ in many]
    return {
        "segments": [p for many in points for p in many], "colors": [rgba(s.colour, s.alpha)[0] for s in each],
        "linewidths": [s.width for s in each], "linestyles": [(0, s.dashes) if s.dashes else "solid" for s in each],
    }  # fmt: skip


def _alike(polygons: Sequence[Array]) -> Any:
    """(n, k, 2) polygons with equally many corners, by repeating the last one: matplotlib takes them in one piece."""
    k = max(p.shape[1] for p in polygons)
    return np.concatenate([np.pad(p, ((0, 0), (0, k - p.shape[1]), (0, 0)), "edge") for p in polygons])


def brightness(camera: Camera, corners: Array) -> Array:
    """(n,) between DARKEST and 1 of polygons (n, k, 3): a lamp over the viewer's left shoulder, both sides lit."""
    normal = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    normal *= np.where(normal @ camera.near < 0, -1.0, 1.0)[:, None]
    lamp = unit(np.array(LIGHT) @ np.stack((camera.right, camera.up, camera.near)))
    return DARKEST + (1 - DARKEST) * np.clip(normal @ lamp, 0.0, 1.0) ** 0.8


def rgba(colour: Any, alpha: float, n: int = 1) -> Array:
    """(n, 4) of one colour, or of an array (n, 3)."""
    from matplotlib.colors import to_rgba, to_rgba_array

    if isinstance(colour, np.ndarray) and colour.ndim == 2:
        return to_rgba_array(colour, alpha)
    return np.tile(to_rgba(colour, alpha), (n, 1)).astype(float)
