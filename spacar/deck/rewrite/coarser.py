"""A model with fewer nodes: pairs of beams in one line that are alike become one beam.

Two beams A (p to m) and B (m to q) are merged when the nodes at m belong to no other element and no statement but X,
their axes are in line, and every statement about A has its like about B: the same coefficients per length (EM, ESTIFF,
EDAMP), classes, LDEFORM, ADEFORM, directions. Start values that are not zero and preloads keep both.
"""

from collections.abc import Sequence

import numpy as np

from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.deck import rebuilt
from spacar.deck.deck_writer import rows
from spacar.deck.rewrite.divide import ALIKE, BEAMS, CLASSES
from spacar.deck.rewrite.references import ELEMENT, NODE, about, named
from spacar.deck.statement import Value
from spacar.errors import UsageError

IN_LINE = 1e-9  # sine of the angle between the two axes, which are known to the digits of a file


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
    found = []
    for s in deck.statements:
        number = about(s)
        if number in gone or (s.keyword == "X" and s.integer(0) in nodes):
            continue
        if number in ends and s.keyword in ELEMENT_TYPES:
            (p, q), end = _ends(s), _ends(beams[ends[number]])[1]
            s = s._replace(values=(s.values[0], *p, *end, *s.values[1 + len(p + q) :]))
        found.append(s)
    made = rebuilt(deck, *rows(found), what=" (merged)")
    return made, [middle[0] for *_, middle in pairs]


def _pairs(deck: Deck) -> list[tuple[int, int, tuple[int, ...]]]:
    """(A, B, nodes between them), no beam in two pairs."""
    elements = deck.of(*ELEMENT_TYPES, block=1)
    users: dict[int, list[int]] = {}
    for s in elements:
        for node in named(s, NODE):
            users.setdefault(node, []).append(s.integer(0))
    position = {s.integer(0): np.array(s.reals(1, 3)) for s in deck.of("X", block=1)}
    needed = {n for s in deck.statements if s.keyword not in (*ELEMENT_TYPES, "X") for n in named(s, NODE)}
    said = {s.integer(0): _about(deck.statements, s.integer(0)) for s in elements if s.keyword in BEAMS}
    by_start = {_ends(s)[0]: s for s in elements if s.keyword in BEAMS}
    used: set[int] = set()
    found = []
    for a in elements:
        if a.keyword not in BEAMS or a.integer(0) in used:
            continue
        (p, *_), middle = _ends(a)
        b = by_start.get(middle)
        if b is None or b is a or b.keyword != a.keyword or b.integer(0) in used:
            continue
        behind = 1 + 2 * len(middle)
        alike = a.values[behind:] == b.values[behind:] and said[a.integer(0)] == said[b.integer(0)]
        if not alike or any(len(users[m]) != 2 or m in needed for m in middle):
            continue
        nodes = p, middle[0], _ends(b)[1][0]
        start, m, q = (position.get(n, np.zeros(3)) for n in nodes)
        if np.linalg.norm(np.cross(m - start, q - m)) > IN_LINE * np.linalg.norm(m - start) * np.linalg.norm(q - m):
            continue
        used |= {a.integer(0), b.integer(0)}
        found.append((a.integer(0), b.integer(0), middle))
    return found


def _ends(beam: Statement) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """The nodes at both ends."""
    nodes = named(beam, NODE)
    half = len(nodes) // 2
    return nodes[:half], nodes[half:]


def _about(statements: Sequence[Statement], element: int) -> list[tuple[str, tuple[Value, ...]]] | object:
    """What statements say of an element; when it cannot be merged, an object that equals no other."""
    found = []
    for s in statements:
        if element in named(s, ELEMENT) and s.keyword not in ELEMENT_TYPES:
            if s.keyword in (*CLASSES, *ALIKE) and s.block < 3:
                found.append((s.keyword, s.values[1:]))
            elif s.keyword != "STARTDE" or any(s.reals(2, len(s.values) - 2)):  # zero changes nothing
                return object()
    return sorted(found, key=repr)
