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

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.rewrite.references import ELEMENT, NODE, places, renumbered
from spacar.deck.statement import Value
from spacar.deck.table_types import ElementType
from spacar.mechanism.mechanism import Mechanism
from spacar.mechanism.numbering import Numbering
from spacar.modes import Mode

# Making the reduced model takes some milliseconds, an element 0.1 to 1 microsecond of a right-hand side in C: below
# these numbers of elements nothing can be gained.
LEAST = 8
LEAST_SHARE = 0.1  # of all elements
MOST_LINEARIZED = 200  # degrees of freedom of which matrices and transfer functions are stored; of more the sparse form
PROPERTIES = {"EM", "ESTIFF", "EDAMP", "LDEFORM", "ADEFORM", "ORPINBOD"}
AT_REST = PROPERTIES | {"RLSE", "ESIG"}
OF_NODES = {"X", "FIX", "XM"}


class Member(NamedTuple):
    """An element of a body: its position and orientation nodes, and how many deformations it has."""

    points: tuple[int, ...]
    turns: tuple[int, ...]
    modes: int


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
            tensors[of] = s._replace(values=(of, *_sum(tensors[of].values[1:], s.values[1:]))) if of in tensors else s
        others = [s for s in (*kept, *renumbered(more, int, node)) if s.keyword != "XM"]
        return _deck(self.deck, others, tensors.values())

    @cached_property
    def fixed(self) -> frozenset[int]:
        """Nodes that cannot move."""
        return frozenset(np.flatnonzero(_fixed_nodes(self.numbering)).tolist())


def rigid_parts(mechanism: Mechanism, mode: Mode) -> RigidParts | None:
    """What the evaluation of a mechanism in a mode need not know, or None where that is not worth while.

    Nothing is left out where a user function sees all coordinates, the mechanism is over- or underconstrained, gravity
    changes with the load steps, or second derivatives, sparse forms or a stored motion of all coordinates are asked
    for.
    """
    n, settings = mechanism.numbering, mechanism.settings
    fixed = _fixed_nodes(n)
    if _most(n, fixed) < max(LEAST, LEAST_SHARE * sum(len(rows.numbers) for rows in n.types)):
        return None
    tensors = settings.sbd_level not in (None, 0, 1) or settings.log_level not in (0, 1)
    large = (mode.linearized or mode.buckling) and n.nddof > MOST_LINEARIZED
    changing = mechanism.additional is not None and mechanism.additional.gravity.any()
    if mode.buckling and settings.sbd_level == 0:  # compliances of what is left out follow from transfer functions
        return None
    if not mode.forces or mode.takes_setpoints or tensors or large or changing:
        return None
    if mechanism.user_signal is not None or not n.is_square:
        return None
    # the parts n0 and g0 of the stiffness of moving equations are those of the elements, only their sum of the bodies
    split = mode.linearized and (mode.timed or len(n.rheonomic) > 0)
    return _Search(mechanism.deck, n, frozenset(np.flatnonzero(fixed).tolist())).found(only_at_rest=split)


def _fixed_nodes(n: Numbering) -> NDArray[np.bool_]:
    """(1 + highest node,) whether all independent coordinates of a node are fixed."""
    held = n.x_places < n.x_class["fixed"].stop  # absent ones too
    if not n.planar:
        held[n.turning, 0] = True  # lambda0 follows from the others
    return np.asarray(held.all(axis=1) & (n.roles > 0))


def _most(n: Numbering, fixed: NDArray[np.bool_]) -> int:
    """How many elements could be left out."""
    found = 0
    for rows in n.types:
        if _is_plain(rows.kind):
            e = n.e_places[rows.numbers, : len(rows.kind.modes)]
            rigid = _is_body(rows.kind) & (e < n.e_class["fixed"].stop).all(axis=1)
            found += int(np.count_nonzero(rigid | fixed[rows.nodes].all(axis=1)))
    return found


def _is_plain(kind: ElementType) -> bool:
    """No slips, flow or warping."""
    return kind.supported and not (kind.slips or kind.carries_flow or kind.warping)


