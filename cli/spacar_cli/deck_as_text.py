"""Lines of a model file that is made of an input file: parameters, tables, points, springs. Numbers become parameters
with the number of their element or node. What is between the points: `deck_as_model`."""

import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from spacar_cli.deck_parts import DeckParts, Part

MARK = "# made by spacar symbolic export"


@dataclass
class DeckText(DeckParts):
    """The text of a model file that is made from the first frame of a run of mode 1; `shapes` in a flexible beam."""

    shapes: int = 2
    parameters: dict[str, float] = field(default_factory=dict)
    coordinates: list[str] = field(default_factory=list)
    tables: list[str] = field(default_factory=list)
    points: dict[int, str] = field(default_factory=dict)

    @property
    def axes(self) -> str:
        return "xyz"[: self.dimension]

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

    # -- points --------------------------------------------------------------------------------------------------

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

    # -- springs -------------------------------------------------------------------------------------------------

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
