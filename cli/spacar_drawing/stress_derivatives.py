"""Derivatives of stress resultants and stresses with respect to numbers of the deck (docs/sensitivity.md section 4).

The formulas are those of `stresses`, with numbers that carry a complex step: resultants, dimensions of the section and
places of its points. A largest stress has the derivative of the point where it is largest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
from spacar_formats.sinks.result_header import sbd_header

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES
from spacar.deck.cross_section import SHAPES
from spacar.deck.directed import STEP
from spacar.errors import UsageError
from spacar.mechanism import Mechanism
from spacar.modes import find_mode
from spacar.stream import Run
from spacar_drawing.scene import Element, Scene
from spacar_drawing.sections import moments
from spacar_drawing.settings import SectionShape, parse_settings
from spacar_drawing.stress_numbers import POINTS
from spacar_drawing.stresses import (
    RESULTANTS,
    Resultants,
    along,
    resultants,
    section_points,
    stress_field,
    worst,
)


class StressDerivatives:
    """Stresses of a mechanism and of the same mechanism with directions."""

    def __init__(self, mechanism: Mechanism, directions: Sequence[Mechanism], mode: int) -> None:
        deck = mechanism.deck
        self.settings = parse_settings(deck.visualization)
        self.scene = Scene.of_header(sbd_header(Run(find_mode(mode), mechanism)), deck.source)
        self.scenes = [_directed(self.scene, m) for m in directions]
        self.sections = [_sections(m) for m in directions]
        self.bars = {e.number: e for e in self.scene.elements if e.shape in ("beam", "truss")}

    def __call__(
        self, name: str, numbers: Sequence[int], sigma: Array, e: Array, dsigma: Sequence[Array], de: Sequence[Array]
    ) -> tuple[float, Array]:
        """Value and derivatives (directions,) of a stress resultant or a stress.

        numbers   element, and place 1 to 9 from p to q; without a place the largest modulus along the element
        sigma, e  (ne,) of the state;  dsigma, de: one (ne,) for every direction

        Raises UsageError for elements, places and sections that there are not.
        """
        element = self._bar(name, numbers)
        section = self.settings.section(element.number, element.shape == "truss")
        r = _given(resultants(self.scene, element, sigma, e, POINTS))
        point = np.zeros(POINTS, int)
        if name in RESULTANTS:
            values = _along(name, r)
        elif section is None or moments(section) is None:
            text = f"{name}[{element.number}]: the element has no cross-section; give BEAMSEC, BEAMVIS or CROSSTYPE"
            raise UsageError(text, "sensitivity.quantity")
        else:
            values, point = worst(name, *stress_field(section, r))
        place = numbers[1] - 1 if len(numbers) > 1 else int(np.argmax(np.abs(values)))
        rates = []
        for scene, sections, ds, d in zip(self.scenes, self.sections, dsigma, de, strict=True):
            r = _given(resultants(scene, element, sigma + 1j * STEP * ds, e + 1j * STEP * d, POINTS))
            if name in RESULTANTS:
                moved = _along(name, r)[place]
            else:
                assert section is not None
                moved = _stress(name, sections.get(element.number, section), r, place, int(point[place]))
            rates.append(moved.imag / STEP)
        return float(values[place]), np.array(rates)

    def _bar(self, name: str, numbers: Sequence[int]) -> Element:
        found = self.bars.get(numbers[0])
        if found is None:
            known = ", ".join(map(str, self.bars)) or "none"
            text = f"{name}[{numbers[0]}]: element {numbers[0]} is no beam or truss; these are {known}"
            raise UsageError(text, "sensitivity.quantity")
        if len(numbers) > 1 and numbers[1] > POINTS:
            text = f"{name}[{numbers[0]},{numbers[1]}]: places along an element are 1 to {POINTS}, from p to q"
            raise UsageError(text, "sensitivity.quantity")
        return found


def _given(found: Resultants | None) -> Resultants:
    assert found is not None  # beams and trusses have resultants
    return found


def _along(name: str, r: Resultants) -> Array:
    found = along(name, r, None)
    assert found is not None
    return found


def _stress(name: str, section: SectionShape, r: Resultants, place: int, point: int) -> complex:
    """At one place along an element and one point of its section."""
    y, z = section_points(section)
    whole: dict[str, Any] = {f.name: getattr(r, f.name) for f in fields(r)}
    part: dict[str, Any] = {k: None if v is None else v[place : place + 1] for k, v in whole.items()}
    here = Resultants(**part)
    normal, shear = (complex(a[0, 0]) for a in stress_field(section, here, (y[[point]], z[[point]])))
    if name == "normal":
        return normal
    return shear if name == "shear" else (normal * normal + 3.0 * shear * shear) ** 0.5


def _directed(scene: Scene, mechanism: Mechanism) -> Scene:
    """The scene with the lengths and coefficients of a directed mechanism."""
    length, stiffness = scene.length + 0j, scene.stiffness + 0j
    for batch in mechanism.batches:
        if batch.family.keyword in ELEMENT_TYPES:
            length[batch.family.numbers - 1] = batch.family.length
    for s in mechanism.deck.of("ESTIFF", block=2):
        stiffness[s.integer(0) - 1, : len(s.values) - 1] = s.reals(1, len(s.values) - 1)
    return replace(scene, length=length, stiffness=stiffness)


def _sections(mechanism: Mechanism) -> dict[int, SectionShape]:
    """Cross-sections of BEAMSEC by element, with their directions."""
    found = {}
    for use in mechanism.deck.sections:
        drawn = SHAPES[use.shape].drawn
        if drawn is not None:
            word, dims = drawn(*use.dims)
            found.update({number: SectionShape(word, dims) for number in use.parts})
    return {n: s for n, s in found.items() if moments(s) is not None}