def _is_body(kind: ElementType) -> bool:
    """Without deformation the nodes are one rigid body with an orientation."""
    points, turns = kind.nodes.count("position"), kind.nodes.count("orientation")
    of_point, of_turn = (2, 1) if kind.planar else (3, 3)
    free = of_turn + (of_point if points else 0)
    return turns > 0 and of_point * points + of_turn * turns - len(kind.modes) == free


class _Search:
    """Finds the parts of one deck."""

    def __init__(self, deck: Deck, numbering: Numbering, fixed: frozenset[int]) -> None:
        self.deck, self.numbering, self.fixed = deck, numbering, fixed
        self.size = (2, 1) if numbering.planar else (3, 3)
        self.role = numbering.roles.tolist()
        calculable, x = numbering.x_class["calculable"], numbering.x_places
        free = ((x >= calculable.start) & (x < calculable.stop) | (x < 0)).all(axis=1).tolist()
        self.rank = [(node not in fixed, free[node]) for node in range(len(free))]
        self.nodes: set[int] = set()  # that a statement names
        self.named: set[int] = set()  # elements that one other than their properties names
        self.bound: set[int] = set()  # elements that one names which no element at rest may have
        for s in deck.statements:
            if s.keyword in ELEMENT_TYPES and s.block == 1:
                continue
            for i, kind in places(s):
                number = s.integer(i)
                if kind != ELEMENT and (s.keyword not in OF_NODES or (s.keyword == "FIX" and number not in fixed)):
                    self.nodes.add(number)
                if kind != NODE and s.keyword not in PROPERTIES:
                    self.named.add(number)
                if kind != NODE and s.keyword not in AT_REST:
                    self.bound.add(number)
        self.resting = fixed - self.nodes
        self.nodes_of = {number: nodes for number, _, nodes in numbering.elements}

    def found(self, only_at_rest: bool) -> RigidParts | None:
        immovable, members = self._candidates()
        grown = [part for part in self._grown(members) if not only_at_rest or self._at_rest(part[1])]
        used = self._used(grown, immovable)
        grown = [part for part in grown if self._body(*part, used).n_ties < len(part[0])]
        used = self._used(grown, immovable)
        bodies = tuple(self._body(*part, used) for part in grown)
        saved = len(immovable) + sum(len(body.elements) - body.n_ties for body in bodies)
        if saved < max(LEAST, LEAST_SHARE * len(self.nodes_of)):
            return None
        stay = set(used)
        for body in bodies:
            if body.n_ties:
                stay |= {*body.points, *body.turns, body.turn}
                stay |= {body.point} if body.points or not body.at_rest else set()
        left = {n for body in bodies for n in body.nodes} | {n for e in immovable for n in self.nodes_of[e]}
        if not used or (self.nodes & left) - stay:  # what a statement names must be there
            return None
        return RigidParts(self.deck, self.numbering, bodies, tuple(immovable), frozenset(left - stay))

    def _candidates(self) -> tuple[list[int], dict[int, Member]]:
        """Elements that cannot move, and those that may be members of a body."""
        n = self.numbering
        end, calculable = n.e_class["fixed"].stop, n.e_class["calculable"].start
        immovable: list[int] = []
        members: dict[int, Member] = {}
        for rows in n.types:
            kind = rows.kind
            if not _is_plain(kind):
                continue
            e = n.e_places[rows.numbers, : len(kind.modes)]
            rigid = (e < end).all(axis=1) & _is_body(kind)
            free = (e >= calculable).all(axis=1)
            points, turns = ([i for i, r in enumerate(kind.nodes) if r == role] for role in ("position", "orientation"))
            for k, (number, nodes) in enumerate(zip(rows.numbers.tolist(), rows.nodes.tolist(), strict=True)):
                if rigid[k] and number not in self.named:
                    own = tuple(nodes[i] for i in points), tuple(nodes[i] for i in turns)
                    members[number] = Member(*own, len(kind.modes))
                elif free[k] and number not in self.bound and self.resting.issuperset(nodes):
                    immovable.append(number)
        return immovable, members

    def _grown(self, members: dict[int, Member]) -> Iterable[tuple[tuple[int, ...], frozenset[int]]]:
        """Elements and nodes of bodies without loops."""
        users: dict[int, list[int]] = {}
        for number, member in members.items():
            for node in (*member.points, *member.turns):
                users.setdefault(node, []).append(number)
        while members:
            waiting = deque([next(iter(members))])
            points, turns, chosen = set[int](), set[int](), list[int]()
            while waiting:
                number = waiting.popleft()
                if number not in members:
                    continue
                member = members[number]
                new_points, new_turns = set(member.points) - points, set(member.turns) - turns
                if chosen and not self._joins(member, new_points, new_turns, bool(points)):
                    continue
                del members[number]
                first = self.size[0] if member.points and not points else 0
                count = self.size[0] * len(new_points) + self.size[1] * len(new_turns) - first
                if chosen and count != member.modes:
                    continue  # a loop: this element stays
                chosen.append(number)
                points |= new_points
                turns |= new_turns
                waiting.extend([other for node in (*new_points, *new_turns) for other in users[node]])
            if len(points & self.fixed) < 2 and len(turns & self.fixed) < 2:
                yield tuple(sorted(chosen)), frozenset(points | turns)

    @staticmethod
    def _joins(member: Member, new_points: set[int], new_turns: set[int], has_points: bool) -> bool:
        """Does it share an orientation with a body, and a point, where both have points?"""
        if len(new_turns) == len(set(member.turns)):
            return False
        return not (member.points and has_points) or len(new_points) < len(set(member.points))

    def _used(self, grown: Sequence[tuple[tuple[int, ...], frozenset[int]]], immovable: Sequence[int]) -> set[int]:
        """Nodes of the elements that stay, and those that several bodies share."""
        left = {*immovable, *[n for elements, _ in grown for n in elements]}
        used = {node for number, nodes in self.nodes_of.items() if number not in left for node in nodes}
        rest = {node for number in immovable for node in self.nodes_of[number]}
        moving: set[int] = set()
        for _, nodes in grown:
            if self._at_rest(nodes):
                rest |= nodes
            else:
                used |= moving & nodes
                moving |= nodes
        return used | (moving & rest)

    def _at_rest(self, nodes: Iterable[int]) -> bool:
        """Are a point and an orientation fixed, or an orientation where there are no points?"""
        return {self.role[node] for node in self.fixed.intersection(nodes)} == {self.role[node] for node in nodes}

    def _body(self, elements: tuple[int, ...], nodes: frozenset[int], used: set[int]) -> Body:
        """Its masters are fixed ones, else those whose coordinates are not all calculable, if it has any."""
        kept = nodes & (used | self.nodes)
        points, turns = (sorted(node for node in nodes if self.role[node] == role) for role in (1, 2))
        point, turn = (min(own, key=lambda n: (self.rank[n], n not in kept), default=0) for own in (points, turns))
        others, other_turns = (tuple(n for n in own if n in kept and n not in (point, turn)) for own in (points, turns))
        return Body(elements, point, turn, others, other_turns, nodes, self._at_rest(nodes))


