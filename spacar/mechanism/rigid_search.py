"""Finds the rigid parts of a mechanism (`spacar.mechanism.rigid_parts`)."""

from collections import deque
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.deck import ELEMENT_TYPES, Deck
from spacar.deck.rewrite.references import ELEMENT, NODE, places
from spacar.deck.table_types import ElementType
from spacar.mechanism.mechanism import Mechanism
from spacar.mechanism.numbering import Numbering
from spacar.mechanism.rigid_parts import AT_REST, OF_NODES, PROPERTIES, Body, RigidParts, fixed_nodes, is_plain
from spacar.modes import Mode

# Making the reduced model takes some milliseconds, an element 0.1 to 1 microsecond of a right-hand side in C: below
# these numbers of elements nothing can be gained.
LEAST = 8
LEAST_SHARE = 0.1  # of all elements
MOST_LINEARIZED = 200  # degrees of freedom of which matrices and transfer functions are stored; of more the sparse form


class Member(NamedTuple):
    """An element of a body: its position and orientation nodes, and how many deformations it has."""

    points: tuple[int, ...]
    turns: tuple[int, ...]
    modes: int


def rigid_parts(mechanism: Mechanism, mode: Mode) -> RigidParts | None:
    """What the evaluation of a mechanism in a mode need not know, or None where that is not worth while.

    Nothing is left out where a user function sees all coordinates, the mechanism is over- or underconstrained, gravity
    changes with the load steps, or second derivatives, sparse forms or a stored motion of all coordinates are asked
    for.
    """
    n, settings = mechanism.numbering, mechanism.settings
    fixed = fixed_nodes(n)
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


def _most(n: Numbering, fixed: NDArray[np.bool_]) -> int:
    found = 0
    for rows in n.types:
        if is_plain(rows.kind):
            e = n.e_places[rows.numbers, : len(rows.kind.modes)]
            rigid = _is_body(rows.kind) & (e < n.e_class["fixed"].stop).all(axis=1)
            found += int(np.count_nonzero(rigid | fixed[rows.nodes].all(axis=1)))
    return found


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
            if not is_plain(kind):
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
                # it must share an orientation with the body, and a point, where both have points
                apart = len(new_turns) == len(set(member.turns))
                if chosen and (apart or (points and member.points and len(new_points) == len(set(member.points)))):
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
