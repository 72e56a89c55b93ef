"""Pictures of modes and of over- and under-constraints: shapes of one phase, stills and films."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array
from spacar_drawing.defaults import plain
from spacar_drawing.drawn_shapes import Colour, Line, Shape
from spacar_drawing.files import Pictures
from spacar_drawing.look import DRIVE, GHOST, Look, look_of
from spacar_drawing.mechanism_picture import (
    Extras,
    camera_of,
    ghost_shapes,
    mechanism_shapes,
    outline_shapes,
    series_bounds,
)
from spacar_drawing.mode_shapes import ModeShape, Redundancy, displaced, suitable_factor
from spacar_drawing.paint import paint
from spacar_drawing.scene import Pose, Scene
from spacar_drawing.settings import PictureSettings
from spacar_drawing.stage import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PHASES = 48  # pictures of one period
QUARTERS = 16  # phases that decide the range
PALE, RED = np.array([0.82, 0.85, 0.87]), np.array([0.78, 0.08, 0.12])


def swing(mode: ModeShape, x: Array, factor: float, phase: float) -> Array:
    """(nx,) configuration of a phase; a mode that does not oscillate goes to one side and back."""
    if mode.oscillates:
        return displaced(x, mode, factor, phase)
    return displaced(x, mode, 0.5 * factor * (1.0 - np.cos(phase)), 0.0)


def period(mode: ModeShape, x: Array, factor: float, count: int) -> Array:
    """(count, nx) configurations of one period."""
    return np.stack([swing(mode, x, factor, p) for p in np.linspace(0.0, 2 * np.pi, count, endpoint=False)])


def mode_look(scene: Scene, x: Array, settings: PictureSettings, whole_period: Array) -> Look:
    """A look with the symbol size of the configuration at rest and the guides of the whole period."""
    return replace(look_of(scene, x[None], settings), ranges=look_of(scene, whole_period, settings).ranges)


@plain
def mode_still(
    scene: Scene, x: Array, settings: PictureSettings, extras: Extras, mode: ModeShape, factor: float, rest: bool
) -> Figure:
    """The mode at its extreme, the opposite extreme pale, and the position at rest dashed (when `rest`)."""
    whole = period(mode, x, factor, QUARTERS)
    look = mode_look(scene, x, settings, whole)
    camera = camera_of(scene, extras.view)
    bounds = series_bounds(scene, np.concatenate((x[None], whole)), look, extras)
    figure, axes = new_figure(bounds, camera, _title(scene, extras, mode.label))
    shapes: list[Shape] = outline_shapes(scene, x, look, settings.initial_colour or GHOST) if rest else []
    phases = (np.pi / 2, np.pi) if mode.is_complex and mode.oscillates else (np.pi,) if mode.oscillates else ()
    for phase in phases:
        shapes += ghost_shapes(scene, swing(mode, x, factor, phase), look, 0.28)
    shapes += mechanism_shapes(scene, swing(mode, x, factor, 0.0 if mode.oscillates else np.pi), look, extras)
    paint(axes, camera, shapes)
    return figure


def mode_pictures(
    scene: Scene, x: Array, settings: PictureSettings, extras: Extras, mode: ModeShape, factor: float, rest: bool
) -> tuple[Pictures, tuple[Array, Array]]:
    """The pictures of one period (PHASES of them) and the box around them."""
    whole = period(mode, x, factor, PHASES)
    look = mode_look(scene, x, settings, whole)
    bounds = series_bounds(scene, np.concatenate((x[None], whole)), look, extras, QUARTERS)
    behind = outline_shapes(scene, x, look, settings.initial_colour or GHOST) if rest else []

    def picture(k: int) -> tuple[Sequence[Shape], str]:
        return [*behind, *mechanism_shapes(scene, whole[k % PHASES], look, extras)], _title(scene, extras, mode.label)

    return picture, bounds


@plain
def constraint_still(
    scene: Scene, x: Array, settings: PictureSettings, extras: Extras, found: Redundancy, extent: float
) -> Figure:
    """Elements that take part in over-constraints in red, by their share; motions of under-constraints dashed."""
    share = found.over.sum(0)
    largest = float(share.max(initial=0.0))
    tints: dict[int, Colour] = {}
    if largest > 1e-6:
        for e in scene.elements:
            mix = float(np.sqrt(share[e.number - 1] / largest))
            r, g, b = (1 - mix) * PALE + mix * RED
            tints[e.number] = (float(r), float(g), float(b))
    look = replace(look_of(scene, x[None], settings), tints=tints)
    camera = camera_of(scene, extras.view)
    moved = [x + _step_for(scene, motion, extent) * motion for motion in found.under]
    bounds = series_bounds(scene, np.stack([x, *moved]), look, extras)
    over, under = len(found.over), len(found.under)
    parts = []
    if over:
        parts.append(f"{over} over-constraint{'s' * (over > 1)} (red elements take part)")
    if under:
        parts.append(f"{under} under-constraint{'s' * (under > 1)} (free motion dashed)")
    figure, axes = new_figure(
        bounds, camera, _title(scene, extras, ", ".join(parts) or "no over- or under-constraints")
    )
    shapes: list[Shape] = []
    for y in moved:
        shapes += outline_shapes(scene, y, look, DRIVE)
        shapes += _arrows(scene, x, y, look)
    paint(axes, camera, [*shapes, *mechanism_shapes(scene, x, look, extras)])
    return figure


def _step_for(scene: Scene, motion: Array, extent: float) -> float:
    mode = ModeShape(0, "buckling", 1.0 + 0j, np.zeros(0, complex), motion.astype(complex))

    return suitable_factor(scene, mode, extent)


def _arrows(scene: Scene, x: Array, y: Array, look: Look) -> list[Shape]:
    """Lines from the nodes to where the motion takes them."""
    a, b = Pose.of(scene, x).place, Pose.of(scene, y).place
    moved = [n for n in scene.position_nodes.tolist() if np.linalg.norm(b[n - 1] - a[n - 1]) > 0.05 * look.size]
    return [Line(np.stack((a[n - 1], b[n - 1])), DRIVE, 0.9, 5) for n in moved]


def _title(scene: Scene, extras: Extras, text: str) -> str:
    return f"{scene.title}   {text}" if extras.title is None else extras.title
