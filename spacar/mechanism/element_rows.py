"""What numbering and element families are made of: the elements of a deck by type, and classes, as arrays.

Classes of coordinates and deformations follow from statements and defaults (input-language.md sections 4.2 and 4.3,
notes k5, k6). A class is the place of its name in X_ORDER or, behind those, in E_ORDER, so that codes are in the order
of numbering; ABSENT stands for a coordinate or deformation that does not exist. Nodes have four places, one after the
other, elements as many as the widest type, and the number 0, which nobody has, comes first.
Warping coordinates are dynamic without a statement, the deformations that belong to them calculable
(theory-warping.md section 1); other coordinates are calculable, other deformations fixed.
"""

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES, Deck, coordinates_of
from spacar.deck.table_types import ELEMENT_CLASSES, NODE_CLASSES, ElementType, independent_of


class ElementRows(NamedTuple):
    """All elements of one type, sorted by their numbers: the values of the statements, numbers (n,), nodes (n, nodes of
    the type)."""

    kind: ElementType
    values: list[tuple[Any, ...]]
    numbers: Index
    nodes: Index


def element_rows(deck: Deck) -> list[ElementRows]:
    """The elements of every type that a deck has, in the order of the element types."""
    index = deck.index
    found = []
    for keyword in sorted(ELEMENT_TYPES.keys() & index.keywords(1), key=_place):
        kind = ELEMENT_TYPES[keyword]
        values = sorted(index.rows(keyword, 1))  # by their first ones, which no other element has
        first = 1 + len(kind.nodes)
        table = _table([row[:first] for row in values], np.int64)
        found.append(ElementRows(kind, values, table[:, 0], table[:, 1:]))
    return found


_place = {keyword: k for k, keyword in enumerate(ELEMENT_TYPES)}.__getitem__


def _table(rows: Sequence[Sequence[Any]], kind: Any) -> Array:
    return np.fromiter(chain.from_iterable(rows), kind, len(rows) * len(rows[0])).reshape(len(rows), -1)


def value_rows(deck: Deck, keyword: str, block: int, kind: Any = float) -> Iterator[tuple[Index, Array]]:
    """First values of statements (n,) and the values behind them (n, count), in file order: a pair of arrays for all
    that follow each other with equally many values."""
    for group in deck.index.groups_of(keyword, block=block):
        table = np.fromiter(group.values, kind, len(group.values)).reshape(-1, group.width)
        yield table[:, 0].real.astype(np.int64), table[:, 1:]


X_ORDER = ("fixed", "calculable", "input", "dynamic", "kinematic")
E_ORDER = ("fixed", "input", "dynamic", "kinematic", "calculable")
ABSENT = len(X_ORDER) + len(E_ORDER)
ROLES = ("", "position", "orientation", "warping")  # of nodes; their places are the codes of `class_codes`


def _x(name: str) -> int:
    return X_ORDER.index(name)


def _e(name: str) -> int:
    return len(X_ORDER) + E_ORDER.index(name)


NAMES = {"prescribed": "input"}  # where the class of a statement is called otherwise here
_X_CODE = {keyword: _x(NAMES.get(name, name)) for keyword, name in NODE_CLASSES.items()}
_E_CODE = {keyword: _e(NAMES.get(name, name)) for keyword, name in ELEMENT_CLASSES.items()}
_AS_INPUT = bytes.maketrans(bytes([_x("dynamic"), _e("dynamic")]), bytes([_x("input"), _e("input")]))


def class_codes(
    deck: Deck, types: Sequence[ElementRows], prescribed: bool
) -> tuple[bytearray, int, int, NDArray[np.uint8]]:
    """The classes of everything in a deck with these elements. `prescribed`: what is dynamic is an input.

    Codes; how many of them, the first, belong to nodes; the places of an element; (1 + highest node,) place in ROLES of
    every node.
    """
    planar = types[0].kind.planar
    width = max([6, *[len(rows.kind.modes) for rows in types]])  # 8 in a model with warping
    roles = np.zeros(1 + max([rows.nodes.max() for rows in types]), np.uint8)
    elements = np.zeros(1 + max([rows.numbers.item(-1) for rows in types]), np.uint8)
    of_role = np.full((len(ROLES), 4), ABSENT, np.uint8)  # without a statement
    of_type = np.full((1 + len(types), width), ABSENT, np.uint8)
    for code, role in enumerate(ROLES[1:], 1):
        of_role[code, : coordinates_of(role, planar)] = _x("dynamic" if role == "warping" else "calculable")
    for code, rows in enumerate(types, 1):
        roles.put(rows.nodes, [ROLES.index(role) for role in rows.kind.nodes])  # again for every element
        elements[rows.numbers] = code
        modes = range(1, 1 + len(rows.kind.modes))
        of_type[code, : len(modes)] = [_e("calculable" if m in rows.kind.released else "fixed") for m in modes]
    codes = bytearray(of_role.take(roles, 0))
    of_nodes = len(codes)
    codes += of_type.take(elements, 0).tobytes()
    independent = [(), *[independent_of(role, planar) for role in ROLES[1:]]]
    classed = [(), *[rows.kind.classed for rows in types]]
    index, given = deck.index, deck.index.keywords(1)
    for keywords, kinds, every, first, size in (
        (_X_CODE, roles, independent, -1, 4),
        (_E_CODE, elements, classed, of_nodes - 1, width),
    ):
        of = kinds.tobytes()
        for keyword, code in keywords.items():
            for number, *which in index.rows(keyword, 1) if keyword in given else ():
                if number < len(of) and of[number]:  # a node that no element uses has a warning
                    before = first + size * number
                    for k in which or every[of[number]]:
                        codes[before + k] = code
    return codes.translate(_AS_INPUT) if prescribed else codes, of_nodes, width, roles
