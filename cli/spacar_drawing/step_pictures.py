"""Steps of a result as one picture or as an animation: which steps, what stands above them, how much room they need."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from spacar_formats.getfrsbf import step_numbers

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar_drawing.camera import Camera
from spacar_drawing.drawn_shapes import Shape, merge_bounds
from spacar_drawing.look import GHOST, look_of
from spacar_drawing.mechanism_picture import (
    Extras,
    camera_of,
    draw_steps,
    mechanism_shapes,
    outline_shapes,
    series_bounds,
)
from spacar_drawing.moving_figure import MovingFigure, Pictures, evenly
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.supports import trace_lines

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SAMPLES = 60  # configurations that decide the range of an animation


def chosen_steps(source: PictureSource, steps: str | None, strobe: int | None, moving: bool) -> list[int]:
    """Step numbers from 1. Raises UsageError for steps that do not exist."""
    if strobe:
        return evenly(1, source.steps, strobe)
    if steps is None:
        if moving:
            return list(range(1, source.steps + 1))
        return [source.steps if source.scene.analysis.stationary else 1]
    if steps.strip().lower() == "all":
        return list(range(1, source.steps + 1))
    found = step_numbers(steps, source.steps)
    numbers = [found] if isinstance(found, int) else found
    wrong = [k for k in numbers if not 1 <= k <= source.steps]
    if wrong:
        raise UsageError(f"step {wrong[0]} does not exist: {source.name} has steps 1 to {source.steps}", "files.step")
    return numbers


def configurations(source: PictureSource, numbers: Sequence[int]) -> Array:
    """(steps, nx) coordinates, reading only these steps."""
    if len(numbers) == source.steps:
        return source.x()
    return np.stack([source.x(k) for k in numbers])


def step_text(source: PictureSource, k: int) -> str:
    """What stands above the picture of a step."""
    t = source.time(k)
    if source.scene.analysis.stationary:
        return f"{source.scene.title}   load step {k}" if source.steps > 1 else source.scene.title
    return f"{source.scene.title}   t = {t:.6g} s" if source.steps > 1 else source.scene.title


def picture(
    source: PictureSource, extras: Extras, numbers: Sequence[int], nodes: Sequence[int], initial: bool
) -> Figure:
    """The steps `numbers` in one figure, with paths of `nodes` and, if `initial`, the outline of the first step."""
    title = extras.title
    if title is None:
        title = step_text(source, numbers[-1])
        if len(numbers) > 1:
            span = f"t = {source.time(numbers[0]):.4g} to {source.time(numbers[-1]):.4g} s"
            if source.scene.analysis.stationary:
                span = f"load steps {numbers[0]} to {numbers[-1]}"
            title = f"{source.scene.title}   {len(numbers)} steps, {span}"
    return draw_steps(
        source.scene,
        configurations(source, numbers),
        source.settings,
        replace(extras, title=title),
        every_step=source.x() if nodes else None,
        traces=nodes,
        behind=source.x(1) if initial else None,
    )


@dataclass(frozen=True)
class Series:
    """The steps `numbers` to be shown one after the other in one view; `still` shapes stay in all of them."""

    source: PictureSource
    extras: Extras
    numbers: Sequence[int]
    camera: Camera
    bounds: tuple[Array, Array]
    still: Sequence[Shape]
    pictures: Pictures

    def thinned(self, count: int) -> tuple[Pictures, int]:
        """At most `count` of them, evenly spread, and how many there are."""
        few = evenly(0, len(self.numbers) - 1, count)
        return (lambda i: self.pictures(few[i])), len(few)

    def whole(self, i: int) -> tuple[Sequence[Shape], str]:
        """Picture i with what stays, for figures whose axes are made anew (a window in which the view is turned)."""
        shapes, title = self.pictures(i)
        return [*self.still, *shapes], title

    def moving(self) -> MovingFigure:
        """A figure for them, with what stays already in it."""
        return MovingFigure.create(self.bounds, self.camera, self.still)


def series(
    source: PictureSource, extras: Extras, numbers: Sequence[int], nodes: Sequence[int], initial: bool
) -> Series:
    """The steps as a series, with room for all of them and for the paths of `nodes`."""
    scene = source.scene
    sample = configurations(source, [numbers[i] for i in evenly(0, len(numbers) - 1, SAMPLES)])
    look = look_of(scene, sample, source.settings)
    low, high = series_bounds(scene, sample, look, extras, SAMPLES)
    still: list[Shape] = trace_lines(scene, source.x(), nodes) if nodes else []
    if initial:
        still += outline_shapes(scene, source.x(1), look, source.settings.initial_colour or GHOST)
    box = merge_bounds(still)
    if box is not None:
        low, high = np.minimum(low, box[0]), np.maximum(high, box[1])

    def show(i: int) -> tuple[Sequence[Shape], str]:
        k = numbers[i]
        title = extras.title if extras.title is not None else step_text(source, k)
        return mechanism_shapes(scene, source.x(k), look, extras), title

    return Series(source, extras, numbers, camera_of(scene, extras.view), (low, high), still, show)