def _deck(deck: Deck, statements: Iterable[Statement], more: Iterable[Statement]) -> Deck:
    """The deck with other statements."""
    return replace(deck, statements=(*statements, *more))


def _tie_type(planar: bool, turns: bool) -> ElementType:
    """The element type that holds a point at a body, or an orientation at another."""
    nodes = ("orientation", "orientation") if turns else ("position", "orientation", "position")
    return next(
        kind for kind in ELEMENT_TYPES.values()
        if kind.planar == planar and kind.nodes == nodes and _is_plain(kind) and kind.length != "always"
    )  # fmt: skip


def _element(kind: ElementType, number: int, nodes: tuple[int, ...]) -> Statement:
    """Hinges of space have an axis, about which nothing turns."""
    axis: tuple[Value, ...] = (0.0, 0.0, 1.0) if kind.geometry and "position" not in kind.nodes else ()
    return Statement(kind.keyword, (number, *nodes, *axis), 1, 0)


def _sum(a: Sequence[Value], b: Sequence[Value]) -> tuple[Value, ...]:
    """Values of two statements together."""
    size = max(len(a), len(b))
    first, second = ([*map(float, values), *[0.0] * (size - len(values))] for values in (a, b))
    return tuple(u + v for u, v in zip(first, second, strict=True))
