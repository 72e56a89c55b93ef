"""Element statements to batches: one family object per keyword with its indices into x and e."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from spacar.deck import ELEMENT_TYPES, Deck
from spacar.elements import ElementGroup, Family, GeometryError, family_of
from spacar.errors import InputError, Message
from spacar.mechanism.mechanism import Array, Batch
from spacar.mechanism.numbering import Numbering

PARAMETERS = {"EM": 9, "ESTIFF": 6, "EDAMP": 6}
TUBES = ("PLTUBE", "TUBE")
SHAPE_FACTOR = 3  # column of EM with the flow shape factor of tubes, 1 unless given


def element_batches(deck: Deck, numbering: Numbering, x0: Array) -> list[Batch]:
    """One batch per element keyword. Raises InputError with the line of the element whose geometry is impossible."""
    tables = {name: _table(deck, name, width) for name, width in PARAMETERS.items()}
    linear = {int(s.values[0]) for s in deck.of("LDEFORM", block=1)}
    directions = {int(s.values[0]): _reals(s.values[1:]) for s in deck.of("ORPINBOD", "ORTUBE", block=1)}
    projections = {int(s.values[0]): _reals(s.values[1:]) for s in deck.of("DRPINBOD", block=1)}
    batches, messages = [], []
    for keyword, kind in ELEMENT_TYPES.items():
        statements = sorted(deck.of(keyword, block=1), key=lambda s: s.values[0])
        if not statements:
            continue
        numbers = np.array([s.values[0] for s in statements], np.int64)
        first = 1 + len(kind.nodes)
        size = {"position": 2 if kind.planar else 3, "orientation": 1 if kind.planar else 4}
        nodes = np.array([s.values[1:first] for s in statements], np.int64)
        x = np.concatenate([numbering.lnp[nodes[:, k] - 1, : size[role]].T - 1 for k, role in enumerate(kind.nodes)])
        e = numbering.le[numbers - 1, : len(kind.modes)].T - 1
        em = _rows(tables["EM"], numbers, PARAMETERS["EM"])
        if keyword in TUBES:
            for k, n in enumerate(numbers):
                if len(tables["EM"].get(int(n), ())) <= SHAPE_FACTOR:
                    em[k, SHAPE_FACTOR] = 1.0
        group = ElementGroup(
            keyword=keyword,
            numbers=numbers,
            x0=x0[x],
            geometry=tuple(_reals(s.values[first:]) for s in statements),
            nonlinear=np.array([int(n) not in linear for n in numbers]),
            directions=tuple(directions.get(int(n)) for n in numbers),
            projections=tuple(projections.get(int(n)) for n in numbers),
            em=em,
            estiff=_rows(tables["ESTIFF"], numbers, PARAMETERS["ESTIFF"]),
            edamp=_rows(tables["EDAMP"], numbers, PARAMETERS["EDAMP"]),
        )
        try:
            family = family_of(keyword)(group)  # type: ignore[call-arg]
        except GeometryError as error:
            bad = statements[error.index]
            text = f"element {bad.values[0]}: {error}"
            messages.append(Message("error", deck.source, bad.line, keyword, text, "input.geometry"))
            continue
        batches.append(Batch(family, np.ascontiguousarray(x), np.ascontiguousarray(e)))
    if messages:
        raise InputError(messages)
    return batches


def node_batches(numbering: Numbering, families: Iterable[tuple[Family, Array]]) -> list[Batch]:
    """Batches of node inertia (given with their coordinate indices) and of the Euler parameter normalizations."""
    batches = [Batch(family, x, np.zeros((0, family.n), np.int64)) for family, x in families]
    if len(numbering.normalization):
        from spacar.elements.normalization import Normalization

        nodes, rows = numbering.normalization.T
        batches.append(Batch(Normalization(nodes), numbering.lnp[nodes - 1].T - 1, rows[None, :]))
    return batches


def _reals(values: Iterable[int | float | str]) -> tuple[float, ...]:
    return tuple(float(v) for v in values)


def _table(deck: Deck, keyword: str, width: int) -> dict[int, tuple[float, ...]]:
    return {int(s.values[0]): _reals(s.values[1 : 1 + width]) for s in deck.of(keyword, block=2)}


def _rows(table: dict[int, tuple[float, ...]], numbers: Array, width: int) -> Array:
    rows = np.zeros((len(numbers), width))
    for k, n in enumerate(numbers):
        values = table.get(int(n), ())
        rows[k, : len(values)] = values
    return rows
