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
from spacar_drawing.look import DRIVE, Look, extent_of, look_of
from spacar_drawing.mechanism_picture import (
    Extras,
    ghost_shapes,
    mechanism_shapes,
    outline_shapes,
    painted,
    series_bounds,
    title_of,
)
from spacar_drawing.mode_shapes import ModeShape, Redundancy, redundancy, stored_gradient, suitable_factor
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.scene import positions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PHASES = 48  # pictures of one period
QUARTERS = 16  # phases that decide the range
PALE, RED = np.array([0.82, 0.85, 0.87]), np.array([0.78, 0.08, 0.12])


def swing(mode: ModeShape, x: Array, factor: float, phase: float) -> Array:
    """(nx,) configuration of a phase; a mode that does not oscillate goes to one side and back."""
    if mode.oscillates:
        return x + factor * np.real(mode.motion * np.exp(1j * phase))
    return x + 0.5 * factor * (1.0 - np.cos(phase)) * np.real(mode.motion)


def period(mode: ModeShape, x: Array, factor: float, count: int) -> Array:
    """(count, nx) configurations of one period."""
    return np.stack([swing(mode, x, factor, p) for p in np.linspace(0.0, 2 * np.pi, count, endpoint=False)])


def around(
    source: PictureSource, x: Array, extras: Extras, whole: Array, most: int
) -> tuple[Look, tuple[Array, Array]]:
    """A look with the symbol size of the configuration at rest and the guides of the whole period, and the box."""
    scene, settings = source.scene, source.settings
    look = replace(look_of(scene, x[None], settings), ranges=look_of(scene, whole, settings).ranges)
    return look, series_bounds(scene, np.concatenate((x[None], whole)), look, extras, most)


@plain
def mode_still(source: PictureSource, step: int, extras: Extras, mode: ModeShape, factor: float, rest: bool) -> Figure:
    """The mode at its extreme, the opposite extreme pale, and the position at rest dashed (when `rest`)."""
    scene, x = source.scene, source.x(step)
    look, bounds = around(source, x, extras, period(mode, x, factor, QUARTERS), 24)
    shapes = outline_shapes(scene, x, look) if rest else []
    phases = (np.pi / 2, np.pi) if mode.is_complex and mode.oscillates else (np.pi,) if mode.oscillates else ()
    for phase in phases:
        shapes += ghost_shapes(scene, swing(mode, x, factor, phase), look, 0.28)
    shapes += mechanism_shapes(scene, swing(mode, x, factor, 0.0 if mode.oscillates else np.pi), look, extras)
    return painted(scene, extras, bounds, shapes, mode.label)


def mode_pictures(
    source: PictureSource, step: int, extras: Extras, mode: ModeShape, factor: float, rest: bool
) -> tuple[Pictures, tuple[Array, Array]]:
    """The pictures of one period (PHASES of them) and the box around them."""
    scene, x = source.scene, source.x(step)
    whole = period(mode, x, factor, PHASES)
    look, bounds = around(source, x, extras, whole, QUARTERS)
    behind = outline_shapes(scene, x, look) if rest else []

    def picture(k: int) -> tuple[Sequence[Shape], str]:
        return [*behind, *mechanism_shapes(scene, whole[k % PHASES], look, extras)], title_of(scene, extras, mode.label)

    return picture, bounds


def constraints(source: PictureSource, step: int) -> Redundancy:
    return redundancy(source.scene, stored_gradient(source, step), extent_of(source, step))


@plain
def constraint_still(source: PictureSource, step: int, extras: Extras, found: Redundancy) -> Figure:
    """Elements that take part in over-constraints in red, by their share; motions of under-constraints dashed."""
    scene, x, extent = source.scene, source.x(step), extent_of(source, step)
    share = found.over.sum(0)
    largest = share.max(initial=0.0)
    tints: dict[int, Colour] = {}
    if largest > 1e-6:
        for e in scene.elements:
            mix = np.sqrt(share[e.number - 1] / largest)
            r, g, b = ((1 - mix) * PALE + mix * RED).tolist()
            tints[e.number] = r, g, b
    look = replace(look_of(scene, x[None], source.settings), tints=tints)
    moved = [x + suitable_factor(scene, motion, extent) * motion for motion in found.under]
    bounds = series_bounds(scene, np.stack([x, *moved]), look, extras)
    counts = (len(found.over), "over", "red elements take part"), (len(found.under), "under", "free motion dashed")
    text = ", ".join(f"{n} {which}-constraint{'s' * (n > 1)} ({how})" for n, which, how in counts if n)
    shapes: list[Shape] = []
    for y in moved:
        shapes += outline_shapes(scene, y, look, DRIVE)
        a, b = (positions(scene, at)[scene.position_nodes - 1] for at in (x, y))
        far = np.linalg.norm(b - a, axis=1) > 0.05 * look.size
        shapes += [Line(ends, DRIVE, 0.9, 5) for ends in np.stack((a, b), axis=1)[far]]  # where the motion takes nodes
    shapes += mechanism_shapes(scene, x, look, extras)
    return painted(scene, extras, bounds, shapes, text or "no over- or under-constraints")
