"""A series of configurations in one figure whose contents are exchanged: for animations, sliders and live windows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.errors import escaped
from spacar_drawing.camera import Camera
from spacar_drawing.defaults import plain
from spacar_drawing.drawn_shapes import Faces, Shape
from spacar_drawing.paint import paint, paint_labels
from spacar_drawing.stage import new_figure

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from spacar_drawing.scene import Array

Pictures = Callable[[int], tuple[Sequence[Shape], str]]  # frame number from 0 -> shapes and the line above the picture


@dataclass(eq=False)  # Matplotlib 3.8 keeps callbacks by the hash of their object
class MovingFigure:
    """A figure and the picture that it shows now. `still` shapes stay in every picture.

    What does not move - axes, grid, numbers along them - is drawn once and kept as pixels, where the canvas has pixels;
    elsewhere, and for solids that one can look through, every picture is made of new artists.
    """

    figure: Figure
    axes: Axes
    camera: Camera
    artists: list[Any] = field(default_factory=list)  # of the picture that is shown, beside the raster
    beside: Sequence[Artist] = ()  # what else moves: the slider of a window, the line of scopes
    raster: Any = None
    background: Any = None
    listens: bool = False  # to the canvas: a window that was covered or made larger is drawn by others

    @classmethod
    @plain
    def create(cls, bounds: tuple[Array, Array], camera: Camera, still: Sequence[Shape] = ()) -> MovingFigure:
        figure, axes = new_figure(bounds, camera, " ")
        paint(axes, camera, still)
        return cls(figure, axes, camera)

    def show(self, shapes: Sequence[Shape], title: str) -> None:
        """Exchange the picture, to be seen with the next `draw`."""
        from spacar_drawing.raster import Raster, can_raster

        for artist in self.artists:
            artist.remove()
        if can_raster(self.figure.canvas):
            if self.raster is None:
                self.raster = Raster(self.axes, self.camera)
                if not self.listens:
                    self.figure.canvas.mpl_connect("draw_event", self._keep)
                    self.listens = True
            quick = self.camera.planar or all(s.alpha >= 1 for s in shapes if isinstance(s, Faces))
            self.raster.show(shapes if quick else ())
            self.artists = (paint_labels if quick else paint)(self.axes, self.camera, shapes)
        else:
            self.artists = paint(self.axes, self.camera, shapes)
        self.axes.set_title(escaped(title), fontsize=10, color="#4d565e", loc="left", pad=7, parse_math=False)

    def place(self, axes: Axes, camera: Camera) -> None:
        """Go on in new axes, instead of those that there are."""
        self.axes.remove()
        self.artists.clear()
        self.axes, self.camera, self.raster, self.background = axes, camera, None, None

    def draw(self) -> None:
        """Bring the picture to the screen, or to the pixels of a canvas without one."""
        canvas: Any = self.figure.canvas
        if self.raster is None:
            canvas.draw()
        elif self.background is None:
            for artist in (self.axes._left_title, *self.beside):  # type: ignore[attr-defined]
                artist.set_animated(True)
            canvas.draw()  # `_keep` hears of it
        else:
            canvas.restore_region(self.background)
            self._overlay()
        if hasattr(canvas, "blit"):
            canvas.blit(self.figure.bbox)

    def _keep(self, _: object) -> None:
        """The figure was drawn: keep its pixels, and add what moves."""
        if self.raster is not None and self.raster.axes is not None:
            canvas: Any = self.figure.canvas
            self.background = canvas.copy_from_bbox(self.figure.bbox)
            self._overlay()

    def _overlay(self) -> None:
        for artist in (self.raster, *self.artists, self.axes._left_title):  # type: ignore[attr-defined]
            self.axes.draw_artist(artist)
        for artist in self.beside:
            self.figure.draw_artist(artist)


def evenly(first: int, last: int, count: int) -> list[int]:
    """At most `count` whole numbers from first to last, both included, evenly spread."""
    n = min(count, last - first + 1)
    return sorted({round(v) for v in np.linspace(first, last, max(n, 1)).tolist()})
