"""Stresses over a cross-section: of one place of an element as a picture, with the course over height and width.

The stresses are those of `stresses.py`, at points all over the section instead of the largest among them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array
from spacar.deck.length_unit import shown_in
from spacar.errors import UsageError
from spacar_drawing.defaults import plain
from spacar_drawing.history import COLOURS
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.sections import inside, moments, outline
from spacar_drawing.settings import SectionShape
from spacar_drawing.stage import INK, RULE
from spacar_drawing.stress_numbers import part_of
from spacar_drawing.stresses import STRESSES, Resultants, of_quantity, resultants, stress_field

if TYPE_CHECKING:
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
    def size(self) -> Array:
        """(2,) extent along y', z' [m]."""
        contour = outline(self.section, 200)
        assert contour is not None
        return np.ptp(contour, axis=0)


def section_stress(source: PictureSource, step: int, element: int, xi: float) -> SectionStress:
    """Of a stored step (from 1) and an element at xi from 0 (p) to 1 (q), to the nearest thousandth.

    Raises UsageError for steps and elements that there are not, and for one without a cross-section.
    """
    if not 1 <= step <= source.steps:
        raise UsageError(f"step {step} does not exist: {source.name} has steps 1 to {source.steps}", "files.step")
    bars = {e.number: e for e in source.scene.elements if e.shape in ("beam", "truss")}
    if element not in bars:
        known = ", ".join(map(str, bars)) or "none"
        raise UsageError(f"element {element} is no beam or truss; these are {known}", "stress.element")
    if not 0.0 <= xi <= 1.0:
        raise UsageError(f"place {xi:g} is not on the element: from 0 at p to 1 at q", "stress.place")
    e = bars[element]
    section = source.settings.section(element, e.shape == "truss")
    if section is None or moments(section) is None:
        raise UsageError(
            f"element {element} has no cross-section: give BEAMSEC, BEAMVIS or CROSSTYPE", "stress.section"
        )
    every = resultants(source.scene, e, np.ravel(source.get("sig", step)), np.ravel(source.get("e", step)), PLACES)
    assert every is not None
    i = round(xi * (PLACES - 1))
    return SectionStress(section, part_of(every, slice(i, i + 1)), step, element, i / (PLACES - 1))


@plain
def section_figure(found: SectionStress, quantity: str, metre: float, title: str) -> Figure:
    """The section coloured by a stress, and its course over the height (z' at y' = 0) and the width (y' at z' = 0)."""
    from spacar_drawing.shown_figure import ShownFigure

    factor, unit = shown_in(STRESSES[quantity][1], metre)
    length = shown_in("m", metre)[1]
    w, h = found.size
    step = max(w, h) / (ACROSS - 1)
    y, z = (np.linspace(-0.5 * s, 0.5 * s, max(41, round(s / step) + 1)) for s in (w, h))
    grid = np.meshgrid(y, z)
    field = factor * found.at(quantity, grid[0].ravel(), grid[1].ravel()).reshape(grid[0].shape)
    top = float(np.nanmax(np.abs(field))) or 1.0
    signed = quantity == "normal"
    figure = ShownFigure(figsize=(8.4, 4.4), dpi=110, layout="constrained")
    left, right = figure.subplots(1, 2)
    mesh = left.pcolormesh(
        y / metre, z / metre, field, cmap="coolwarm" if signed else "viridis", vmin=-top if signed else 0.0, vmax=top,
        shading="nearest", rasterized=True,
    )  # fmt: skip
    contour = outline(found.section, 200)
    assert contour is not None
    left.fill(*(contour / metre).T, fill=False, ec=INK, lw=0.8)
    left.set_aspect("equal" if 0.05 < w / h < 20 else "auto")
    left.set_xlabel(f"y' ({length})", fontsize=8.5, color=INK)
    left.set_ylabel(f"z' ({length})", fontsize=8.5, color=INK)
    bar = figure.colorbar(mesh, ax=left)
    name = STRESSES[quantity][0].removeprefix("largest ")
    bar.set_label(f"{name} ({unit})", fontsize=8.5, color=INK)
    bar.ax.tick_params(labelsize=7.5, colors=INK)
    zero = np.zeros(ACROSS)
    for k, (label, size) in enumerate((("over the height, z' at y' = 0", h), ("over the width, y' at z' = 0", w))):
        line = np.linspace(-0.5 * size, 0.5 * size, ACROSS)
        course = factor * (found.at(quantity, zero, line) if k == 0 else found.at(quantity, line, zero))
        right.plot(course, 2 * line / size, color=COLOURS[k], lw=1.6, label=label)
    right.axvline(0.0, color="#aab4bd", lw=0.8)
    right.set_xlabel(f"{name} ({unit})", fontsize=8.5, color=INK)
    right.set_ylabel("place / half of the height or width", fontsize=8.5, color=INK)
    right.grid(True, color=RULE, lw=0.6)
    right.legend(fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(0, 1.0))
    for axes in (left, right):
        axes.tick_params(labelsize=8, colors=INK, length=0)
        for side in axes.spines.values():
            side.set(color="#cfd5da", linewidth=0.8)
    figure.suptitle(title, fontsize=10, color=INK, x=0.02, ha="left", parse_math=False)
    return figure
