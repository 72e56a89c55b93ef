"""Stress resultants and stresses of a whole result as numbers: the same that the pictures show.

Derivatives of stress resultants and stresses with respect to numbers of the deck (docs/sensitivity.md section 4).

The formulas are those of `stresses`, with numbers that carry a complex step: resultants, dimensions of the section and
places of its points. A largest stress has the derivative of the point where it is largest.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from spacar_formats.result_files import sbd_header

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES
from spacar.deck.directed import STEP
from spacar.errors import UsageError
from spacar.mechanism import Mechanism
from spacar.modes import find_mode
from spacar.stream import Run
from spacar.summary import counted
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.scene import Scene
from spacar_drawing.sections import moments
from spacar_drawing.settings import SectionShape, parse_settings
from spacar_drawing.stresses import (
    GIVEN_BY,
    QUANTITIES,
    RESULTANTS,
    STRESSES,
    Resultants,
    of_quantity,
    resultants,
    section_points,
    stress_field,
    worst,
)

POINTS = 9  # places along an element, unless others are asked for
AT_ONCE = 100_000  # places times points of a section that are evaluated together


@dataclass(frozen=True)
class LargestStress:
    """Where a quantity has its largest modulus.

    value [unit];  step (from 1), t;  element;  xi from 0 at p to 1 at q;  y, z in the section [m], nan for resultants
    """

    quantity: str
    value: float
    unit: str
    step: int
    t: float
    element: int
    xi: float
    y: float
    z: float


@dataclass(frozen=True, repr=False)
class StressResults:
    """Resultants and stresses along all beams and trusses of a result.

    steps (k,) stored steps from 1;  t (k,) time [s] or load;  elements (m,);  xi (n,) places from p to q
    values   name -> (k, m, n): N, Qy, Qz [N], T, My, Mz [N m], B [N m^2]; normal, shear, mises [N/m^2], the largest in
             the section, nan for an element without one (a normal stress keeps its sign)
    places   name of a stress -> (k, m, n, 2): y, z [m] in the section where it is that large
    """

    steps: Index
    t: Array
    elements: Index
    xi: Array
    values: dict[str, Array]
    places: dict[str, Array]

    def __repr__(self) -> str:
        size = ", ".join(map(counted, map(len, (self.steps, self.elements, self.xi)), ("step", "element", "place")))
        known = ", ".join(name for name, value in self.values.items() if np.nan_to_num(value).any())
        return f"Stresses at {size}: {known or 'all zero'}\n  ['mises'], .largest('mises'), .table()"

    def __getitem__(self, name: str) -> Array:
        """One of `values`. Raises UsageError for another name."""
        if name not in self.values:
            raise UsageError(f"there is no {name}; quantities are {', '.join(self.values)}", "stress.name")
        return self.values[name]

    def largest(self, name: str = "mises") -> LargestStress:
        """Where the modulus of a quantity is largest. Raises UsageError when it is known nowhere."""
        value = np.abs(self[name])
        if not np.isfinite(value).any():
            text = f"{QUANTITIES[name][0]}: no element has a cross-section: give {GIVEN_BY}"
            raise UsageError(text, "stress.section")
        k, m, n = np.unravel_index(int(np.nanargmax(value)), value.shape)
        y, z = self.places[name][k, m, n] if name in self.places else (np.nan, np.nan)
        return LargestStress(
            name, float(self.values[name][k, m, n]), QUANTITIES[name][1], int(self.steps[k]), float(self.t[k]),
            int(self.elements[m]), float(self.xi[n]), float(y), float(z),
        )  # fmt: skip

    def of_elements(self) -> dict[str, Array]:
        """name -> (m,): of every element the value of largest modulus over all steps and places."""
        found = {}
        for name, value in self.values.items():
            flat = np.moveaxis(value, 1, 0).reshape(len(self.elements), -1)
            pick = np.argmax(np.where(np.isfinite(flat), np.abs(flat), -1.0), axis=1)
            found[name] = flat[np.arange(len(flat)), pick]
        return found

    def table(self) -> dict[str, Array]:
        """Columns step, t, element, xi and the quantities, a row for every place."""
        k, m, n = (len(a) for a in (self.steps, self.elements, self.xi))
        columns = {
            "step": np.repeat(self.steps, m * n), "t": np.repeat(self.t, m * n),
            "element": np.tile(np.repeat(self.elements, n), k), "xi": np.tile(self.xi, k * m),
        }  # fmt: skip
        return columns | {name: value.ravel() for name, value in self.values.items()}

    def arrays(self) -> dict[str, Array]:
        """Everything with its shape, for a NumPy archive."""
        axes = {"steps": self.steps, "t": self.t, "elements": self.elements, "xi": self.xi}
        return axes | self.values | {f"{name}_yz": value for name, value in self.places.items()}


def _whole(name: str, given: Any) -> list[int]:
    """Whole numbers, one or several. Raises UsageError."""
    found = np.atleast_1d(np.asarray(given))
    if found.dtype.kind not in "iu" and found.size:
        raise UsageError(f"{name} = {given!r:.60} must be whole numbers", "stress.numbers")
    return [int(k) for k in found.ravel()]


def stress_results(
    source: PictureSource, steps: Sequence[int] | int | None = None, elements: Iterable[int] | int | None = None,
    points: int = POINTS,
) -> StressResults:  # fmt: skip
    """See `stress` of drawing_calls. Raises UsageError for fewer than two points, too."""
    chosen = list(range(1, source.steps + 1)) if steps is None else _whole("steps", steps)
    for k in chosen:
        source.require(k)
    if _whole("points", points)[0] < 2:
        raise UsageError(f"{points} places along an element; at least 2 are needed", "stress.points")
    wanted = [source.scene.bar(n) for n in (source.scene.bars if elements is None else _whole("elements", elements))]
    if not wanted:
        raise UsageError(f"{source.name} has no beams or trusses", "stress.element")
    shape = (len(chosen), len(wanted), points)
    values = {name: np.zeros(shape) for name in RESULTANTS}
    values |= {name: np.full(shape, np.nan) for name in STRESSES}
    places = {name: np.full((*shape, 2), np.nan) for name in STRESSES}
    states = [(np.ravel(source.get("sig", k)), np.ravel(source.get("e", k))) for k in chosen]
    for m, element in enumerate(wanted):
        every = Resultants.joined([resultants(source.scene, element, sig, e, points) for sig, e in states])
        for name in RESULTANTS:
            values[name][:, m] = every.of(name).reshape(len(chosen), points)
        section = source.settings.section(element.number, element.shape)
        if section is None or moments(section) is None:
            continue
        y, z = section_points(section)
        size = max(AT_ONCE // len(y), 1)
        parts = [
            [worst(name, *field) for name in STRESSES]
            for first in range(0, len(every.N), size)
            for field in [stress_field(section, every.part(slice(first, first + size)))]
        ]
        for j, name in enumerate(STRESSES):
            value, point = (np.concatenate([part[j][i] for part in parts]) for i in range(2))
            values[name][:, m] = value.reshape(len(chosen), points)
            places[name][:, m] = np.stack((y[point], z[point]), axis=-1).reshape(len(chosen), points, 2)
    t = np.array([source.time(k) for k in chosen])
    numbers = np.array([element.number for element in wanted])
    return StressResults(np.array(chosen), t, numbers, np.linspace(0.0, 1.0, points), values, places)


class StressDerivatives:
    """Stresses of a mechanism and of the same mechanism with directions."""

    def __init__(self, mechanism: Mechanism, directions: Sequence[Mechanism], mode: int) -> None:
        deck = mechanism.deck
        self.settings = parse_settings(deck.visualization)
        self.scene = Scene.of_header(sbd_header(Run(find_mode(mode), mechanism)), deck.source)
        self.scenes = [_directed(self.scene, m) for m in directions]
        self.sections = [_sections(m) for m in directions]

    def __call__(
        self, name: str, numbers: Sequence[int], sigma: Array, e: Array, dsigma: Sequence[Array], de: Sequence[Array]
    ) -> tuple[float, Array]:
        """Value and derivatives (directions,) of a stress resultant or a stress.

        numbers   element, and place 1 to 9 from p to q; without a place the largest modulus along the element
        sigma, e  (ne,) of the state;  dsigma, de: one (ne,) for every direction

        Raises UsageError for elements, places and sections that there are not.
        """
        element = self.scene.bar(numbers[0], f"{name}[{numbers[0]}]: ", "sensitivity.quantity")
        if len(numbers) > 1 and numbers[1] > POINTS:
            text = f"{name}[{numbers[0]},{numbers[1]}]: places along an element are 1 to {POINTS}, from p to q"
            raise UsageError(text, "sensitivity.quantity")
        section = self.settings.section(element.number, element.shape)
        r = resultants(self.scene, element, sigma, e, POINTS)
        point = np.zeros(POINTS, int)
        if name in RESULTANTS:
            values = r.of(name)
        elif section is None or moments(section) is None:
            text = f"{name}[{element.number}]: the element has no cross-section; give {GIVEN_BY}"
            raise UsageError(text, "sensitivity.quantity")
        else:
            values, point = worst(name, *stress_field(section, r))
        place = numbers[1] - 1 if len(numbers) > 1 else int(np.argmax(np.abs(values)))
        rates = []
        for scene, sections, ds, d in zip(self.scenes, self.sections, dsigma, de, strict=True):
            r = resultants(scene, element, sigma + 1j * STEP * ds, e + 1j * STEP * d, POINTS)
            if name in RESULTANTS:
                moved = r.of(name)[place]
            else:
                assert section is not None
                shape = sections.get(element.number, section)
                y, z = (v[point[[place]]] for v in section_points(shape))
                moved = of_quantity(name, *stress_field(shape, r.part(slice(place, place + 1)), (y, z)))[0, 0]
            rates.append(moved.imag / STEP)
        return float(values[place]), np.array(rates)


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
    found: dict[int, SectionShape] = {}
    for use in mechanism.deck.sections:
        if use.picture is not None:
            found |= dict.fromkeys(use.parts, SectionShape(*use.picture))
    return {n: s for n, s in found.items() if moments(s) is not None}
