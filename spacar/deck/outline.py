"""What the element statements say about the model: which elements and nodes exist, and what kind they are."""

from __future__ import annotations

from dataclasses import dataclass, field

from spacar.deck.findings import ranges
from spacar.deck.statement import Statement
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import ElementType, coordinates_of


@dataclass(slots=True, eq=False)
class Outline:
    """Elements by number with their types, nodes by number with their roles and the element that uses them first.

    `space` is planar, spatial or "" (no element). `complete` is false when some element statement could not
    be read, so that nodes may be missing here; `broken` holds keyword and first number of the other
    statements that could not be read, `broken_blocks` their blocks: what follows from their absence is not
    reported then. `metre` is the unit of length of the file in metres.
    """

    elements: dict[int, Statement] = field(default_factory=dict)
    types: dict[int, ElementType] = field(default_factory=dict)
    roles: dict[int, str] = field(default_factory=dict)
    users: dict[int, Statement] = field(default_factory=dict)
    space: str = ""
    complete: bool = True
    broken: set[tuple[str, int]] = field(default_factory=set)
    broken_blocks: set[int] = field(default_factory=set)
    metre: float = 1.0

    def coordinates(self, node: int) -> int:
        """Number of coordinates of a node that exists."""
        return coordinates_of(self.roles[node], self.space == "planar")

    def modes(self, element: int) -> int:
        """Number of deformation modes of an element that exists."""
        return len(self.types[element].modes)

    def classed(self, element: int) -> tuple[int, ...]:
        """Modes of an element that exists to which a statement without mode numbers gives a class."""
        return self.types[element].classed if element in self.types else ()

    def independent(self, node: int) -> tuple[int, ...]:
        """Coordinates that a statement without coordinate numbers means: all, but of Euler parameters not lambda0."""
        count = self.coordinates(node)
        return (2, 3, 4) if count == 4 else tuple(range(1, count + 1))

    def missing_element(self, number: int) -> str:
        """Sentence about an element that does not exist."""
        if not self.elements:
            return f"element {number} is not defined; no elements exist"
        verb = "element {} exists" if len(self.elements) == 1 else "elements {} exist"
        return f"element {number} is not defined; {verb.format(ranges(set(self.elements)))}"

    def missing_node(self, number: int) -> str:
        """Sentence about a node that no element uses."""
        return f"node {number} is not used by any element; nodes {ranges(set(self.roles))} exist"

    def add(self, statement: Statement) -> None:
        """Take in an element statement whose arguments are right; first definitions win."""
        kind = ELEMENT_TYPES[statement.keyword]
        number = statement.integer(0)
        if number in self.elements:
            return
        self.elements[number] = statement
        self.types[number] = kind
        self.space = self.space or ("planar" if kind.planar else "spatial")
        for i, role in enumerate(kind.nodes, 1):
            node = statement.integer(i)
            if node not in self.roles:
                self.roles[node] = role
                self.users[node] = statement
