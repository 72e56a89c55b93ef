"""Element statements to batches: one family object per keyword with its indices into x and e."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES, Deck, Statement, coordinates_of
from spacar.elements import ElementGroup, Family, GeometryError, family_of
from spacar.errors import InputError, Message
from spacar.mechanism.element_rows import ElementRows, value_rows
from spacar.mechanism.layout import Batch
from spacar.mechanism.numbering import Numbering

EM, ESTIFF, EDAMP = slice(0, 9), slice(9, 16), slice(16, 23)
PARAMETERS = {"EM": EM, "ESTIFF": ESTIFF, "EDAMP": EDAMP}  # columns of one table
SHAPE_FACTOR = 3  # place in EM with the flow shape factor of tubes, 1 unless given


class PlacedGroup(NamedTuple):
    """Elements of one keyword and measure with their places, (n_coordinates, n) and (n_deformations, n)."""

    family: type[Family]
    elements: ElementGroup
    x: Index
    e: Index


def element_batches(deck: Deck, numbering: Numbering, x0: Array, beams: str = "") -> list[Batch]:
    """One batch per element keyword and measure; `beams` is the measure of all beams and tubes, instead of ADEFORM.

    Raises InputError with the line of the element whose geometry is impossible.
    """
    batches: list[Batch] = []
    messages = []
    for group in element_groups(deck, numbering, x0, beams):
        try:
            family = group.family(group.elements)  # type: ignore[call-arg]
        except GeometryError as error:
            element = group.elements.numbers[error.index]
            bad = next(s for s in deck.of(group.elements.keyword, block=1) if s.values[0] == element)
            text = f"element {bad.values[0]}: {error}"
            messages.append(Message("error", deck.source, bad.line, bad.keyword, text, "input.geometry"))
            continue
        batches.append(Batch(family, group.x, group.e, len(batches)))
    if messages:
        raise InputError(messages)
    return batches


def element_groups(deck: Deck, numbering: Numbering, x0: Array, beams: str = "") -> Iterator[PlacedGroup]:
    """What the constructors of the families get, in the order of `element_batches`."""
    block, x_places, e_places = deck.block(1), numbering.x_places, numbering.e_places
    parameters = parameter_table(deck, len(e_places), x0.dtype)
    nonlinear = np.ones(len(e_places), bool)
    nonlinear[[s.integer(0) for s in block.get("LDEFORM", ())]] = False
    directions = _vectors(block, "ORPINBOD", "ORTUBE")
    projections = _vectors(block, "DRPINBOD")
    angles = by_angles(deck, beams)
    first_elastic = numbering.e_class["input"].stop
    for rows, angle in _by_measure(numbering.types, angles):
        kind, given_values, numbers, nodes = rows
        n, first, those = len(numbers), 1 + len(kind.nodes), numbers.tolist()
        own = [4 * k + i for k, role in enumerate(kind.nodes) for i in range(coordinates_of(role, kind.planar))]
        x = x_places.take(nodes, 0).reshape(n, -1).T.take(own, 0)
        e = e_places.T[: len(kind.modes)].take(numbers, 1)
        values = parameters.take(numbers, 0)
        if kind.carries_flow:
            given = {s.values[0] for s in deck.block(2).get("EM", ()) if len(s.values) > 1 + SHAPE_FACTOR}
            values[[number not in given for number in those], SHAPE_FACTOR] = 1.0
        geometry = tuple([row[first:] for row in given_values]) if kind.geometry else ((),) * n
        group = ElementGroup(
            kind.keyword, numbers, x0.take(x), geometry, nonlinear.take(numbers),
            tuple(map(directions.get, those)), tuple(map(projections.get, those)),
            values[:, EM], values[:, ESTIFF], values[:, EDAMP], e >= first_elastic if angle else None,
        )  # fmt: skip
        yield PlacedGroup(family_of(kind.angle_family if angle else kind.family), group, x, e)


def _vectors(block: Mapping[str, Sequence[Statement]], *keywords: str) -> dict[int, tuple[float, ...]]:
    return {s.values[0]: s.values[1:] for keyword in keywords for s in block.get(keyword, ())}  # type: ignore[misc]


def parameter_table(deck: Deck, n: int, kind: Any = float) -> Array:
    """(n, 23): values of EM, ESTIFF and EDAMP behind the element number, which is the row; zero where not given."""
    given = deck.index.keywords(2)
    table = np.zeros((n, EDAMP.stop), kind)
    for keyword in PARAMETERS.keys() & given:
        own = table[:, PARAMETERS[keyword]]
        for numbers, values in value_rows(deck, keyword, 2, kind):
            own[numbers, : values.shape[1]] = values[:, : own.shape[1]]
    return table


def _by_measure(types: Iterable[ElementRows], angles: set[int]) -> Iterator[tuple[ElementRows, bool]]:
    """Elements of one type and measure; `angles`: numbers of those in the angle measure."""
    for rows in types:
        numbers = rows.numbers.tolist()
        if angles.isdisjoint(numbers) or angles.issuperset(numbers):
            yield rows, numbers[0] in angles
            continue
        inside = np.isin(rows.numbers, list(angles))
        for angle in (False, True):
            here = np.flatnonzero(inside == angle)
            values = [rows.values[k] for k in here.tolist()]
            yield ElementRows(rows.kind, values, rows.numbers[here], rows.nodes[here]), angle


def by_angles(deck: Deck, beams: str = "") -> set[int]:
    """Numbers of the elements in the angle measure: those of ADEFORM, or with `beams` ("angle", "sine") all or none."""
    given = deck.block(1).get("ADEFORM", ())
    if not given and not beams:
        return set()
    if beams == "angle" or (not beams and any(not s.values for s in given)):
        block = deck.block(1)
        return {s.integer(0) for keyword in _WITH_ANGLES & block.keys() for s in block[keyword]}
    return {s.integer(0) for s in given} if not beams else set()


_WITH_ANGLES = {keyword for keyword, kind in ELEMENT_TYPES.items() if kind.angle_family}


def node_batches(batches: list[Batch], numbering: Numbering, families: Iterable[tuple[Family, Array]]) -> None:
    """Append the batches of node inertia (given with their coordinate indices) and of the normalizations of Euler
    parameters."""
    for family, x in families:
        batches.append(Batch(family, x, np.zeros((0, family.n), np.int64), len(batches)))
    if len(numbering.turning):
        family = family_of("spatial.node_inertia:Normalization")(numbering.turning)  # type: ignore[call-arg]
        rows = np.arange(numbering.normalized.start, numbering.normalized.stop)
        batches.append(Batch(family, numbering.euler, rows[None], len(batches)))
