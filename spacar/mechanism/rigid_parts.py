"""What a mechanism need not evaluate again and again: elements that cannot move, and rigid bodies of many elements.

    immovable   all nodes are fixed and all deformations calculable: deformations and stresses never change
    body        elements with nothing but fixed deformations that hold their nodes as one rigid body (as many modes as
                relative motions), joined at common nodes without loops; at rest where one point and one orientation of
                it are fixed

A body keeps a master point and a master orientation, and the nodes that other elements use or that a statement names;
ties (a body of two points, a hinge) hold these at the masters, and a mass at the centre of mass with an inertia at the
master orientation moves as the body does. Everything else is left out of the model that is evaluated. An element that a
statement other than its properties names, and a node that one other than X, FIX and XM names, stay.

The deck falls into two: `left` with all that is left out, held at the masters, and `reduced`. Degrees of freedom and
their order are those of the whole. What is left out follows from the motion of the masters
(`spacar.dynamics.left_out`).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count, zip_longest
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.rewrite.references import renumbered
from spacar.deck.statement import Value
from spacar.deck.table_types import ElementType
from spacar.mechanism.numbering import Numbering

PROPERTIES = {"EM", "ESTIFF", "EDAMP", "LDEFORM", "ADEFORM", "ORPINBOD"}
AT_REST = PROPERTIES | {"RLSE", "ESIG"}
OF_NODES = {"X", "FIX", "XM"}


class Body(NamedTuple):
    """Elements that move as one; its masters (0: it has no points); the other nodes that stay; all nodes."""

    elements: tuple[int, ...]
    point: int
    turn: int
    points: tuple[int, ...]
    turns: tuple[int, ...]
    nodes: frozenset[int]
    at_rest: bool

    @property
    def n_ties(self) -> int:
        """With that of the centre of mass, at most."""
        return len(self.points) + len(self.turns) + (self.point > 0 and not self.at_rest)


@dataclass(frozen=True)
class RigidParts:
    """What is left out of a deck: bodies and immovable elements; `gone`: nodes that the reduced model has not got.

    Bodies have the numbers 0 ... of `moving`; the next one is all that rests. In the decks `left` and `stand_in` each
    has nodes of its own: `own[body][node]` are their numbers, and behind them those of the centres of mass.
    """

    deck: Deck
    numbering: Numbering
    bodies: tuple[Body, ...]
    immovable: tuple[int, ...]
    gone: frozenset[int]

    @cached_property
    def moving(self) -> tuple[Body, ...]:
        return tuple(body for body in self.bodies if not body.at_rest)

    @cached_property
    def body_of(self) -> dict[int, int]:
        """The body of every element that is left out."""
        rest = [*self.immovable, *[n for body in self.bodies if body.at_rest for n in body.elements]]
        moving = {number: k for k, body in enumerate(self.moving) for number in body.elements}
        return moving | dict.fromkeys(rest, len(self.moving))

    @cached_property
    def own(self) -> list[dict[int, int]]:
        found: list[dict[int, int]] = [{} for _ in range(len(self.moving) + 1)]
        numbers = count(1)
        for number, _, nodes in self.numbering.elements:
            if number in self.body_of:
                for node in nodes:
                    of = found[self.body_of[number]]
                    of[node] = of[node] if node in of else next(numbers)
        return found

    @cached_property
    def n_own(self) -> int:
        """How many nodes the deck `left` has."""
        return sum(map(len, self.own))

    @cached_property
    def owners(self) -> Index:
        """(n_own + 1, 2) node and body of every node of the deck `left`; the first row belongs to nobody."""
        found = np.zeros((self.n_own + 1, 2), np.int64)
        for body, own in enumerate(self.own):
            for node, number in own.items():
                found[number] = node, body
        return found

    def left(self) -> Deck:
        """All that is left out, with fixed masters."""
        found: list[Statement] = []
        for s in self.deck.statements:
            if s.keyword in ELEMENT_TYPES or s.keyword in AT_REST:
                if s.values and s.values[0] in self.body_of:
                    own = self.own[self.body_of[s.integer(0)]]
                    found += renumbered([s], int, own.__getitem__) if s.keyword in ELEMENT_TYPES else [s]
                elif not s.values:
                    found.append(s)
            elif s.keyword == "X" or (s.keyword == "XM" and s.values[0] in self.gone):
                of = s.integer(0)
                found += [s._replace(values=(own[of], *s.values[1:])) for own in self.own if of in own]
        held = [(body.point, body.turn, own) for body, own in zip(self.moving, self.own, strict=False)]
        numbers = [own[node] for point, turn, own in held for node in (point, turn) if node]
        numbers += [number for node, number in self.own[-1].items() if node in self.fixed]
        return _deck(self.deck, found, [Statement("FIX", (n,), 1, 0) for n in numbers])

    def stand_in(self, x: dict[int, Array], masses: Sequence[tuple[float, Array, Array]]) -> Deck:
        """What takes the place of the bodies: ties, and for each moving one its mass at the centre of mass, with the
        tensor about it. x: positions of nodes."""
        planar = self.numbering.planar
        point, hinge = (_tie_type(planar, turns) for turns in (False, True))
        found: list[Statement] = []
        used: set[tuple[int, int]] = set()
        centre = self.n_own
        for body in self.bodies:
            k = self.body_of[body.elements[0]]
            ties: list[tuple[ElementType, tuple[int, ...]]] = []
            ties += [(point, (body.point, body.turn, n)) for n in body.points]
            ties += [(hinge, (body.turn, n)) for n in body.turns]
            numbers = iter(body.elements)
            for kind, nodes in ties:
                found.append(_element(kind, next(numbers), tuple(self.own[k][n] for n in nodes)))
                used |= {(k, n) for n in nodes}
            if body.at_rest:
                continue
            mass, place, tensor = masses[k]
            master = self.own[k][body.turn]
            if mass:
                centre += 1
                found.append(_element(point, next(numbers), (self.own[k][body.point], master, centre)))
                found.append(Statement("X", (centre, *place.tolist()), 1, 0))
                found.append(Statement("XM", (centre, mass), 2, 0))
                used |= {(k, body.point)}
            if tensor.any():
                found.append(Statement("XM", (master, *tensor.tolist()), 2, 0))
        found += [Statement("X", (self.own[k][n], *x[n].tolist()), 1, 0) for k, n in sorted(used) if n in x]
        return _deck(self.deck, (), found)

    def reduced(self, stand_in: Deck) -> Deck:
        """The deck without what is left out, with what stands in for it."""

        def keep(s: Statement) -> bool:
            if s.keyword in OF_NODES and s.block < 3:
                return s.values[0] not in self.gone
            if s.keyword in ELEMENT_TYPES or s.keyword in AT_REST:
                return not s.values or s.values[0] not in self.body_of
            return s.keyword != "USERINP"  # the reduced model has the same prescribed motion

        first = len(self.numbering.x_places) - self.n_own - 1  # centres of mass become nodes behind all others

        def node(number: int) -> int:
            return int(self.owners[number, 0]) if number <= self.n_own else number + first

        kept = [*filter(keep, self.deck.statements)]
        more = [s for s in stand_in.statements if s.keyword != "X" or s.integer(0) > self.n_own]
        tensors: dict[int, Statement] = {}
        for s in [s for s in kept if s.keyword == "XM"] + [s for s in renumbered(more, int, node) if s.keyword == "XM"]:
            of = s.integer(0)
            if of in tensors:
                pairs = zip_longest(tensors[of].values[1:], s.values[1:], fillvalue=0.0)
                s = s._replace(values=(of, *(float(a) + float(b) for a, b in pairs)))
            tensors[of] = s
        others = [s for s in (*kept, *renumbered(more, int, node)) if s.keyword != "XM"]
        return _deck(self.deck, others, tensors.values())

    @cached_property
    def fixed(self) -> frozenset[int]:
        return frozenset(np.flatnonzero(fixed_nodes(self.numbering)).tolist())


def _deck(deck: Deck, statements: Iterable[Statement], more: Iterable[Statement]) -> Deck:
    return replace(deck, statements=(*statements, *more))


def _tie_type(planar: bool, turns: bool) -> ElementType:
    """The element type that holds a point at a body, or an orientation at another."""
    nodes = ("orientation", "orientation") if turns else ("position", "orientation", "position")
    return next(
        kind for kind in ELEMENT_TYPES.values()
        if kind.planar == planar and kind.nodes == nodes and is_plain(kind) and kind.length != "always"
    )  # fmt: skip


def _element(kind: ElementType, number: int, nodes: tuple[int, ...]) -> Statement:
    """Hinges of space have an axis, about which nothing turns."""
    axis: tuple[Value, ...] = (0.0, 0.0, 1.0) if kind.geometry and "position" not in kind.nodes else ()
    return Statement(kind.keyword, (number, *nodes, *axis), 1, 0)


def fixed_nodes(n: Numbering) -> NDArray[np.bool_]:
    """(1 + highest node,) whether all independent coordinates of a node are fixed."""
    held = n.x_places < n.x_class["fixed"].stop  # absent ones too
    if not n.planar:
        held[n.turning, 0] = True  # lambda0 follows from the others
    return np.asarray(held.all(axis=1) & (n.roles > 0))


def is_plain(kind: ElementType) -> bool:
    """No slips, flow or warping."""
    return kind.supported and not (kind.slips or kind.carries_flow or kind.warping)
