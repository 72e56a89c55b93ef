"""Stresses and stress resultants on the mechanism: as colours along the beams, or as diagrams beside them.

Stresses over a cross-section: of one place of an element as a picture, with the course over height and width.

The stresses are those of `stresses.py`, at points all over the section instead of the largest among them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from spacar.arrays import Array
from spacar.deck.length_unit import shown_in
from spacar.errors import UsageError
from spacar_drawing.bodies import beam_lines, slender
from spacar_drawing.defaults import plain
from spacar_drawing.drawn_shapes import Faces, Label, Line, Shape, sweep, wider
from spacar_drawing.history import COLOURS
from spacar_drawing.look import SYMBOL, look_of
from spacar_drawing.mechanism_picture import Extras, mechanism_shapes, painted, series_bounds
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.scene import Element, Pose
from spacar_drawing.sections import inside, moments, outline
from spacar_drawing.settings import SectionShape
from spacar_drawing.stage import INK, blank, dress, head, widened
from spacar_drawing.stresses import (
    GIVEN_BY,
    QUANTITIES,
    STRESSES,
    Resultants,
    along,
    of_quantity,
    resultants,
    stress_field,
)

if TYPE_CHECKING:
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

ACROSS = 121  # points over the larger side of a section
PLACES = 1001  # along an element, from which the one that is asked for is taken


@dataclass(frozen=True)
class SectionStress:
    """Stresses at one place of an element: `at` gives normal and shear stress at points y, z [m] of its section."""

    section: SectionShape
    resultants: Resultants
    step: int
    element: int
    xi: float

    def at(self, quantity: str, y: Array, z: Array) -> Array:
        """(m,) one of STRESSES [N/m^2] at points (m,); nan where there is no material."""
        normal, shear = stress_field(self.section, self.resultants, (y, z))
        return np.where(inside(self.section, y, z), of_quantity(quantity, normal, shear)[0], np.nan)

    @property
    def contour(self) -> Array:
        """(k, 2) points y', z' [m]."""
        contour = outline(self.section, 200)
        assert contour is not None
        return contour


def section_stress(source: PictureSource, step: int, element: int, xi: float) -> SectionStress:
    """Of a stored step (from 1) and an element at xi from 0 (p) to 1 (q), to the nearest thousandth.

    Raises UsageError for steps and elements that there are not, and for one without a cross-section.
    """
    source.require(step)
    e = source.scene.bar(element)
    if not 0.0 <= xi <= 1.0:
        raise UsageError(f"place {xi:g} is not on the element: from 0 at p to 1 at q", "stress.place")
    section = source.settings.section(element, e.shape)
    if section is None or moments(section) is None:
        text = f"element {element} has no cross-section: give {GIVEN_BY}"
        raise UsageError(text, "stress.section")
    every = resultants(source.scene, e, *_state(source, step), PLACES)
    i = round(xi * (PLACES - 1))
    return SectionStress(section, every.part(slice(i, i + 1)), step, element, i / (PLACES - 1))


@plain
def section_figure(found: SectionStress, quantity: str, metre: float, title: str) -> Figure:
    """The section coloured by a stress, and its course over the height (z' at y' = 0) and the width (y' at z' = 0)."""
    factor, unit = shown_in(STRESSES[quantity][1], metre)
    length = shown_in("m", metre)[1]
    w, h = np.ptp(found.contour, axis=0)
    step = max(w, h) / (ACROSS - 1)
    y, z = (np.linspace(-0.5 * s, 0.5 * s, max(41, round(s / step) + 1)) for s in (w, h))
    grid = np.meshgrid(y, z)
    field = factor * found.at(quantity, grid[0].ravel(), grid[1].ravel()).reshape(grid[0].shape)
    top = np.nanmax(np.abs(field)) or 1.0
    signed = quantity == "normal"
    figure = blank(8.4, 4.4, layout="constrained")
    left, right = figure.subplots(1, 2)
    mesh = left.pcolormesh(
        y / metre, z / metre, field, cmap="coolwarm" if signed else "viridis", vmin=-top if signed else 0.0, vmax=top,
        shading="nearest", rasterized=True,
    )  # fmt: skip
    left.fill(*(found.contour / metre).T, fill=False, ec=INK, lw=0.8)
    left.set_aspect("equal" if 0.05 < w / h < 20 else "auto")
    dress(left, f"y' ({length})", f"z' ({length})")
    left.grid(False)
    bar = figure.colorbar(mesh, ax=left)
    name = STRESSES[quantity][0].removeprefix("largest ")
    bar.set_label(f"{name} ({unit})", fontsize=8.5, color=INK)
    bar.ax.tick_params(labelsize=7.5, colors=INK)
    part, zero = np.linspace(-1.0, 1.0, ACROSS), np.zeros(ACROSS)
    lines = (
        ("over the height, z' at y' = 0", zero, 0.5 * h * part),
        ("over the width, y' at z' = 0", 0.5 * w * part, zero),
    )
    for (label, *at), colour in zip(lines, COLOURS, strict=False):
        right.plot(factor * found.at(quantity, *at), part, color=colour, lw=1.6, label=label)
    right.axvline(0.0, color="#aab4bd", lw=0.8)
    dress(right, f"{name} ({unit})", "place / half of the height or width")
    right.legend(fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(0, 1.0))
    head(figure, title, x=0.02, ha="left")
    return figure


HEIGHT = 0.16  # of the largest ordinate of a diagram, of the extent of the mechanism
ALONG_Z = ("My", "Qz")  # quantities that are drawn along local z' of spatial beams; the others along y'
POSITIVE, NEGATIVE = "#c0392b", "#2471a3"


def courses(source: PictureSource, step: int, quantity: str, n: int) -> list[tuple[Element, Array]]:
    """The quantity (n,) at a step along every element that has it, in the unit of the scene; UsageError if none has."""
    state, found = _state(source, step), []
    factor = shown_in(QUANTITIES[quantity][1], source.scene.metre)[0]
    for e, section in _seen(source):
        values = along(quantity, resultants(source.scene, e, *state, n), section)
        if values is not None:
            found.append((e, factor * values))
    return found or _nowhere(quantity)


def _seen(source: PictureSource) -> list[tuple[Element, SectionShape | None]]:
    """Beams and trusses that are not hidden, with their cross-sections."""
    settings = source.settings
    shown = (e for e in source.scene.bars.values() if e.number not in settings.hidden)
    return [(e, settings.section(e.number, e.shape)) for e in shown]


@plain
def stress_still(
    source: PictureSource, step: int, extras: Extras, quantity: str, note: str = "", surface: bool = False
) -> Figure:
    """The mechanism at a step with the quantity as colours along its beams, and a scale with the unit. `surface`: a
    stress at every point of the surface, not the largest in the section. Raises UsageError when no element has it."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    scene, settings, x = source.scene, source.settings, source.x(step)
    look, pose = look_of(scene, x[None], settings), Pose.of(scene, x)
    n = max(look.points, 17)
    name = QUANTITIES[quantity][0].removeprefix("largest " if surface else "")
    if surface:
        parts = _surfaces(source, step, pose, quantity, n)
    else:
        parts = [(e, v, 0.5 * (v[:-1] + v[1:]), None) for e, v in courses(source, step, quantity, n)]
    low, high, colours = colour_range(np.concatenate([values for _, values, _, _ in parts]), quantity)
    norm = Normalize(low, high)
    hidden = settings.hidden | {element.number for element, *_ in parts}
    shapes = mechanism_shapes(scene, x, look_of(scene, x[None], replace(settings, hidden=hidden)), extras)
    for element, _, shown, quads in parts:
        rgb = np.asarray(colours(norm(shown)))[:, :3]
        if quads is None:
            shapes += slender(scene, pose, look, [element], n, rgb[None], 4.0, 0.45)
        else:
            shapes.append(Faces(quads, rgb, None, 1.0, 1, False))
    figure = painted(scene, extras, series_bounds(scene, x[None], look, extras), shapes, note, name)
    unit = shown_in(QUANTITIES[quantity][1], scene.metre)[1]
    _scale(figure, ScalarMappable(norm, colours), f"{name} ({unit})")
    return figure


