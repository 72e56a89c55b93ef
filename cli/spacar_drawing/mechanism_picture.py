"""A mechanism at one or more steps in one picture: shapes of all that is asked for, and the figure around them.

Steps of a result as one picture or as an animation: which steps, what stands above them, how much room they need.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from spacar_formats.getfrsbf import step_numbers

from spacar.arrays import Array
from spacar_drawing.bodies import beam_lines
from spacar_drawing.defaults import plain
from spacar_drawing.drawn_shapes import Colour, Faces, Line, Shape, merge_bounds, together, wider
from spacar_drawing.element_pictures import element_shapes
from spacar_drawing.files import MovingFigure, Pictures, evenly
from spacar_drawing.look import GHOST, Look, look_of
from spacar_drawing.paint import paint
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.scene import ROUND, Pose, Scene
from spacar_drawing.settings import PictureSettings
from spacar_drawing.stage import Camera, new_figure, view_angles
from spacar_drawing.supports import node_marks, number_labels, support_shapes, trace_lines
from spacar_drawing.symbols import Symbols, magnified, start_of

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
    angles = view_angles(view)  # checked in the plane too
    return replace(Camera.plane() if scene.planar else Camera.towards(*angles), metre=scene.metre)


def mechanism_shapes(scene: Scene, x: Array, look: Look, extras: Extras) -> list[Shape]:
    """Everything of one configuration x (nx,)."""
    pose = Pose.of(scene, x)
    shapes = element_shapes(scene, pose, look)
    if extras.supports:
        shapes += support_shapes(scene, pose, look)
    shapes += node_marks(scene, pose, look)
    shapes += number_labels(scene, pose, look, extras.node_numbers, extras.element_numbers)
    return shapes


def ghost_shapes(scene: Scene, x: Array, look: Look, strength: float) -> list[Shape]:
    """The elements only, pale: other steps of a stroboscopic picture, or the undeformed state."""
    shapes = element_shapes(scene, Pose.of(scene, x), look)
    return [fade(s, strength) for s in shapes if not isinstance(s, Faces) or s.layer < 5]


def outline_shapes(scene: Scene, x: Array, look: Look, colour: Colour | None = None) -> list[Shape]:
    """The elastic lines only, thin, in one colour; None: that of the first position."""
    colour = colour or look.settings.initial_colour or GHOST
    pose = Pose.of(scene, x)
    seen = (e for e in scene.elements if e.p and e.q and e.number not in look.settings.hidden and e.shape not in ROUND)
    alike = together(((e.shape == "beam", bool(e.warping)), e) for e in seen)
    lines = (beam_lines(scene, pose, found, look.points)[0] for found in alike.values())
    return [Line(points, colour, 1.0, 0, dashes=(5, 3)) for points in lines]


def fade(shape: Shape, strength: float) -> Shape:
    if isinstance(shape, Line):
        return replace(shape, alpha=shape.alpha * strength, layer=min(shape.layer, 1))
    if isinstance(shape, Faces):
        return replace(shape, alpha=shape.alpha * strength, layer=min(shape.layer, 0), edge=None)
    return shape


def series_bounds(scene: Scene, xs: Array, look: Look, extras: Extras, most: int = 24) -> tuple[Array, Array]:
    """Box [m] around the drawings of (a sample of) the configurations xs (steps, nx)."""
    quiet = replace(extras, node_numbers=False, element_numbers=False)
    boxes = [merge_bounds(mechanism_shapes(scene, xs[i], look, quiet)) for i in evenly(0, len(xs) - 1, most)]
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
    shapes = trace_lines(scene, every_step, traces) if traces and every_step is not None else []
    bounds = wider(series_bounds(scene, xs, look, extras), [*shapes, *more])
    if behind is not None:
        shapes += outline_shapes(scene, behind, look)
    for i, x in enumerate(xs[:-1], 1):
        shapes += ghost_shapes(scene, x, look, 0.18 + 0.30 * i / len(xs))
    shapes += mechanism_shapes(scene, xs[-1], look, extras)
    return painted(scene, extras, bounds, [*shapes, *more], note=note)


def title_of(scene: Scene, extras: Extras, *texts: str) -> str:
    """The title that is asked for, or that of the scene with what the picture shows."""
    return "   ".join(filter(None, (scene.title, *texts))) if extras.title is None else extras.title


def painted(
    scene: Scene, extras: Extras, bounds: tuple[Array, Array], shapes: Sequence[Shape], *texts: str, note: str = ""
) -> Figure:
    """A figure of shapes in a box [m], with `texts` in the title and a note in the lower left corner."""
    camera = camera_of(scene, extras.view)
    figure, axes = new_figure(bounds, camera, title_of(scene, extras, *texts))
    corner_note(axes, note)
    paint(axes, camera, shapes)
    return figure


def corner_note(axes: Axes, text: str) -> None:
    if text:
        axes.text(0.005, 0.01, text, transform=axes.transAxes, fontsize=7.5, color="#4d565e", zorder=31)


REST = "#9aa4ac"  # of the position without deflection
SAMPLES = 60  # configurations that decide the range of an animation


def chosen_steps(source: PictureSource, steps: str | int | None, strobe: int | None, moving: bool) -> list[int]:
    """Step numbers from 1. Raises UsageError for steps that do not exist."""
    if strobe:
        return evenly(1, source.steps, strobe)
    if steps is None and not moving:
        return [source.steps if source.scene.analysis.stationary else 1]
    steps = "all" if steps is None else str(steps)
    if steps.strip().lower() == "all":
        return list(range(1, source.steps + 1))
    found = step_numbers(steps, source.steps)
    numbers = [found] if isinstance(found, int) else found
    for k in numbers:
        source.require(k)
    return numbers


def configurations(source: PictureSource, numbers: Sequence[int]) -> Array:
    """(steps, nx) coordinates, reading only these steps."""
    return source.x() if len(numbers) == source.steps else np.stack([source.x(k) for k in numbers])


def step_text(source: PictureSource, k: int) -> str:
    """What is said of a step; nothing where there is one only."""
    if source.steps == 1:
        return ""
    return f"load step {k}" if source.scene.analysis.stationary else f"t = {source.time(k):.6g} s"


@plain
def picture(
    source: PictureSource, extras: Extras, numbers: Sequence[int], nodes: Sequence[int], initial: bool
) -> Figure:
    """The steps `numbers` in one figure, with paths of `nodes` and, if `initial`, the outline of the first step."""
    where = step_text(source, numbers[-1])
    if len(numbers) > 1:
        span = f"t = {source.time(numbers[0]):.4g} to {source.time(numbers[-1]):.4g} s"
        if source.scene.analysis.stationary:
            span = f"load steps {numbers[0]} to {numbers[-1]}"
        where = f"{len(numbers)} steps, {span}"
    title = title_of(source.scene, extras, where)
    place = _Placed(source, extras.scale)
    symbols = Symbols.of(source, extras.symbols, numbers[-1:])
    xs = np.stack([place(x) for x in configurations(source, numbers)])
    every = np.stack([place(x) for x in source.x()]) if nodes else None
    look = look_of(source.scene, xs if every is None else every, source.settings)
    return draw_steps(
        source.scene, xs, source.settings, replace(extras, title=place.title(title)), every_step=every, traces=nodes,
        behind=place(source.x(1)) if initial else None, look=look,
        more=[*place.undeformed(look), *symbols.shapes(numbers[-1], xs[-1], look)], note=symbols.legend,
    )  # fmt: skip


class _Placed:
    """Configurations as they are drawn: with their deflections from the start enlarged, if that is wanted."""

    def __init__(self, source: PictureSource, scale: float) -> None:
        self.scene, self.scale = source.scene, scale
        self.start = start_of(source) if scale != 1.0 else None

    def __call__(self, x: Array) -> Array:
        return x if self.start is None else magnified(self.scene, self.start, x, self.scale)

    def title(self, text: str) -> str:
        return text if self.start is None else f"{text}   deflections \N{MULTIPLICATION SIGN} {self.scale:g}"

    def undeformed(self, look: Look) -> list[Shape]:
        """The start in thin grey, behind enlarged deflections."""
        if self.start is None:
            return []
        lines = outline_shapes(self.scene, self.start, look, REST)
        return [replace(s, dashes=(), width=0.9) for s in lines if isinstance(s, Line)]


@dataclass(frozen=True)
class Series:
    """The steps `numbers` to be shown one after the other in one view; `still` shapes stay in all of them."""

    numbers: Sequence[int]
    camera: Camera
    bounds: tuple[Array, Array]
    still: Sequence[Shape]
    pictures: Pictures
    note: str

    def thinned(self, count: int) -> tuple[Pictures, int]:
        """At most `count` of them, evenly spread, and how many there are."""
        few = evenly(0, len(self.numbers) - 1, count)
        return (lambda i: self.pictures(few[i])), len(few)

    def whole(self, i: int) -> tuple[Sequence[Shape], str]:
        """Picture i with what stays, for figures whose axes are made anew (a window in which the view is turned)."""
        shapes, title = self.pictures(i)
        return [*self.still, *shapes], title

    @plain
    def moving(self) -> MovingFigure:
        """A figure for them, with what stays already in it."""
        moving = MovingFigure.create(self.bounds, self.camera, self.still)
        corner_note(moving.axes, self.note)
        return moving


def series(
    source: PictureSource, extras: Extras, numbers: Sequence[int], nodes: Sequence[int], initial: bool
) -> Series:
    """The steps as a series, with room for all of them and for the paths of `nodes`."""
    scene, place = source.scene, _Placed(source, extras.scale)
    some = [numbers[i] for i in evenly(0, len(numbers) - 1, SAMPLES)]
    sample = np.stack([place(x) for x in configurations(source, some)])
    look = look_of(scene, sample, source.settings)
    bounds = series_bounds(scene, sample, look, extras, SAMPLES)
    symbols = Symbols.of(source, extras.symbols, numbers)
    for k, x in zip(some, sample, strict=True):
        bounds = wider(bounds, symbols.shapes(k, x, look))
    still = trace_lines(scene, np.stack([place(x) for x in source.x()]), nodes) if nodes else []
    still += place.undeformed(look)
    if initial:
        still += outline_shapes(scene, place(source.x(1)), look)
    bounds = wider(bounds, still)

    def show(i: int) -> tuple[Sequence[Shape], str]:
        k = numbers[i]
        title = place.title(title_of(scene, extras, step_text(source, k)))
        x = place(source.x(k))
        return [*mechanism_shapes(scene, x, look, extras), *symbols.shapes(k, x, look)], title

    return Series(numbers, camera_of(scene, extras.view), bounds, still, show, symbols.legend)
