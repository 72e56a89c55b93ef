"""Stress resultants and stresses of a whole result as numbers: the same that the pictures show."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from spacar.arrays import Array, Index
from spacar.errors import UsageError
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.sections import moments
from spacar_drawing.stresses import (
    QUANTITIES,
    RESULTANTS,
    STRESSES,
    Resultants,
    along,
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

    value [unit];  step (from 1), t;  element;  xi from 0 at p to 1 at q;  y, z place in the section [m], nan for
    resultants
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
        size = f"{len(self.steps)} steps, {len(self.elements)} elements, {len(self.xi)} places"
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
            text = f"{QUANTITIES[name][0]}: no element has a cross-section: give BEAMSEC, BEAMVIS or CROSSTYPE"
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
            "step": np.repeat(self.steps, m * n),
            "t": np.repeat(self.t, m * n),
            "element": np.tile(np.repeat(self.elements, n), k),
            "xi": np.tile(self.xi, k * m),
        }
        return columns | {name: value.ravel() for name, value in self.values.items()}

    def arrays(self) -> dict[str, Array]:
        """Everything with its shape, for a NumPy archive."""
        axes = {"steps": self.steps, "t": self.t, "elements": self.elements, "xi": self.xi}
        return axes | self.values | {f"{name}_yz": value for name, value in self.places.items()}


def stress_results(
    source: PictureSource,
    steps: Sequence[int] | None = None,
    elements: Iterable[int] | None = None,
    points: int = POINTS,
) -> StressResults:
    """Of the stored `steps` (from 1; default all) and beams and trusses `elements` (default all), at `points` places.

    Raises UsageError for steps and elements that there are not, and for fewer than two points.
    """
    chosen = list(range(1, source.steps + 1)) if steps is None else [int(k) for k in steps]
    for k in chosen:
        if not 1 <= k <= source.steps:
            raise UsageError(f"step {k} does not exist: {source.name} has steps 1 to {source.steps}", "files.step")
    if points < 2:
        raise UsageError(f"{points} places along an element; at least 2 are needed", "stress.points")
    bars = {e.number: e for e in source.scene.elements if e.shape in ("beam", "truss")}
    wanted = list(bars) if elements is None else [int(n) for n in elements]
    for number in wanted:
        if number not in bars:
            known = ", ".join(map(str, bars)) or "none"
            raise UsageError(f"element {number} is no beam or truss; these are {known}", "stress.element")
    if not wanted:
        raise UsageError(f"{source.name} has no beams or trusses", "stress.element")
    shape = (len(chosen), len(wanted), points)
    values = {name: np.zeros(shape) for name in RESULTANTS}
    values |= {name: np.full(shape, np.nan) for name in STRESSES}
    places = {name: np.full((*shape, 2), np.nan) for name in STRESSES}
    states = [(np.ravel(source.get("sig", k)), np.ravel(source.get("e", k))) for k in chosen]
    for m, number in enumerate(wanted):
        element = bars[number]
        found = [resultants(source.scene, element, sig, e, points) for sig, e in states]
        every = _joined([r for r in found if r is not None])
        for name in RESULTANTS:
            of_all = along(name, every, None)
            assert of_all is not None
            values[name][:, m] = of_all.reshape(len(chosen), points)
        section = source.settings.section(number, element.shape == "truss")
        if section is None or moments(section) is None:
            continue
        y, z = section_points(section)
        size = max(AT_ONCE // len(y), 1)
        parts = [
            [worst(name, *field) for name in STRESSES]
            for first in range(0, len(every.N), size)
            for field in [stress_field(section, part_of(every, slice(first, first + size)))]
        ]
        for j, name in enumerate(STRESSES):
            value, point = (np.concatenate([part[j][i] for part in parts]) for i in range(2))
            values[name][:, m] = value.reshape(len(chosen), points)
            places[name][:, m] = np.stack((y[point], z[point]), axis=-1).reshape(len(chosen), points, 2)
    t = np.array([float(np.ravel(source.get("t", k))[0]) for k in chosen])
    return StressResults(np.array(chosen), t, np.array(wanted), np.linspace(0.0, 1.0, points), values, places)


def _joined(parts: Sequence[Resultants]) -> Resultants:
    """Resultants of several steps as those of one long element."""

    def together(name: str) -> Any:
        given = [getattr(r, name) for r in parts]
        return None if given[0] is None else np.concatenate(given)

    return Resultants(**{f.name: together(f.name) for f in fields(Resultants)})


def part_of(r: Resultants, places: slice) -> Resultants:
    """The resultants at some of their places."""

    def part(name: str) -> Any:
        value = getattr(r, name)
        return None if value is None else value[places]

    return Resultants(**{f.name: part(f.name) for f in fields(r)})