def _state(source: PictureSource, step: int) -> tuple[Array, Array]:
    """(ne,) stresses and deformations."""
    return np.ravel(source.get("sig", step)), np.ravel(source.get("e", step))


def _surfaces(
    source: PictureSource, step: int, pose: Pose, quantity: str, n: int
) -> list[tuple[Element, Array, Array, Array | None]]:
    """Of every element with a section the stress in quadrilaterals (m, 4, 3), twice, and these: over the height of
    planar beams, around the outline of spatial ones."""
    found: list[tuple[Element, Array, Array, Array | None]] = []
    scene, state = source.scene, _state(source, step)
    factor = shown_in(QUANTITIES[quantity][1], scene.metre)[0]
    for element, section in _seen(source):
        contour = outline(section, 40)
        if section is None or contour is None:
            continue
        r = resultants(scene, element, *state, n)
        points, y, z = (v[0] for v in beam_lines(scene, pose, [element], n))
        around = _across(contour) if scene.planar else _finer(contour)
        middle = 0.5 * (around + np.roll(around, -1, axis=0))[: -1 if scene.planar else None]
        stress = of_quantity(quantity, *stress_field(section, r, (middle[:, 0], middle[:, 1])))
        corners = sweep(around, points, y, z).reshape(n - 1, len(around), 4, 3)[:, : len(middle)]
        values = factor * (0.5 * (stress[:-1] + stress[1:])).ravel()
        found.append((element, values, values, corners.reshape(-1, 4, 3)))
    return found or _nowhere(quantity)


