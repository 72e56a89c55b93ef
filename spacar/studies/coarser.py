"""A model with fewer nodes: pairs of beams in one line that are alike become one beam.

Two beams A (p to m) and B (m to q) are merged when the nodes at m belong to no other element and no statement but X,
their axes are in line, and every statement about A has its like about B: the same coefficients per length (EM, ESTIFF,
EDAMP), classes, LDEFORM, ADEFORM, directions. Start values that are not zero and preloads keep both.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.divide import BEAMS, MOTIONS
from spacar.deck.statement import Value
from spacar.errors import UsageError

IN_LINE = 1e-9  # sine of the angle between the two axes, which are known to the digits of a file
KEPT = (*MOTIONS, "ESIG", "DELESIG", "MEE")


def merged(deck: Deck) -> tuple[Deck, list[int]]:
    """The model in which pairs of such beams are one beam each, and the position nodes that were left out.

    Raises UsageError when there is no such pair.
    """
    pairs = _pairs(deck)
    if not pairs:
        raise UsageError(f"{deck.source} has no two beams in one line that could be one", "study.merge")
    gone = {b: a for a, b, _ in pairs}
    nodes = {node for *_, middle in pairs for node in middle}
    beams = {s.integer(0): s for s in deck.of(*BEAMS, block=1)}
    ends = {a: b for b, a in gone.items()}
    blocks: list[list[tuple[Value, ...]]] = [[], [], []]
    for s in deck.statements:
        number = s.values[0] if s.values else None
        element = s.keyword in ELEMENT_TYPES
        if (
            (element and number in gone)
            or (s.keyword == "X" and number in nodes)
            or ((_of_element(s) or _zero(s)) and number in gone)
        ):
            continue
        values: tuple[Value, ...] = s.values
        if element and number in ends:
            half = len(ELEMENT_TYPES[s.keyword].nodes) // 2
            values = (
                *values[: 1 + half],
                *beams[ends[int(number)]].values[1 + half : 1 + 2 * half],
                *values[1 + 2 * half :],
            )
        blocks[s.block - 1].append((s.keyword, *values))
    made = Deck.build(*blocks, mode=deck.mode, source=f"{deck.source} (merged)", path=deck.path)
    return made, [middle[0] for *_, middle in pairs]


def _of_element(s: Statement) -> bool:
    """Is the first value of the statement an element?"""
    return s.keyword in ("DYNE", "RLSE", "INPUTE", "KINE", "LDEFORM", "ADEFORM", "EM", "ESTIFF", "EDAMP")


def _pairs(deck: Deck) -> list[tuple[int, int, tuple[int, ...]]]:
    """(A, B, nodes between them), no beam in two pairs."""
    elements = deck.of(*ELEMENT_TYPES, block=1)
    users: dict[int, list[int]] = {}
    for s in elements:
        for k in range(1, 1 + len(ELEMENT_TYPES[s.keyword].nodes)):
            users.setdefault(s.integer(k), []).append(s.integer(0))
    position = {s.integer(0): np.array(s.reals(1, 3)) for s in deck.of("X", block=1)}
    named = {
        s.values[0]
        for s in deck.statements
        if s.values and s.keyword not in (*ELEMENT_TYPES, "X") and not _of_element(s)
    }
    about = {s.integer(0): _about(deck.statements, s.integer(0)) for s in elements if s.keyword in BEAMS}
    by_start = {s.values[1 : 1 + len(ELEMENT_TYPES[s.keyword].nodes) // 2]: s for s in elements if s.keyword in BEAMS}
    used: set[int] = set()
    found = []
    for a in elements:
        if a.keyword not in BEAMS or a.integer(0) in used:
            continue
        half = len(ELEMENT_TYPES[a.keyword].nodes) // 2
        middle = tuple(a.integer(k) for k in range(1 + half, 1 + 2 * half))
        b = by_start.get(middle)
        if b is None or b is a or b.keyword != a.keyword or b.integer(0) in used:
            continue
        alike = a.values[1 + 2 * half :] == b.values[1 + 2 * half :] and about[a.integer(0)] == about[b.integer(0)]
        if not alike or any(len(users[m]) != 2 or m in named for m in middle):
            continue
        zero = np.zeros(3)
        p, m, q = (position.get(n, zero) for n in (a.integer(1), middle[0], b.integer(1 + half)))
        if np.linalg.norm(np.cross(m - p, q - m)) > IN_LINE * np.linalg.norm(m - p) * np.linalg.norm(q - m):
            continue
        used |= {a.integer(0), b.integer(0)}
        found.append((a.integer(0), b.integer(0), middle))
    return found


def _zero(s: Statement) -> bool:
    """Is it a start value of zero, which changes nothing?"""
    return s.keyword == "STARTDE" and not any(s.reals(2, len(s.values) - 2))


def _about(statements: Sequence[Statement], element: int) -> list[tuple[str, tuple[Value, ...]]] | object:
    """What statements say of an element; when it cannot be merged, an object that equals no other."""
    found = []
    for s in statements:
        if s.values and s.values[0] == element and s.keyword not in ELEMENT_TYPES:
            if s.keyword in KEPT and not _zero(s):
                return object()
            if _of_element(s):
                found.append((s.keyword, s.values[1:]))
    return sorted(found, key=repr)
