"""A mechanism at one or more steps in one picture: shapes of all that is asked for, and the figure around them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array
from spacar_drawing import look as colours
from spacar_drawing.bodies import beam_lines, together
from spacar_drawing.drawn_shapes import Faces, Line, Shape, merge_bounds
from spacar_drawing.element_pictures import element_shapes
from spacar_drawing.look import Look, look_of
from spacar_drawing.paint import paint
from spacar_drawing.scene import ROUND, Pose, Scene
from spacar_drawing.settings import PictureSettings
from spacar_drawing.stage import Camera, new_figure, view_angles
from spacar_drawing.supports import node_marks, number_labels, support_shapes, trace_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Extras:
    """What is drawn besides the mechanism itself, and how.

    symbols  of KINDS in symbols.py;  scale  of the deflections from the start, which is then drawn in thin grey
    """

    node_numbers: bool = False
    element_numbers: bool = False
    supports: bool = True
    view: str = "iso"
    title: str | None = None
    symbols: tuple[str, ...] = ()
    scale: float = 1.0


def camera_of(scene: Scene, view: str) -> Camera:
    camera = Camera.plane() if scene.planar else Camera.towards(*view_angles(view))
    return replace(camera, metre=scene.metre)


def mechanism_shapes(scene: Scene, x: Array, look: Look, extras: Extras) -> list[Shape]:
    """Everything of one configuration x (nx,)."""
    pose = Pose.of(scene, x)
    shapes = element_shapes(scene, pose, look)
    if extras.supports:
        shapes += support_shapes(scene, pose, look)
    shapes += node_marks(scene, pose, look)
    shapes += number_labels(scene, pose, look, extras.node_numbers, extras.element_numbers)
    return shapes


def ghost_shapes(scene: Scene, x: Array, look: Look, strength: float = 0.35) -> list[Shape]:
    """The elements only, pale: other steps of a stroboscopic picture, or the undeformed state."""
    return [
        fade(s, strength)
        for s in element_shapes(scene, Pose.of(scene, x), look)
        if not isinstance(s, Faces) or s.layer < 5
    ]


def outline_shapes(scene: Scene, x: Array, look: Look, colour: colours.Colour = colours.GHOST) -> list[Shape]:
    """The elastic lines only, thin, in one colour."""
    pose = Pose.of(scene, x)
    seen = (e for e in scene.elements if e.p and e.q and e.number not in look.settings.hidden and e.shape not in ROUND)
    alike = together(((e.shape == "beam", bool(e.warping)), e) for e in seen)
    return [
        Line(beam_lines(scene, pose, found, look.points)[0], colour, 1.0, 0, dashes=(5, 3)) for found in alike.values()
    ]


def fade(shape: Shape, strength: float) -> Shape:
    if isinstance(shape, Line):
        return replace(shape, alpha=shape.alpha * strength, layer=min(shape.layer, 1))
    if isinstance(shape, Faces):
        return replace(shape, alpha=shape.alpha * strength, layer=min(shape.layer, 0), edge=None)
    return shape


def series_bounds(scene: Scene, xs: Array, look: Look, extras: Extras, most: int = 24) -> tuple[Array, Array]:
    """Box [m] around the drawings of (a sample of) the configurations xs (steps, nx)."""
    chosen = np.unique(np.linspace(0, len(xs) - 1, min(len(xs), most)).round().astype(int))
    quiet = replace(extras, node_numbers=False, element_numbers=False)
    boxes = [merge_bounds(mechanism_shapes(scene, xs[i], look, quiet)) for i in chosen]
    found = [b for b in boxes if b is not None]
    if not found:
        return np.full(3, -1.0), np.full(3, 1.0)
    return np.min([b[0] for b in found], axis=0), np.max([b[1] for b in found], axis=0)


def draw_steps(
    scene: Scene, xs: Array, settings: PictureSettings, extras: Extras = Extras(), *, every_step: Array | None = None,
    traces: Sequence[int] = (), behind: Array | None = None, look: Look | None = None, more: Sequence[Shape] = (),
    note: str = "",
) -> Figure:  # fmt: skip
    """One figure of the configurations xs (steps, nx): the last one in full, the earlier ones pale, oldest palest.

    `every_step` (all steps, nx) are the configurations for the traces of the nodes `traces`; `behind` (nx,) is drawn as
    a dashed outline. `more` shapes come on top, `note` stands in the lower left corner.
    """
    look = look or look_of(scene, xs if every_step is None else every_step, settings)
    camera = camera_of(scene, extras.view)
    low, high = series_bounds(scene, xs, look, extras)
    shapes: list[Shape] = []
    if traces and every_step is not None:
        shapes += trace_lines(scene, every_step, traces)
        box = merge_bounds(shapes)
        if box is not None:
            low, high = np.minimum(low, box[0]), np.maximum(high, box[1])
    around = merge_bounds(more)
    if around is not None:
        low, high = np.minimum(low, around[0]), np.maximum(high, around[1])
    if behind is not None:
        shapes += outline_shapes(scene, behind, look, settings.initial_colour or colours.GHOST)
    figure, axes = new_figure((low, high), camera, scene.title if extras.title is None else extras.title)
    n = len(xs)
    for i, x in enumerate(xs[:-1]):
        shapes += ghost_shapes(scene, x, look, 0.18 + 0.30 * (i + 1) / n)
    shapes += mechanism_shapes(scene, xs[-1], look, extras)
    corner_note(axes, note)
    paint(axes, camera, [*shapes, *more])
    return figure


def corner_note(axes: Axes, text: str) -> None:
    """A line in the lower left corner of the picture."""
    if text:
        axes.text(0.005, 0.01, text, transform=axes.transAxes, fontsize=7.5, color="#4d565e", zorder=31)