def _nowhere(quantity: str) -> NoReturn:
    """Raises UsageError: no element has the quantity."""
    need = f"no element has a cross-section: give {GIVEN_BY}, or --section"
    text = need if quantity in STRESSES else "no beams or trusses"
    raise UsageError(f"{QUANTITIES[quantity][0]}: {text}", "draw.stress")


def _finer(contour: Array) -> Array:
    """The outline (k, 2) with points between its corners, none further apart than a sixteenth of the larger side."""
    after = np.roll(contour, -1, axis=0)
    most = np.max(np.ptp(contour, axis=0)) / 16
    pieces = [
        a + np.arange(m)[:, None] / m * (b - a)
        for a, b in zip(contour, after, strict=True)
        for m in [max(1, int(np.ceil(np.linalg.norm(b - a) / most - 1e-9)))]
    ]
    return np.concatenate(pieces)


def _across(contour: Array) -> Array:
    """(17, 2) points over the width along y', which is the height of a planar beam in its picture."""
    return np.stack((np.linspace(contour[:, 0].min(), contour[:, 0].max(), 17), np.zeros(17)), axis=1)


@plain
def diagram_still(source: PictureSource, step: int, extras: Extras, quantity: str, note: str = "") -> Figure:
    """The quantity as ordinates beside the beams, red where positive and blue where negative, extremes with numbers."""
    scene, x = source.scene, source.x(step)
    look = look_of(scene, x[None], source.settings)
    found = courses(source, step, quantity, max(look.points, 17))
    largest = max(np.max(np.abs(values)) for _, values in found)
    factor = HEIGHT * look.size / SYMBOL / largest if largest else 0.0
    pose = Pose.of(scene, x)
    shapes: list[Shape] = []
    marks: list[tuple[float, Label]] = []
    for element, values in found if factor else ():
        points, y, z = (v[0] for v in beam_lines(scene, pose, [element], len(values)))
        tips = points + factor * values[:, None] * (z if quantity in ALONG_Z and not scene.planar else y)
        positive = values[:-1] + values[1:] >= 0
        quads = np.stack((points[:-1], points[1:], tips[1:], tips[:-1]), axis=1)
        for part, colour in ((positive, POSITIVE), (~positive, NEGATIVE)):
            if part.any():
                shapes.append(Faces(quads[part], colour, None, 0.25, 3, False))
        shapes.append(Line(np.concatenate((points[:1], tips, points[-1:])), INK, 0.8, 4))
        for i in (0, -1):
            if abs(values[i]) > 0.02 * largest:
                text = f"{values[i]:.4g}".replace("-", "\N{MINUS SIGN}")
                marks.append((abs(values[i]), Label(tips[i], text, "#33414d")))
    kept: list[Label] = []  # one where neighbouring elements have the same value at the same place
    for _, label in sorted(marks, key=lambda m: -m[0]):
        if all(np.linalg.norm(label.at - other.at) > 0.8 * look.size for other in kept):
            kept.append(label)
    shapes += kept
    shapes += mechanism_shapes(scene, x, look, extras)
    bounds = wider(series_bounds(scene, x[None], look, extras), [s for s in shapes if not isinstance(s, Label)])
    title = f"{QUANTITIES[quantity][0]} ({shown_in(QUANTITIES[quantity][1], scene.metre)[1]})"
    return painted(scene, extras, bounds, shapes, note, title)


def colour_range(values: Array, quantity: str) -> tuple[float, float, Colormap]:
    """Limits and colours: from zero for magnitudes, symmetric for signed quantities. What is not finite is left out."""
    from matplotlib import colormaps

    top = float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0)) or 1.0
    if quantity in ("mises", "shear"):
        return 0.0, top, colormaps["viridis"]
    return -top, top, colormaps["coolwarm"]


def _scale(figure: Figure, mappable: Any, label: str) -> None:
    """A colour scale in a strip to the right, for which the figure is made wider."""
    box, width = figure.axes[0].get_position(), widened(figure, 1.05)
    whole = width + 1.05
    strip = figure.add_axes(((width + 0.05) / whole, box.y0 + 0.08 * box.height, 0.16 / whole, 0.84 * box.height))
    bar = figure.colorbar(mappable, cax=strip)
    bar.ax.tick_params(labelsize=7.5, colors=INK)
    bar.set_label(label, fontsize=8.5, color=INK)
    bar.outline.set_linewidth(0.6)
    bar.ax.ticklabel_format(axis="y", scilimits=(-3, 4))
    bar.ax.yaxis.get_offset_text().set_fontsize(7.5)
