"""What all checks look at: the statements, the outline of the model and the classes of its coordinates."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from spacar import modes
from spacar.deck.findings import Findings
from spacar.deck.keyword_table import KEYWORDS, Keyword, kind_of
from spacar.deck.mode_blocks import Purpose, facts
from spacar.deck.outline import Outline
from spacar.deck.statement import Statement
from spacar.deck.statement_index import StatementIndex
from spacar.deck.table_types import ELEMENT_CLASSES, NODE_CLASSES, BlockKind

Classes = dict[tuple[int, int], tuple[str, Sequence[Statement], int]]
"""(node, coordinate) or (element, mode) -> class, and the statement that says so: some statements and its place."""


@dataclass(slots=True, eq=False)
class CheckMaterial:
    """The material of the checks; `findings` receives the messages of the block that is being checked."""

    index: StatementIndex
    outline: Outline
    mode: Purpose
    third: BlockKind | None
    findings: Findings
    coordinates: Classes = field(default_factory=dict)
    deformations: Classes = field(default_factory=dict)
    analysis: modes.Mode | None = field(init=False)
    """The row of the mode that the file is checked for, if it is checked for one."""

    def __post_init__(self) -> None:
        self.analysis = facts(self.mode)

    def has(self, keywords: Iterable[str], block: int) -> bool:
        """Whether there is a statement with one of these keywords in the block."""
        return not self.index.keywords(block).isdisjoint(keywords)

    def of(self, *keywords: str, block: int | None = None) -> list[Statement]:
        """Statements with one of these keywords, in file order."""
        return self.index.of(*keywords, block=block)

    def row(self, name: str, block: int) -> Keyword:
        """The row of the table that statements with this keyword in a block belong to."""
        return KEYWORDS[name, kind_of(block, self.third)]

    def doubtful(self, what: str, number: int) -> bool:
        """Whether a statement that gives a class to this node or element could not be read."""
        broken, names = self.outline.broken, NODE_CLASSES if what == "node" else ELEMENT_CLASSES
        return bool(broken) and any((name, number) in broken for name in names)

    def class_of(self, what: str, number: int, index: int) -> str:
        """Class of a coordinate ("node") or deformation ("element")."""
        given = (self.coordinates if what == "node" else self.deformations).get((number, index))
        if given is not None:
            return given[0]
        if what == "node":
            return "dynamic" if self.outline.roles.get(number) == "warping" else "calculable"
        kind = self.outline.types.get(number)
        return "calculable" if kind is not None and index in kind.released else "fixed"

    def giver(self, what: str, number: int, index: int) -> Statement | None:
        """The statement that gave a class to a coordinate or deformation, if one did."""
        given = (self.coordinates if what == "node" else self.deformations).get((number, index))
        return None if given is None else given[1][given[2]]
