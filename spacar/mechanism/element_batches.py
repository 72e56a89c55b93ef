"""Element statements to batches: one family object per keyword with its indices into x and e."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES, Deck
from spacar.deck.statement import Statement, number
from spacar.deck.table_types import coordinates_used
from spacar.elements import ElementGroup, Family, GeometryError, family_of
from spacar.errors import InputError, Message
from spacar.mechanism.layout import Batch
from spacar.mechanism.numbering import Numbering

PARAMETERS = {"EM": 9, "ESTIFF": 7, "EDAMP": 7}
ELEMENT_NUMBER = attrgetter("values")  # its first value, which no other element statement has
SHAPE_FACTOR = 3  # column of EM with the flow shape factor of tubes, 1 unless given


@dataclass(frozen=True)
class AlikeElements:
    """Elements of one keyword and measure with their places, (n_coordinates, n) and (n_deformations, n)."""

    family: type[Family]
    elements: ElementGroup
    x: Index
    e: Index
    statements: Sequence[Statement]


def element_batches(deck: Deck, numbering: Numbering, x0: Array, beams: str = "") -> list[Batch]:
    """One batch per element keyword and measure; `beams` is the measure of all beams and tubes, instead of ADEFORM.

    Raises InputError with the line of the element whose geometry is impossible.
    """
    batches, messages = [], []
    for group in element_groups(deck, numbering, x0, beams):
        try:
            family = group.family(group.elements)  # type: ignore[call-arg]
        except GeometryError as error:
            bad = group.statements[error.index]
            text = f"element {bad.values[0]}: {error}"
            messages.append(Message("error", deck.source, bad.line, bad.keyword, text, "input.geometry"))
            continue
        batches.append(Batch(family, group.x, group.e))
    if messages:
        raise InputError(messages)
    return batches


def element_groups(deck: Deck, numbering: Numbering, x0: Array, beams: str = "") -> Iterator[AlikeElements]:
    """What the constructors of the families get, in the order of `element_batches`."""
    tables = {name: _table(deck, name, width) for name, width in PARAMETERS.items()}
    linear = {int(s.values[0]) for s in deck.of("LDEFORM", block=1)}
    angles = by_angles(deck, beams)
    first_elastic = numbering.e_class["input"].stop
    directions = {int(s.values[0]): _reals(s.values[1:]) for s in deck.of("ORPINBOD", "ORTUBE", block=1)}
    projections = {int(s.values[0]): _reals(s.values[1:]) for s in deck.of("DRPINBOD", block=1)}
    present = set(numbering.keyword.values())
    measures = (False, True) if angles else (False,)
    for keyword, angle in itertools.product((k for k in ELEMENT_TYPES if k in present), measures):
        kind = ELEMENT_TYPES[keyword]
        statements = [s for s in deck.of(keyword, block=1) if (s.values[0] in angles) == angle]
        statements.sort(key=ELEMENT_NUMBER)
        if not statements:
            continue
        names = [int(s.values[0]) for s in statements]
        numbers = np.array(names, np.int64)
        first = 1 + len(kind.nodes)
        nodes = np.array([s.values[1:first] for s in statements], np.int64)
        x = np.ascontiguousarray(numbering.lnp[nodes - 1].reshape(len(nodes), -1).T[coordinates_used(kind)]) - 1
        e = np.ascontiguousarray(numbering.le[numbers - 1, : len(kind.modes)].T) - 1
        em = _rows(tables["EM"], names, PARAMETERS["EM"], x0.dtype)
        if kind.carries_flow:
            for k, n in enumerate(names):
                if len(tables["EM"].get(n, ())) <= SHAPE_FACTOR:
                    em[k, SHAPE_FACTOR] = 1.0
        group = ElementGroup(
            keyword=keyword,
            numbers=numbers,
            x0=x0[x],
            geometry=tuple(_reals(s.values[first:]) for s in statements),
            nonlinear=np.array([n not in linear for n in names]) if linear else np.ones(len(names), bool),
            directions=tuple(directions.get(n) for n in names),
            projections=tuple(projections.get(n) for n in names),
            em=em,
            estiff=_rows(tables["ESTIFF"], names, PARAMETERS["ESTIFF"], x0.dtype),
            edamp=_rows(tables["EDAMP"], names, PARAMETERS["EDAMP"], x0.dtype),
            elastic=e >= first_elastic,
        )
        yield AlikeElements(family_of(kind.angle_family if angle else kind.family), group, x, e, statements)


def by_angles(deck: Deck, beams: str = "") -> set[int]:
    """Numbers of the elements in the angle measure: those of ADEFORM, or with `beams` ("angle", "sine") all or none."""
    given = deck.of("ADEFORM", block=1)
    if beams == "angle" or (not beams and any(not s.values for s in given)):
        return {int(s.values[0]) for s in deck.of(*(k for k, t in ELEMENT_TYPES.items() if t.angle_family), block=1)}
    return {int(s.values[0]) for s in given} if not beams else set()


def node_batches(numbering: Numbering, families: Iterable[tuple[Family, Array]]) -> list[Batch]:
    """Batches of node inertia (given with their coordinate indices) and of the Euler parameter normalizations."""
    batches = [Batch(family, x, np.zeros((0, family.n), np.int64)) for family, x in families]
    if len(numbering.normalization):
        from spacar.elements.normalization import Normalization

        nodes, rows = numbering.normalization.T
        batches.append(Batch(Normalization(nodes), numbering.lnp[nodes - 1].T - 1, rows[None, :]))
    return batches


def _reals(values: Iterable[int | float | str]) -> tuple[float, ...]:
    return tuple(map(number, values))


def _table(deck: Deck, keyword: str, width: int) -> dict[int, tuple[float, ...]]:
    return {int(s.values[0]): _reals(s.values[1 : 1 + width]) for s in deck.of(keyword, block=2)}


def _rows(table: dict[int, tuple[float, ...]], names: list[int], width: int, kind: np.dtype[Any]) -> Array:
    if not table:
        return np.zeros((len(names), width), kind)
    none = (0.0,) * width
    return np.array([(values := table.get(n, ())) + none[len(values) :] for n in names], kind)
