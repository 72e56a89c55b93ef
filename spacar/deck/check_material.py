"""What all checks look at: the statements, the outline of the model and the classes of its coordinates."""

from __future__ import annotations

from dataclasses import dataclass, field

from spacar import modes
from spacar.deck.findings import Findings
from spacar.deck.keyword_table import Keyword, keyword_of
from spacar.deck.mode_blocks import Purpose, facts
from spacar.deck.outline import Outline
from spacar.deck.statement import Statement
from spacar.deck.table_types import BlockKind

CLASS_KEYWORDS = {"node": ("FIX", "INPUTX", "DYNX", "KINX"), "element": ("RLSE", "INPUTE", "DYNE", "KINE")}
Classes = dict[tuple[int, int], tuple[str, Statement]]
"""(node, coordinate) or (element, mode) -> class and the statement that says so."""


@dataclass(slots=True, eq=False)
class CheckMaterial:
    """The material of the checks; `findings` receives the messages of the block that is being checked."""

    statements: tuple[Statement, ...]
    outline: Outline
    mode: Purpose
    third: BlockKind | None
    findings: Findings
    coordinates: Classes = field(default_factory=dict)
    deformations: Classes = field(default_factory=dict)
    _places: dict[str, list[int]] = field(default_factory=dict)
    _rows: dict[int, list[tuple[Keyword, list[Statement]]]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for place, s in enumerate(self.statements):
            self._places.setdefault(s.keyword, []).append(place)

    @property
    def analysis(self) -> modes.Mode | None:
        """The row of the mode that the file is checked for, if it is checked for one."""
        return facts(self.mode)

    def of(self, *keywords: str, block: int | None = None) -> list[Statement]:
        """Statements with one of these keywords, in file order."""
        given = [places for keyword in keywords if (places := self._places.get(keyword))]
        if not given:
            return []
        places = given[0] if len(given) == 1 else sorted(place for one in given for place in one)
        found = [self.statements[place] for place in places]
        return found if block is None else [s for s in found if s.block == block]

    def keywords(self, block: int) -> list[tuple[Keyword, list[Statement]]]:
        """The rows of the table that statements of a block belong to, with these statements in file order."""
        if block not in self._rows:
            given = {name: statements for name in self._places if (statements := self.of(name, block=block))}
            self._rows[block] = [(keyword_of(name, block, self.third), found) for name, found in given.items()]
        return self._rows[block]

    def doubtful(self, what: str, number: int) -> bool:
        """Whether a statement that gives a class to this node or element could not be read."""
        names = CLASS_KEYWORDS[what]
        return any((name, number) in self.outline.broken for name in names)

    def class_of(self, what: str, number: int, index: int) -> tuple[str, Statement | None]:
        """Class of a coordinate ("node") or deformation ("element") and the statement that gave it."""
        if what == "node":
            default = "dynamic" if self.outline.roles.get(number) == "warping" else "calculable"
            return self.coordinates.get((number, index), (default, None))
        if number in self.outline.types and index in self.outline.types[number].released:
            return "calculable", None
        return self.deformations.get((number, index), ("fixed", None))
