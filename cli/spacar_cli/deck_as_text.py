"""Lines of a model file that is made of an input file: parameters, tables, points, springs. Numbers become parameters
with the number of their element or node. What is between the points: `deck_as_model`.

The elements are rigid parts, sliders, beams, springs and hinges. Anything else is refused by a sentence that names it.
"""

import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES
from spacar.errors import UsageError
from spacar.mechanism import Mechanism

MARK = "# made by spacar symbolic export"

UNKNOWN = ("USERSIG", "USERINP", "MEE", "XGYRO")
EXPORTED = {2: ("PLBEAM", "PLRBEAM", "PLTRUSS", "PLTOR"), 3: ("BEAM", "RBEAM", "TRUSS", "HINGE")}  # by dimension


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
class DeckText:
    """The text of a model file of the first frame x, xd (nx,) of a run of mode 1; `shapes` in a flexible beam."""

    mechanism: Mechanism
    x: Array
    xd: Array
    shapes: int = 2
    parameters: dict[str, float] = field(default_factory=dict)
    coordinates: list[str] = field(default_factory=list)
    tables: list[str] = field(default_factory=list)
    points: dict[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        m = self.mechanism
        self.deck, self.numbering, self.reference = m.deck, m.numbering, m.x0
        self.dimension = 2 if self.numbering.planar else 3
        self.axes = "xyz"[: self.dimension]
        for statement in self.deck.of(*UNKNOWN):
            raise UsageError(f"{self.deck.where(statement)}: {statement.keyword} cannot be exported", "export")
        if self.numbering.nk:
            raise UsageError(f"{self.deck.source}: kinematic coordinates (rolling) cannot be exported", "export")
        self.parts = [self._part(*row) for row in self.numbering.elements]

    def cannot(self, part: Part, why: str) -> UsageError:
        return UsageError(f"{self.deck.source}: {part} cannot be exported: {why}", "export")

    def _part(self, number: int, keyword: str, _: Any) -> Part:
        row = self.numbering.ln[number - 1]
        classes = tuple(_class_at(i - 1, self.numbering.e_class) for i in self.numbering.le[number - 1] if i)
        known = EXPORTED[self.dimension]
        if keyword not in known:
            raise self.cannot(Part(number, keyword, (0, 0, 0, 0), ()), f"only {', '.join(known)} can")
        p, turn_p, q, turn_q = (0 if k is None else int(row[k]) for k in ELEMENT_TYPES[keyword].ends)
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

    def parameter(self, name: str, value: float) -> str:
        """A parameter for a number; 0 stays a number."""
        if value == 0.0:
            return "0"
        self.parameters[name] = float(value)
        return name

    def named(self, stem: str, values: Any) -> list[str]:
        """Parameters STEMx... for the components of a vector."""
        return [self.parameter(stem.replace("*", a), float(v)) for a, v in zip(self.axes, values, strict=True)]

    def vector(self, components: list[str]) -> list[Any]:
        """Three components."""
        return [*components, *[0] * (3 - len(components))]

    def table(self, table: str, **keys: Any) -> None:
        rows = (f"{key} = {json.dumps(value)}" for key, value in keys.items() if value is not None)
        self.tables.append("\n".join([f"[[{table}]]", *rows, ""]))

    def coordinate(self, name: str, start: float, rate: float) -> None:
        row = f'{{ speed = "{name}_t", start = {float(start)!r}, speed_start = {float(rate)!r} }}'
        self.coordinates.append(f"{name} = {row}")

    def driven(self, node: int, coordinate: int) -> str:
        """The prescribed value of a coordinate as an expression in t."""
        i = self.row(node, coordinate) - self.numbering.x_class["input"].start
        row = self.mechanism.drive.x[i]  # type: ignore[attr-defined]
        return self._polynomial(f"{node}_{coordinate + 1}", row)

    def driven_deformation(self, part: Part) -> str:
        """The prescribed value of the first deformation of an element as an expression in t."""
        i = int(self.numbering.le[part.number - 1, 0]) - 1 - self.numbering.e_class["input"].start
        return self._polynomial(f"_e{part.number}", self.mechanism.drive.e[i])  # type: ignore[attr-defined]

    def _polynomial(self, stem: str, row: Any) -> str:
        names = [self.parameter(f"{kind}{stem}", v) for kind, v in zip(("start", "rate", "rise"), row, strict=True)]
        units = ("", "*t", "*t**2/2")
        return " + ".join(n + unit for n, unit in zip(names, units, strict=True) if n != "0") or "0"

    def point(self, node: int, base: str, offset: list[str], frame: str | None = None) -> None:
        self.points[node] = f"P{node}"
        self.table("point", name=f"P{node}", base=base, offset=self.vector(offset), **({"in": frame} if frame else {}))

    def float_point(self, node: int) -> None:
        """The coordinates of a node, where it hangs on nothing yet."""
        if node in self.points:
            return
        for axis, now, rate in zip(self.axes, self.place(node, self.x), self.place(node, self.xd), strict=True):
            self.coordinate(f"{axis}{node}", now, rate)
        self.point(node, "O", [f"{axis}{node}" for axis in self.axes])

    def reach(self, part: Part, frame: str, p: int, q: int, offset: list[str]) -> None:
        """The other end of a rigid part; where it is known, a loop."""
        if q not in self.points:
            self.point(q, self.points[p], offset, frame)
        elif p not in self.points:
            self.point(p, self.points[q], [f"-{v}" if v != "0" else v for v in offset], frame)
        else:
            end = f"C{part.number}"
            self.table("point", name=end, base=self.points[p], offset=self.vector(offset), **{"in": frame})
            self.close(end, q)

    def close(self, end: str, node: int) -> None:
        """The loop from a point of a part to a node that is known."""
        self.table("close", **{"from": end, "to": self.points[node]}, directions=[k + 1 for k in range(self.dimension)])

    def span(self, part: Part, x: Any = None) -> np.ndarray:
        """From p to q."""
        p, _, q, _ = part.nodes
        return self.place(q, x) - self.place(p, x)

    def length(self, part: Part) -> float:
        return float(np.linalg.norm(self.span(part)))

    def distance(self, part: Part) -> None:
        """The nodes of a rigid truss without mass keep their distance."""
        p, _, q, _ = part.nodes
        a, b = self.points[p], self.points[q]
        L = self.parameter(f"L{part.number}", self.length(part))
        squares = " + ".join(f"({b}.{axis} - {a}.{axis})**2" for axis in self.axes)
        self.table("constraint", expression=f"({squares} - {L}**2)/(2*{L})")

    def spring(self, part: Part) -> None:
        """An elastic truss without mass."""
        for node in (part.nodes[0], part.nodes[2]):
            self.float_point(node)
        if self.values("EM", part.number, 1)[0]:
            raise self.cannot(part, "an elastic truss with mass is none of the beams with assumed shapes")
        self.elastic(part)

    def elastic(self, part: Part) -> None:
        """Force (EA e + EdA ė)/l0 along the line pq."""
        n = part.number
        self.no_preload(part)
        stiffness, damping = self.values("ESTIFF", n, 1)[0], self.values("EDAMP", n, 1)[0]
        if not stiffness and not damping:
            return
        numbers = (("EA", stiffness), ("EdA", damping), ("L", self.length(part)))
        k, c, L = (self.parameter(f"{a}{n}", v) for a, v in numbers)
        p, _, q, _ = part.nodes
        self.table(
            "spring", **{"from": self.points[p], "to": self.points[q]}, stiffness=f"{k}/{L}", length=L,
            damping=f"{c}/{L}",
        )  # fmt: skip

    def no_preload(self, part: Part) -> None:
        if any(self.values("ESIG", part.number, 6)):
            raise self.cannot(part, "it has a preload (ESIG)")

    def joint_law(self, part: Part, angle: str, rate: str) -> str:
        """Stiffness, damping and preload of a hinge as the torque against its rotation; "" for none."""
        n = part.number
        names = [
            self.parameter(f"{stem}{n}", self.values(word, n, 1)[0])
            for stem, word in (("S", "ESTIFF"), ("Sd", "EDAMP"), ("sig", "ESIG"))
        ]
        terms = [f"{names[0]}*({angle})", f"{names[1]}*({rate})", names[2]]
        return " + ".join(t for t, name in zip(terms, names, strict=True) if name != "0")


def _class_at(i: int, classes: dict[str, slice]) -> str:
    return next(c for c, s in classes.items() if s.start <= i < s.stop)
