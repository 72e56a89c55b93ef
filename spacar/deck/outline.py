"""What the element statements say about the model: which elements and nodes exist, and what kind they are."""

from dataclasses import dataclass, field
from itertools import chain, combinations, cycle
from operator import eq

from spacar.deck.findings import ranges
from spacar.deck.statement import Statement, StatementGroup
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import ElementType, coordinates_of, independent_of


@dataclass(slots=True, eq=False)
class Outline:
    """The types of elements by number, nodes by number with their roles, in the order of the file.

    `kinds` are the types that occur, `traits` what any of them has; `regular` is true while every element has a number
    of its own and every node one role, no element has the same node at both ends, and all are planar or all spatial.
    `space` is planar, spatial or "" (no element). `complete` is false when some element statement could not be read, so
    that nodes may be missing here; `broken` holds keyword and first number of the other statements that could not be
    read, `broken_blocks` their blocks: what follows from their absence is not reported then. `metre` is the unit of
    length of the file in metres.
    """

    types: dict[int, ElementType] = field(default_factory=dict)
    roles: dict[int, str] = field(default_factory=dict)
    kinds: dict[ElementType, None] = field(default_factory=dict)
    traits: set[str] = field(default_factory=set)
    regular: bool = True
    space: str = ""
    complete: bool = True
    broken: set[tuple[str, int]] = field(default_factory=set)
    broken_blocks: set[int] = field(default_factory=set)
    metre: float = 1.0
    _elements: dict[int, Statement] = field(default_factory=dict)
    _added: list[StatementGroup] = field(default_factory=list)  # those that `_elements` has not yet
    _users: dict[int, Statement] = field(default_factory=dict)

    @property
    def elements(self) -> dict[int, Statement]:
        """The statements of all elements, also of those that could not be read, by number."""
        for group in self._added:
            self._elements.update(zip(group.columns(0, 1)[0], group, strict=True))
        self._added.clear()
        return self._elements

    def coordinates(self, node: int) -> int:
        """Number of coordinates of a node that exists."""
        return coordinates_of(self.roles[node], self.space == "planar")

    def classed(self, element: int) -> tuple[int, ...]:
        """Modes of an element that exists to which a statement without mode numbers gives a class."""
        return self.types[element].classed if element in self.types else ()

    def independent(self, node: int) -> tuple[int, ...]:
        """Coordinates that a statement without coordinate numbers means: all, but of Euler parameters not lambda0."""
        return independent_of(self.roles[node], self.space == "planar")

    def missing_element(self, number: int) -> str:
        if not self.elements:
            return f"element {number} is not defined; no elements exist"
        verb = "element {} exists" if len(self.elements) == 1 else "elements {} exist"
        return f"element {number} is not defined; {verb.format(ranges(set(self.elements)))}"

    def missing_node(self, number: int) -> str:
        return f"node {number} is not used by any element; nodes {ranges(set(self.roles))} exist"

    def user(self, node: int) -> Statement:
        """The first element that uses a node that exists; asked for by messages only."""
        if not self._users:
            for number, kind in self.types.items():
                s = self.elements[number]
                for used in s.integers(1)[: len(kind.nodes)]:
                    self._users.setdefault(used, s)
        return self._users[node]

    def add(self, group: StatementGroup) -> None:
        """Take in statements of one element type whose arguments are right; first definitions win."""
        kind = ELEMENT_TYPES[group.keyword]
        numbers, *columns = group.columns(0, 1 + len(kind.nodes))
        new = dict.fromkeys(numbers, kind)
        known = self.types.keys() | self._elements.keys() if self._elements else self.types.keys()
        if len(new) < len(numbers) or not known.isdisjoint(new):
            self.regular = False
            for s in group:
                if s.values[0] not in self.elements:
                    self.add(StatementGroup.of(s))
            return
        if self._users:
            self._users.clear()
        self._added.append(group)
        self.types.update(new)
        self.kinds[kind] = None
        self.traits |= kind.traits
        space = "planar" if kind.planar else "spatial"
        self.space = self.space or space
        self.regular &= self.space == space
        roles = self.roles
        for node, role in zip(chain.from_iterable(zip(*columns)), cycle(kind.nodes)):  # noqa: B905
            if roles.setdefault(node, role) != role:
                self.regular = False
        for i, j in combinations(range(len(columns)), 2):
            if kind.nodes[i] == kind.nodes[j] and True in map(eq, columns[i], columns[j]):
                self.regular = False
