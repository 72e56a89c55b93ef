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
DIRECTIONS = np.array([(np.cos(a), np.sin(a)) for a in np.pi * np.array([0.25, 0.75, 1.25, 1.75, 0.5, 1.5, 0.0, 1.0])])
RINGS = np.repeat([1.0, 1.7, 2.6], len(DIRECTIONS))  # distance of the candidate places, nearest first
AROUND = np.tile(DIRECTIONS, (3, 1))  # and their directions
OUTSIDE = 1e3  # what a place outside of the axes, among their numbers, counts: more than all that a label can cover
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
    artists = _note(axes, [k for _, k in kinds])
    covered = _samples(camera, shapes)
    sizes = [(0.62 * len(v.text) + (0.7 if v.boxed else 0.2)) * POINTS * scale for v in shown]
    h = 1.45 * POINTS * scale
    reach = float(np.max(RINGS)) * 0.8 * POINTS * scale + max([h, *sizes])
    dots = _Dots(to_pixels(covered) if len(covered) else np.zeros((0, 2)), reach)
    x0, y0, x1, y1 = axes.bbox.extents
    others = np.array([text.get_window_extent().extents for text in axes.texts]).reshape(-1, 4)
    boxes = np.concatenate((others, np.zeros((len(shown), 4))))
    for n, (label, w) in enumerate(zip(shown, sizes, strict=True), len(others)):
        at = to_pixels(camera.project(label.at))
        half = np.array([0.5 * w, 0.5 * h])
        centre = at + AROUND * (RINGS[:, None] * 0.8 * POINTS * scale + half)
        low, high = centre - half, centre + half  # (24, 2)
        near = dots.near(at)
        inside = np.all((near > low[:, None]) & (near < high[:, None]), axis=2).sum(1)
        before = boxes[:n]
        overlap = np.all((low[:, None] < before[:, 2:]) & (before[:, :2] < high[:, None]), axis=2).sum(1)
        outside = np.any((low < (x0, y0)) | (high > (x1, y1)), axis=1)
        best = int(np.argmin(inside + 40.0 * overlap + 1.5 * RINGS + OUTSIDE * outside))
        where, boxes[n] = centre[best], (*low[best], *high[best])
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


def _note(axes: Axes, every: Sequence[int]) -> list[Any]:
    """What is left out, in the corner of the picture."""
    words = [f"every {k}th number of {what}" for k, what in zip(every, ("nodes", "elements"), strict=True) if k > 1]
    if not words:
        return []
    text = " and ".join(words).replace("every 2th", "every 2nd")
    return [axes.text(0.995, 0.01, text, transform=axes.transAxes, fontsize=7, ha="right", color="#7d868e", zorder=31)]


class _Dots:
    """Points (n, 2) sorted into square cells, so that a label looks at those around it only."""

    def __init__(self, dots: Array, cell: float) -> None:
        self.cell = cell
        keys = np.floor(dots / cell).astype(np.int64)
        order = np.lexsort(keys.T)
        self.dots, keys = dots[order], keys[order]
        edges = np.flatnonzero(np.any(np.diff(keys, axis=0) != 0, axis=1)) + 1
        starts, stops = [0, *edges.tolist()], [*edges.tolist(), len(keys)]
        self.cells = {(int(keys[i, 0]), int(keys[i, 1])): (i, j) for i, j in zip(starts, stops, strict=True) if j > i}

    def near(self, at: Array) -> Array:
        """The points in the cell of a place and in the eight around it: all that are nearer than a cell, and more."""
        i, j = (int(v) for v in np.floor(at / self.cell))
        around = ((i + a, j + b) for a in (-1, 0, 1) for b in (-1, 0, 1))
        found = [self.cells[key] for key in around if key in self.cells]
        return np.concatenate([self.dots[a:b] for a, b in found]) if found else np.zeros((0, 2))


def _samples(camera: Camera, shapes: Sequence[Shape]) -> Array:
    """Points along all lines, dense enough to see that a label covers one."""
    parts = []
    for s in shapes:
        if isinstance(s, Line):
            p = camera.project(s.points)
            t = np.linspace(0.0, 1.0, max(2, 60 // p.shape[-2] + 1)).reshape(-1, *(1,) * p.ndim)
            parts.append(((1 - t) * p[..., :-1, :] + t * p[..., 1:, :]).reshape(-1, 2))
        elif isinstance(s, Faces) and not camera.planar:
            parts.append(camera.project(s.corners.mean(1)))
    return np.concatenate(parts) if parts else np.zeros((0, 2))
