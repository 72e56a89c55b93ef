"""Colours of `spacar view --stress`: a stress or stress resultant along beams and trusses, over all pictures.

Every frame of the mesh along an elastic line, and of a truss that is drawn as a spring, gets a number for every
picture, 0 ... LAST for the range of the colours, NONE where there is no finite value; the page mixes the palette
between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacar.deck.length_unit import shown_in
from spacar.errors import UsageError
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.stress_picture import colour_range, courses
from spacar_drawing.stresses import QUANTITIES
from spacar_drawing.viewer_mesh import TriangleMesh

NONE, LAST = 65535, 65534
SHADES = 9  # of the palette


@dataclass(frozen=True)
class FieldColours:
    """numbers (pictures, frames); low, high the range, in `unit`; palette SHADES colours of 0 ... 255."""

    name: str
    unit: str
    low: float
    high: float
    palette: list[list[int]]
    numbers: NDArray[np.uint16]

    def described(self) -> dict[str, Any]:
        """What the page needs besides the numbers."""
        return {"name": self.name, "unit": self.unit, "low": self.low, "high": self.high, "palette": self.palette}


def field_colours(source: PictureSource, mesh: TriangleMesh, chosen: Sequence[int], quantity: str) -> FieldColours:
    """The quantity (of QUANTITIES) at the steps that the pictures show.

    Raises UsageError for an unknown quantity, when no element has it, and for a result without stresses.
    """
    if quantity not in QUANTITIES:
        raise UsageError(f"there is no stress '{quantity}'; expected {', '.join(QUANTITIES)}", "draw.stress")
    values = np.full((len(chosen), mesh.frames), np.nan)
    owner = np.zeros(mesh.frames, np.int64)
    if mesh.frame:
        owner[np.concatenate(mesh.frame)] = np.concatenate(mesh.element)
    trusses = {e.number: np.flatnonzero(owner == e.number) for e in source.scene.elements if e.shape == "truss"}
    counts = sorted({n for _, _, n in mesh.lines}) or [2]
    for k, step in enumerate(chosen):
        sig, e = (np.ravel(source.get(name, step)) for name in ("sig", "e"))
        for n in counts:
            found = {
                c.element.number: c.values for c in courses(source.scene, sig, e, source.settings, quantity, n)
            }
            for first, elements, points in mesh.lines:
                for i, number in enumerate(elements if points == n else ()):
                    if number in found:
                        values[k, first + i * n : first + (i + 1) * n] = found[number]
        for number, frames in trusses.items():  # uniform, however it is drawn
            if number in found:
                values[k, frames] = found[number][0]
    low, high, colours = colour_range(values, quantity)
    known = np.isfinite(values)
    numbers = np.where(known, np.rint(LAST * (np.where(known, values, low) - low) / (high - low)), NONE)
    shades = colours(np.linspace(0.0, 1.0, SHADES))
    unit = shown_in(QUANTITIES[quantity][1], source.scene.metre)[1]
    palette = np.rint(255 * shades[:, :3]).astype(int).tolist()
    return FieldColours(QUANTITIES[quantity][0], unit, low, high, palette, numbers.astype(np.uint16))
