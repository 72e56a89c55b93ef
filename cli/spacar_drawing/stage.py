"""The figure: margins, axes with equal scales, the coordinate grid of planar and of spatial pictures.

Orthographic projection: the same for both kinds of mechanisms, so that all axes have the same scale.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.arrays import Array
from spacar.deck.length_unit import shown_in
from spacar.errors import UsageError, escaped
from spacar_drawing.defaults import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAMED = {"iso": (-55.0, 24.0), "xy": (-90.0, 90.0), "xz": (-90.0, 0.0), "yz": (0.0, 0.0), "top": (-90.0, 90.0)}


@dataclass(frozen=True)
class Camera:
    """Axes of the picture in space: right, up, and towards the viewer; each (3,). `metre`: unit on the axes [m]."""

    right: Array
    up: Array
    near: Array
    planar: bool
    metre: float = 1.0

    @classmethod
    def plane(cls) -> Camera:
        """Looks at the plane z = 0 from above."""
        x, y, z = np.eye(3)
        return cls(x, y, z, True)

    @classmethod
    def towards(cls, azimuth: float, elevation: float) -> Camera:
        """From the direction of these angles [degrees]: azimuth in the xy plane from x, elevation above it."""
        a, b = np.radians(azimuth), np.radians(elevation)
        near = np.array([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        return cls(right, np.cross(near, right), near, False)

    def project(self, points: Array) -> Array:
        """(..., 2) places in the picture [m] of points (..., 3)."""
        return points @ np.stack((self.right, self.up), axis=1)

    def depth(self, points: Array) -> Array:
        """Distance towards the viewer [m]."""
        return points @ self.near


def view_angles(text: str) -> tuple[float, float]:
    """`iso`, `xy`, `xz`, `yz`, or azimuth and elevation in degrees as `-60,25`. Raises UsageError."""
    if text.lower() in NAMED:
        return NAMED[text.lower()]
    try:
        azimuth, elevation = (float(w) for w in text.split(","))
    except ValueError:
        raise UsageError(f"--view {text}: write iso, xy, xz, yz or azimuth,elevation in degrees as -60,25") from None
    if not (abs(azimuth) <= 360 and abs(elevation) <= 90):
        raise UsageError(f"--view {text}: azimuth within 360 and elevation within 90 degrees")
    return azimuth, elevation


PANE, RULE, INK = "#fafbfc", "#e3e7ea", "#4d565e"
WIDTH = 7.2  # inches
LEAST, MOST = 2.6, 6.6  # height of the axes in inches


def blank(width: float, height: float, **options: Any) -> Figure:
    """An empty figure of a size in inches, which a notebook shows."""
    from spacar_drawing.shown_figure import ShownFigure

    return ShownFigure(figsize=(width, height), dpi=110, **options)


def widened(figure: Figure, more: float) -> float:
    """Make a figure wider by `more` inches, free to the right of what it shows; returns the width that it had."""
    width, height = figure.get_size_inches()
    part = width / (width + more)
    for axes in figure.axes:
        box = axes.get_position()
        axes.set_position((box.x0 * part, box.y0, box.width * part, box.height))
    figure.set_size_inches(width + more, height)
    return float(width)


def head(figure: Figure, text: str, **where: Any) -> None:
    """A line above all axes of a figure."""
    figure.suptitle(escaped(text), fontsize=10, color=INK, parse_math=False, **where)


def named(axes: Axes, text: str) -> None:
    """A line above axes, to the left."""
    axes.set_title(escaped(text), fontsize=10, color=INK, loc="left", pad=7, parse_math=False)


def dress(axes: Axes, x: str = "", y: str = "", numbers: float = 8.0, framed: bool = True) -> None:
    """Names of the axes, grid and numbers as in all diagrams."""
    axes.set_xlabel(x, fontsize=8.5, color=INK, parse_math=False)
    axes.set_ylabel(y, fontsize=8.5, color=INK, parse_math=False)
    axes.grid(True, color=RULE, lw=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=numbers, colors=INK, length=0)
    for side in axes.spines.values():
        side.set(color="#cfd5da", linewidth=0.8, visible=framed)


@plain
def new_figure(bounds: tuple[Array, Array], camera: Camera, title: str = "") -> tuple[Figure, Axes]:
    """A figure whose axes show the box `bounds` (lower, upper corner) [m] completely, with equal scales."""
    left, right, bottom, top = _margins(camera, title)
    a, b, _, _ = _window(bounds, camera)
    h = np.clip((WIDTH - left - right) * (b - a)[1] / (b - a)[0], LEAST, MOST)
    figure = blank(WIDTH, h + bottom + top)
    return figure, furnish(figure, bounds, camera, title)


def furnish(figure: Figure, bounds: tuple[Array, Array], camera: Camera, title: str, foot: float = 0.0) -> Axes:
    """Axes with grid on an empty figure of given size; `foot` inches at the bottom stay free for buttons."""
    left, right, bottom, top = _margins(camera, title)
    bottom += foot
    width, height = figure.get_size_inches()
    w, h = max(width - left - right, 0.5), max(height - bottom - top, 0.5)
    axes = figure.add_axes((left / width, bottom / height, w / width, h / height))
    a, b, low, high = _window(bounds, camera)
    middle, span = 0.5 * (a + b), b - a
    half = 0.5 * max(span[0] / w, span[1] / h) * np.array([w, h])
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    axes.set_aspect("equal")
    if camera.planar:
        axes.set_facecolor("white")
        unit = shown_in("m", camera.metre)[1]
        dress(axes, f"x ({unit})", f"y ({unit})")
        for axis in (axes.xaxis, axes.yaxis) if camera.metre != 1.0 else ():
            axis.set_major_formatter(lambda value, _: _length(value, camera.metre))
    else:
        _space_grid(axes, camera, low, high)
    if title:
        named(axes, title)
    return axes


def _margins(camera: Camera, title: str) -> tuple[float, float, float, float]:
    """Left, right, bottom, top in inches."""
    top = 0.42 if title else 0.15
    return (0.75, 0.2, 0.55, top) if camera.planar else (0.5, 0.2, 0.15, top)


def _window(bounds: tuple[Array, Array], camera: Camera) -> tuple[Array, Array, Array, Array]:
    """Corners of the part of the picture plane that must be seen, and of the box around the mechanism."""
    low, high = padded(bounds, camera)
    box = camera.project(corners(low, high))
    a, b = box.min(0), box.max(0)
    if not camera.planar:
        margin = 0.06 * np.max(b - a)
        a, b = a - margin * np.array([1.4, 1.3]), b + margin * np.array([1.0, 0.5])
    return a, b, low, high


def padded(bounds: tuple[Array, Array], camera: Camera) -> tuple[Array, Array]:
    """The box with some room; spatial boxes get at least a quarter of the largest side in every direction."""
    low, high = (np.array(v, float) for v in bounds)
    size = np.max(high - low) or 1.0
    if camera.planar:
        return low - 0.04 * size, high + 0.04 * size
    middle = 0.5 * (low + high)
    half = np.maximum(0.5 * (high - low) + 0.03 * size, 0.14 * size)
    return middle - half, middle + half


def corners(low: Array, high: Array) -> Array:
    """(8, 3) corners of a box."""
    return np.where(np.indices((2, 2, 2)).reshape(3, 8).T, high, low)


def _length(value: float, metre: float) -> str:
    return f"{value / metre:g}".replace("-", "\N{MINUS SIGN}")


def ticks(low: float, high: float, most: int) -> Array:
    """Round numbers inside an interval."""
    from matplotlib.ticker import MaxNLocator

    values = np.array(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high))
    return values[(values >= low - 1e-9 * (high - low)) & (values <= high + 1e-9 * (high - low))]


def _space_grid(axes: Axes, camera: Camera, low: Array, high: Array) -> None:
    """The three far sides of the box with grid lines, and numbers along three of its edges."""
    from matplotlib.collections import LineCollection, PolyCollection

    axes.set_axis_off()
    far = np.where(camera.near > 1e-9, low, high)  # coordinates of the far sides
    near = np.where(camera.near > 1e-9, high, low)
    lists = [ticks(low[k], high[k], 6 if high[k] - low[k] > 0.6 * np.max(high - low) else 4) for k in range(3)]
    panes, rules = [], []
    for k in range(3):
        i, j = (m for m in range(3) if m != k)
        pane = np.tile(far, (4, 1))
        pane[:, i] = [low[i], high[i], high[i], low[i]]
        pane[:, j] = [low[j], low[j], high[j], high[j]]
        panes.append(camera.project(pane))
        for m, o in ((i, j), (j, i)):
            for value in lists[m]:
                line = np.tile(far, (2, 1))
                line[:, m], line[:, o] = value, [low[o], high[o]]
                rules.append(camera.project(line))
    axes.add_collection(
        PolyCollection(panes, facecolors=PANE, edgecolors="#cfd5da", linewidths=0.8, zorder=1), autolim=False
    )
    axes.add_collection(LineCollection(rules, colors=RULE, linewidths=0.6, zorder=2), autolim=False)
    centre = camera.project(0.5 * (low + high))
    for k, name in enumerate("xyz"):
        if abs(camera.near[k]) > 0.985:
            continue  # the axis points at the viewer
        i, j = (m for m in range(3) if m != k)
        candidates = np.tile(0.5 * (low + high), (2, 1))  # an edge between a near and a far side is on the outline
        candidates[:, i], candidates[:, j] = (far[i], near[i]), (near[j], far[j])
        edge = candidates[np.argmin(camera.project(candidates)[:, 0 if k == 2 else 1])]  # the left or the lower one
        line = np.tile(edge, (len(lists[k]), 1))
        line[:, k] = lists[k]
        places = camera.project(line)
        ends = np.tile(edge, (2, 1))
        ends[:, k] = low[k], high[k]
        a, b = camera.project(ends)
        along = (b - a) / np.linalg.norm(b - a)
        out = np.array([-along[1], along[0]])
        out *= np.sign(out @ (0.5 * (a + b) - centre)) or 1.0
        beside, behind = out[0] < -0.8, out[0] > 0.8  # numbers beside an upright edge end or begin at it
        for place, value in zip(places, lists[k], strict=True):
            axes.annotate(
                _length(value, camera.metre), tuple(place), xytext=tuple((5 if beside or behind else 9) * out),
                textcoords="offset points", ha="right" if beside else "left" if behind else "center", va="center",
                fontsize=7.5, color=INK, zorder=3, annotation_clip=False,
            )  # fmt: skip
        upright = 90.0 if behind else 0.0  # the margin to the right is narrow
        axes.annotate(
            f"{name} ({shown_in('m', camera.metre)[1]})", tuple(0.5 * (a + b)),
            xytext=tuple((40 if beside else 34 if behind else 27) * out), textcoords="offset points", ha="center",
            va="center", rotation=upright, fontsize=8.5, color=INK, zorder=3, annotation_clip=False,
        )  # fmt: skip
