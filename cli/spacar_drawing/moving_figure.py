"""A series of configurations in one figure whose contents are exchanged: for animations, sliders and live windows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.errors import escaped
from spacar_drawing.camera import Camera
from spacar_drawing.drawn_shapes import Shape
from spacar_drawing.paint import paint
from spacar_drawing.stage import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from spacar_drawing.scene import Array

Pictures = Callable[[int], tuple[Sequence[Shape], str]]  # frame number from 0 -> shapes and the line above the picture


@dataclass
class MovingFigure:
    """A figure and the artists of the frame that it shows now. `still` shapes stay in every frame."""

    figure: Figure
    axes: Axes
    camera: Camera
    artists: list[Any] = field(default_factory=list)

    @classmethod
    def create(cls, bounds: tuple[Array, Array], camera: Camera, still: Sequence[Shape] = ()) -> MovingFigure:
        figure, axes = new_figure(bounds, camera, " ")
        paint(axes, camera, still)
        return cls(figure, axes, camera)

    def show(self, shapes: Sequence[Shape], title: str) -> None:
        for artist in self.artists:
            artist.remove()
        self.artists = paint(self.axes, self.camera, shapes)
        self.axes.set_title(escaped(title), fontsize=10, color="#4d565e", loc="left", pad=7, parse_math=False)


def evenly(first: int, last: int, count: int) -> list[int]:
    """At most `count` whole numbers from first to last, both included, evenly spread."""
    n = min(count, last - first + 1)
    return sorted({round(v) for v in np.linspace(first, last, max(n, 1)).tolist()})
