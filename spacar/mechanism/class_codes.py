"""Classes of coordinates and deformations, from statements and defaults (input-language.md sections 4.2 and 4.3, notes
k5, k6).

A class is the place of its name in the order of numbering, X_ORDER or E_ORDER; ABSENT stands for a coordinate or
deformation that does not exist. Nodes have four places, one after the other, elements as many as the widest type, and
the number 0, which nobody has, comes first.
Warping coordinates are dynamic without a statement, the deformations that belong to them calculable
(theory-warping.md section 1); other coordinates are calculable, other deformations fixed.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from spacar.deck import Deck, coordinates_of
from spacar.deck.table_types import ElementType
from spacar.mechanism.element_rows import ElementRows

X_ORDER = ("fixed", "calculable", "input", "dynamic", "kinematic")
E_ORDER = ("fixed", "input", "dynamic", "kinematic", "calculable")
X_STATEMENTS = {"FIX": "fixed", "INPUTX": "input", "DYNX": "dynamic", "KINX": "kinematic"}
E_STATEMENTS = {"RLSE": "calculable", "INPUTE": "input", "DYNE": "dynamic", "KINE": "kinematic"}
ABSENT = 255
ROLES = ("", "position", "orientation", "warping")  # of nodes; their places are the codes of `node_roles`

_X_CODE = {keyword: X_ORDER.index(name) for keyword, name in X_STATEMENTS.items()}
_E_CODE = {keyword: E_ORDER.index(name) for keyword, name in E_STATEMENTS.items()}


def _default(role: str, planar: bool) -> list[int]:
    there = coordinates_of(role, planar) if role else 0
    return [X_ORDER.index("dynamic" if role == "warping" else "calculable")] * there + [ABSENT] * (4 - there)


def _independent(role: str, planar: bool) -> range:
    """Coordinates that a statement without coordinate numbers is about: lambda0 follows from the normalization."""
    there = coordinates_of(role, planar) if role else 0
    return range(2 if role == "orientation" and not planar else 1, 1 + there)


_DEFAULT = {planar: np.array([_default(role, planar) for role in ROLES], np.uint8) for planar in (True, False)}
_INDEPENDENT = {planar: [_independent(role, planar) for role in ROLES] for planar in (True, False)}


def node_roles(types: Sequence[ElementRows]) -> NDArray[np.uint8]:
    """(1 + highest node number,) the role of every node, as a place in ROLES."""
    roles = np.zeros(1 + max([rows.nodes.max() for rows in types]), np.uint8)
    for rows in types:
        roles.put(rows.nodes, _roles_of(rows.kind))  # again for every element
    return roles


@cache
def _roles_of(kind: ElementType) -> NDArray[np.uint8]:
    return np.array([ROLES.index(role) for role in kind.nodes], np.uint8)


def x_codes(deck: Deck, roles: NDArray[np.uint8], planar: bool) -> bytearray:
    """Class of every coordinate, four for each node."""
    codes, of = bytearray(_DEFAULT[planar].take(roles, 0)), roles.tobytes()
    for s in deck.of(*X_STATEMENTS, block=1):
        node, *which = s.integers()
        if node < len(of):
            first, code = 4 * node - 1, _X_CODE[s.keyword]
            for coordinate in which or _INDEPENDENT[planar][of[node]]:
                if codes[first + coordinate] != ABSENT:
                    codes[first + coordinate] = code
    return codes


@cache
def _fixed(kind: ElementType, width: int) -> NDArray[np.uint8]:
    """(width,) all modes of an element fixed."""
    there = len(kind.modes)
    return np.array([E_ORDER.index("fixed")] * there + [ABSENT] * (width - there), np.uint8)


def e_codes(deck: Deck, types: Sequence[ElementRows]) -> tuple[bytearray, int]:
    """Class of every deformation, and how many places an element has: 6, in a model with warping 8."""
    width = max([6, *(len(rows.kind.modes) for rows in types)])
    codes = bytearray([ABSENT]) * (width * (1 + max([rows.numbers.item(-1) for rows in types])))
    table = np.frombuffer(codes, np.uint8).reshape(-1, width)
    for rows in types:
        table[rows.numbers] = _fixed(rows.kind, width)
    classed: dict[int, tuple[int, ...]] = {}
    for s in deck.of(*E_STATEMENTS, block=1):
        element, *which = s.integers()
        if not which:
            classed = classed or {n: rows.kind.classed for rows in types for n in rows.numbers.tolist()}
            which = list(classed[element])
        first, code = width * element - 1, _E_CODE[s.keyword]
        for mode in which:
            codes[first + mode] = code
    for rows in types:
        for mode in rows.kind.released:
            table[rows.numbers, mode - 1] = E_ORDER.index("calculable")
    return codes, width
