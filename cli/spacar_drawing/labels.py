"""Numbers beside nodes and elements, moved so that they neither overlap each other nor cover the mechanism."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.arrays import Array
from spacar_drawing.camera import Camera
from spacar_drawing.drawn_shapes import Faces, Label, Line, Shape

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS = 8.0  # size of the letters
DIRECTIONS = [(np.cos(a), np.sin(a)) for a in np.pi * np.array([0.25, 0.75, 1.25, 1.75, 0.5, 1.5, 0.0, 1.0])]


def place_labels(axes: Axes, camera: Camera, labels: Sequence[Label], shapes: Sequence[Shape]) -> list[Any]:
    """Put every label where it covers least of the lines and of the labels before it."""
    from matplotlib.patheffects import withStroke

    scale = axes.figure.dpi / 72.0
    to_pixels = axes.transData.transform
    covered = _samples(camera, shapes)
    dots = to_pixels(covered) if len(covered) else np.zeros((0, 2))
    x0, y0, x1, y1 = axes.bbox.extents
    boxes: list[tuple[float, float, float, float]] = []
    artists = []
    for label in labels:
        at = to_pixels(camera.project(label.at))
        w, h = (0.62 * len(label.text) + (0.7 if label.boxed else 0.2)) * POINTS * scale, 1.45 * POINTS * scale
        best, where = np.inf, at
        for ring in (1.0, 1.7, 2.6):
            for dx, dy in DIRECTIONS:
                gap = ring * 0.8 * POINTS * scale
                c = at + np.array([dx * (gap + 0.5 * w), dy * (gap + 0.5 * h)])
                box = (c[0] - w / 2, c[1] - h / 2, c[0] + w / 2, c[1] + h / 2)
                inside = (dots > box[:2]).all(1) & (dots < box[2:]).all(1)
                cost = float(inside.sum()) + 40 * sum(_overlap(box, b) for b in boxes) + 1.5 * ring
                if box[0] < x0 or box[1] < y0 or box[2] > x1 or box[3] > y1:
                    cost += 25
                if cost < best - 1e-9:
                    best, where, chosen = cost, c, box
        boxes.append(chosen)
        frame = {"boxstyle": "round,pad=0.18", "fc": "white", "ec": label.colour, "lw": 0.7} if label.boxed else None
        text = axes.annotate(
            label.text,
            tuple(camera.project(label.at)),
            xytext=tuple((where - at) / scale),
            textcoords="offset points",
            fontsize=POINTS,
            color=label.colour,
            ha="center",
            va="center",
            bbox=frame,
            zorder=30,
            annotation_clip=False,
        )
        if not label.boxed:
            text.set_path_effects([withStroke(linewidth=2.5, foreground="white", alpha=0.85)])
        artists.append(text)
    return artists


def _overlap(a: tuple[float, float, float, float], b: tuple[float, float, float, float]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _samples(camera: Camera, shapes: Sequence[Shape]) -> Array:
    """Points along all lines, dense enough to see that a label covers one."""
    parts = []
    for s in shapes:
        if isinstance(s, Line):
            p = camera.project(s.points)
            t = np.linspace(0.0, 1.0, max(2, 60 // len(p) + 1))[:, None, None]
            parts.append(((1 - t) * p[:-1] + t * p[1:]).reshape(-1, 2))
        elif isinstance(s, Faces) and not camera.planar:
            parts.append(camera.project(s.corners.mean(1)))
    return np.concatenate(parts) if parts else np.zeros((0, 2))
