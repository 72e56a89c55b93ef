"""What all checks look at: the statements, the outline of the model and the classes of its coordinates.

Checks that come from the table: statements that may be given once, classes to which a statement may refer.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

from spacar import modes
from spacar.deck.findings import Findings, alternatives
from spacar.deck.keyword_table import KEYWORDS, keyword_of, kind_of
from spacar.deck.outline import Outline
from spacar.deck.statement import Statement, StatementIndex, again
from spacar.deck.table_types import ELEMENT_CLASSES, NODE_CLASSES, BlockKind, Keyword, Purpose, facts

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

    @property
    def analysis(self) -> modes.Mode | None:
        """The row of the mode that the file is checked for, if it is checked for one."""
        return facts(self.mode)

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


OF_A_CLASS = {name for (name, block), row in KEYWORDS.items() if block.number > 1 and (row.classes or row.holonomic)}
"""Keywords that refer to coordinates or deformations of certain classes, in some kind of block."""
_ONCE = {block: {row.name: row.unique for row in KEYWORDS.values() if row.block is block} for block in BlockKind}
_STARTS = ("STARTDX", "STARTDE")  # generators write zero start values for everything


def check_once(scene: CheckMaterial, block: int) -> None:
    """The same thing stated twice is an error: replace or add, the input does not say which."""
    once = _ONCE[kind_of(block, scene.third)]
    for name in scene.index.keywords(block):
        if (count := once[name]) is None:
            continue
        groups = scene.index.groups_of(name, block=block)
        if len(groups) == 1 and groups[0].distinct(count):
            continue
        for s, first in again((s.values[:count], s) for s in chain.from_iterable(groups)):
            what = " ".join(str(v) for v in s.values[1:count]) if count > 0 else ""
            about = f"for {what} " if what else ""
            scene.findings.error(s, None, f"already given {about}at line {first.line}; give it once", "repeated")


def check_classes(scene: CheckMaterial, block: int) -> None:
    """A time function needs a prescribed coordinate, a start value a dynamic one, an output no fixed one, ..."""
    along = scene.analysis is not None and scene.analysis.takes_setpoints
    for name in filter(OF_A_CLASS.__contains__, scene.index.keywords(block)):
        keyword = keyword_of(name, block, scene.third)
        subject = keyword.subject
        if subject is not None and (keyword.classes or keyword.holonomic):
            what = "element" if keyword.of_element else "node"
            right = () if along or keyword.holonomic else keyword.classes
            for group, k, row in scene.index.each(name, block=block):
                if scene.class_of(what, row[subject], row[subject + 1]) not in right:
                    _check_class(scene, block, keyword, group[k], what, subject)


def _check_class(scene: CheckMaterial, block: int, keyword: Keyword, s: Statement, what: str, subject: int) -> None:
    number, index = s.integer(subject), s.integer(subject + 1)
    found = scene.class_of(what, number, index)
    along = scene.analysis is not None and scene.analysis.takes_setpoints
    if scene.doubtful(what, number):
        return
    thing = f"mode {index} of element {number}" if what == "element" else f"coordinate {index} of node {number}"
    if along and block == 2 and found == "dynamic" and "prescribed" in keyword.classes:
        text = f"{thing} is {found}; mode 3 takes its motion from the result along which it linearizes"
        scene.findings.information(s, subject, text, "motion-known")
    elif keyword.classes and found not in keyword.classes:
        by = scene.giver(what, number, index)
        where = f" ({by.keyword} at line {by.line})" if by is not None else ""
        allowed = " or ".join(keyword.classes)
        text = f"{thing} is {found}{where}; {s.keyword} is for a {allowed} one"
        if s.keyword in _STARTS and len(s.values) > subject + 2 and not any(s.reals(subject + 2, 2)):
            text += "; value and rate are zero, the statement has no effect"
            scene.findings.warning(s, subject, text, "wrong-class")
            return
        scene.findings.error(s, subject, text, "wrong-class")
    elif keyword.holonomic and index - 1 in scene.outline.types[number].slips:
        text = f"{thing} is a slip, which has no value of its own; {s.keyword} is for holonomic deformations"
        scene.findings.error(s, subject, text, "wrong-class")


def at_least(findings: Findings, s: Statement, index: int, least: int, what: str) -> None:
    """Error when the integer at `index` is given and below the least value."""
    if index < len(s.values) and s.integer(index) < least:
        findings.error(s, index, f"{what} {s.values[index]} must be at least {least}", "range")


def positive(findings: Findings, s: Statement, index: int, what: str) -> None:
    """Error when the real at `index` is given and not positive."""
    if index < len(s.values) and not s.real(index) > 0.0:
        findings.error(s, index, f"{what} {s.real(index):g} must be positive", "range")


def one_of(findings: Findings, s: Statement, index: int, allowed: tuple[int, ...], what: str) -> None:
    """Error when the integer at `index` is given and not one of the allowed values."""
    if index < len(s.values) and s.integer(index) not in allowed:
        text = f"{what} {s.values[index]} does not exist; allowed: {alternatives(allowed)}"
        findings.error(s, index, text, "choice")


RANGES: dict[str, tuple[tuple[Any, ...], ...]] = {
    "TIMESTEP": ((positive, 0, "length of the time interval"), (at_least, 1, 1, "number of time steps")),
    "ERROR": ((positive, 0, "absolute error"), (positive, 1, "relative error")),
    "ITERSTEP": (
        (at_least, 0, 1, "number of iterations"), (at_least, 1, 1, "number of load steps"),
        (positive, 2, "error tolerance"), (at_least, 3, 1, "number of steps between output steps"),
        (one_of, 4, (0, 1, 2, 3), "type of analysis"),
        (at_least, 5, 0, "number of load steps for the initial solution"),
        (one_of, 6, (0, 1), "follow the equilibrium path"),
    ),
    "MODES": ((at_least, 0, 0, "number of modes"),),
    "XGYRO": ((one_of, 5, (0, 1), "type of rotor"),),
    "TRTIME": (
        (positive, 0, "total time"), (at_least, 1, 1, "number of steps"),
        (at_least, 2, 1, "number of intermediate steps"),
    ),
    "TRFRONT": ((one_of, 1, (0, 1, 2), "front type"),),
}  # fmt: skip
"""Keyword -> checks of single values: the function, what follows the statement in its arguments."""


def check_ranges(findings: Findings, s: Statement) -> None:
    for check, *given in RANGES.get(s.keyword, ()):
        check(findings, s, *given)
