"""What of an input file can be a model of the symbolic part: its elements as rigid parts, sliders, beams, springs
and hinges, and the numbers of its statements. Anything else is refused by a sentence that names it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.mechanism import Mechanism

UNKNOWN = ("USERSIG", "USERINP", "MEE", "XGYRO")
# the places of p, its orientation, q, its orientation among the nodes of an element
PLANAR: dict[str, tuple[int | None, ...]] = {
    "PLBEAM": (0, 1, 2, 3), "PLRBEAM": (0, 1, 2, None), "PLTRUSS": (0, None, 1, None), "PLTOR": (None, 0, None, 1),
}  # fmt: skip
SPATIAL: dict[str, tuple[int | None, ...]] = {
    "BEAM": (0, 1, 2, 3), "RBEAM": (0, 1, 2, None), "TRUSS": (0, None, 1, None), "HINGE": (None, 0, None, 1),
}  # fmt: skip


@dataclass
class Part:
    """An element: number, keyword, position and orientation nodes of p and q (0: none), classes of its modes."""

    number: int
    keyword: str
    nodes: tuple[int, int, int, int]
    classes: tuple[str, ...]
    done: bool = False

    def __str__(self) -> str:
        return f"{self.keyword} {self.number}"

    @property
    def is_truss(self) -> bool:
        """Between two positions, without orientations."""
        return not self.nodes[1] and not self.nodes[3]


@dataclass
class DeckParts:
    """The parts of the deck of a mechanism; `x`, `xd` (nx,) are the first frame of mode 1."""

    mechanism: Mechanism
    x: Array
    xd: Array

    def __post_init__(self) -> None:
        m = self.mechanism
        self.deck, self.numbering, self.reference = m.deck, m.numbering, m.x0
        self.dimension = 2 if self.numbering.planar else 3
        self._refuse()
        self.parts = [self._part(*row) for row in self.numbering.elements]

    def _refuse(self) -> None:
        deck = self.deck
        for statement in deck.of(*UNKNOWN):
            raise UsageError(f"{deck.where(statement)}: {statement.keyword} cannot be exported", "export")
        if self.numbering.nk:
            raise UsageError(f"{deck.source}: kinematic coordinates (rolling) cannot be exported", "export")

    def cannot(self, part: Part, why: str) -> UsageError:
        return UsageError(f"{self.deck.source}: {part} cannot be exported: {why}", "export")

    def _part(self, number: int, keyword: str, _: Any) -> Part:
        ends = PLANAR if self.numbering.planar else SPATIAL
        row = self.numbering.ln[number - 1]
        classes = tuple(_class_at(i - 1, self.numbering.e_class) for i in self.numbering.le[number - 1] if i)
        if keyword not in ends:
            raise self.cannot(Part(number, keyword, (0, 0, 0, 0), ()), f"only {', '.join(ends)} can")
        p, turn_p, q, turn_q = (0 if k is None else int(row[k]) for k in ends[keyword])
        part = Part(number, keyword, (p, turn_p, q, turn_q), classes)
        if not self.kind(part):
            raise self.cannot(part, f"deformations that are {', '.join(classes)} are no link, joint, spring or beam")
        return part

    def kind(self, part: Part) -> str:
        """rigid, slider (a beam of variable length), beam, spring or hinge; "" for anything else."""
        c = part.classes
        if part.keyword == "PLTOR" or (part.keyword == "HINGE" and c[1:] == ("fixed", "fixed")):
            return "hinge"
        if all(k == "fixed" for k in c):
            return "rigid"
        if part.keyword in ("PLTRUSS", "TRUSS") and c[0] in ("dynamic", "calculable"):
            return "spring"
        if part.keyword == "BEAM":
            bent = all(pair in (("fixed",) * 2, ("dynamic",) * 2) for pair in (c[2:4], c[4:6]))
            return "beam" if bent and all(k in ("fixed", "dynamic") for k in c[:2]) else ""
        if part.keyword == "PLBEAM" and c[1:] == ("dynamic", "dynamic") and c[0] in ("fixed", "dynamic"):
            return "beam"
        free = part.keyword == "PLBEAM" and c[0] in ("dynamic", "calculable") and c[1:] == ("fixed", "fixed")
        return "slider" if free else ""

    def values(self, keyword: str, number: int, count: int) -> list[float]:
        """The numbers of a statement about an element or node, zeros behind; several statements are added."""
        total = [0.0] * count
        for s in self.deck.of(keyword, block=2):
            if int(s.values[0]) == number:
                for k, v in enumerate(s.values[1 : count + 1]):
                    total[k] += float(v)
        return total

    def place(self, node: int, x: Any = None) -> np.ndarray:
        x = self.reference if x is None else x
        return np.array([x[i - 1] for i in self.numbering.lnp[node - 1, : self.dimension]], float)

    def row(self, node: int, coordinate: int = 0) -> int:
        """The place of a coordinate in x, from 0."""
        return int(self.numbering.lnp[node - 1, coordinate]) - 1

    def class_of(self, node: int, coordinate: int) -> str:
        return _class_at(self.row(node, coordinate), self.numbering.x_class)


def _class_at(i: int, classes: dict[str, slice]) -> str:
    return next(c for c, s in classes.items() if s.start <= i < s.stop)
