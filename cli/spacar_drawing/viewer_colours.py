"""Colours of `spacar view --stress`: a stress or stress resultant along beams and trusses, over all pictures.

Every frame of the mesh along an elastic line gets a number for every picture, 0 ... LAST for the range of the colours,
NONE where the quantity does not exist; the page mixes the palette between them.
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
from spacar_drawing.stress_picture import courses
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
    from matplotlib import colormaps

    if quantity not in QUANTITIES:
        raise UsageError(f"there is no stress '{quantity}'; expected {', '.join(QUANTITIES)}", "draw.stress")
    values = np.full((len(chosen), mesh.frames), np.nan)
    for k, step in enumerate(chosen):
        sig, e = (np.ravel(source.get(name, step)) for name in ("sig", "e"))
        for n in sorted({n for _, _, n in mesh.lines}):
            found = {
                c.element.number: c.values for c in courses(source.scene, sig, e, source.settings, quantity, n)
            }
            for first, elements, points in mesh.lines:
                for i, number in enumerate(elements if points == n else ()):
                    if number in found:
                        values[k, first + i * n : first + (i + 1) * n] = found[number]
    magnitude = quantity in ("mises", "shear")
    top = float(np.nanmax(np.abs(values), initial=0.0)) or 1.0
    low = 0.0 if magnitude else -top
    numbers = np.where(np.isnan(values), NONE, np.rint(LAST * (np.nan_to_num(values) - low) / (top - low)))
    shades = colormaps["viridis" if magnitude else "coolwarm"](np.linspace(0.0, 1.0, SHADES))
    unit = shown_in(QUANTITIES[quantity][1], source.scene.metre)[1]
    palette = np.rint(255 * shades[:, :3]).astype(int).tolist()
    return FieldColours(QUANTITIES[quantity][0], unit, low, top, palette, numbers.astype(np.uint16))
