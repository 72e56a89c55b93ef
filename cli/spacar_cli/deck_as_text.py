"""What the planar and the spatial export of an input file share: the text of a model file, points, springs, supports,
masses and forces. Numbers become parameters with the number of their element or node."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from spacar_cli.deck_parts import DeckParts, Part

MARK = "# made by spacar symbolic export"


@dataclass
class DeckText(DeckParts, ABC):
    """The text of a model file that is made from the first frame of a run of mode 1; `shapes` in a flexible beam."""

    shapes: int = 2
    parameters: dict[str, float] = field(default_factory=dict)
    coordinates: list[str] = field(default_factory=list)
    tables: list[str] = field(default_factory=list)
    points: dict[int, str] = field(default_factory=dict)

    @property
    def axes(self) -> str:
        return "xyz"[: self.dimension]

    # -- what planar and spatial models do in their own way ------------------------------------------------------

    @abstractmethod
    def add(self, part: Part) -> None:
        """Write an element as a part of the tree."""

    @abstractmethod
    def readiness(self, part: Part) -> tuple[int, int]:
        """The part with the largest value is taken next."""

    @abstractmethod
    def orientation(self, node: int) -> None:
        """An orientation node of the ground, if it is one."""

    @abstractmethod
    def drive_orientation(self, node: int) -> None:
        """The prescribed motion of an orientation node, if there is one."""

    @abstractmethod
    def turning_loads(self, node: int) -> None:
        """Lumped inertia and moment of an orientation node."""

    @abstractmethod
    def turning_outputs(self) -> list[str]:
        """Lines of [outputs] about orientations."""

    @abstractmethod
    def turned_about_z(self) -> list[int]:
        """Orientation nodes of which an output ANGLEn is the only coordinate."""

    @abstractmethod
    def turned(self, direction: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """The unit vector of a direction of the reference configuration, (steps, d), turned by the coordinates `rows`
        (steps, 4) of an orientation node."""

    # -- the file ------------------------------------------------------------------------------------------------

    def text(self) -> str:
        """The model file. Raises UsageError for an element or statement that cannot be exported."""
        self._ground()
        while open_parts := [p for p in self.parts if not p.done]:
            part = max(open_parts, key=self.readiness)
            part.done = True
            self.add(part)
        self._supports()
        self._masses_and_forces()
        gravity = zip("xyz", [float(v) for v in self.mechanism.loads.gravity], strict=False)
        g = [self.parameter(f"g{axis}", value) for axis, value in gravity]
        outputs = [f'"{p}.{a}" = "{p}.{a}"' for p in self.points.values() for a in self.axes]
        settings = self.mechanism.settings
        if settings.duration is not None:
            self.tables.append(f"[simulate]\ntime = {settings.duration!r}\nsteps = {max(settings.n_steps, 1)}\n")
        lines = [
            f"{MARK} from {json.dumps(self.deck.source)[1:-1]}", "[system]",
            f"title = {json.dumps(self.deck.source)}", f"gravity = {json.dumps(self.vector(g))}", "", "[parameters]",
            *(f"{name} = {value!r}" for name, value in self.parameters.items()), "", "[coordinates]",
            *self.coordinates, "", *self.tables, "[outputs]", *outputs, *self.turning_outputs(), "",
        ]  # fmt: skip
        return "\n".join(lines)

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
        i = int(self.numbering.lnp[node - 1, coordinate]) - 1
        row = self.mechanism.drive.x[i - self.numbering.x_class["input"].start]  # type: ignore[attr-defined]
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

    def _ground(self) -> None:
        for node in self.numbering.nodes:
            n = node.number
            if node.kind == "orientation":
                self.orientation(n)
                continue
            kinds = [self.class_of(n, k) for k in range(self.dimension)]
            if all(kind in ("fixed", "input") for kind in kinds):
                where = self.place(n)
                self.point(n, "O", [
                    self.parameter(f"{axis}{n}", where[k]) if kind == "fixed" else self.driven(n, k)
                    for k, (axis, kind) in enumerate(zip(self.axes, kinds, strict=True))
                ])  # fmt: skip

    def point(self, node: int, base: str, offset: list[str], frame: str | None = None) -> None:
        self.points[node] = f"P{node}"
        self.table("point", name=f"P{node}", base=base, offset=self.vector(offset), **({"in": frame} if frame else {}))

    def float_point(self, node: int) -> None:
        """A node that hangs on nothing: its coordinates."""
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

    def distance(self, part: Part) -> None:
        """The nodes of a rigid truss without mass keep their distance."""
        p, _, q, _ = part.nodes
        a, b = self.points[p], self.points[q]
        L = self.parameter(f"L{part.number}", float(np.linalg.norm(self.span(part))))
        squares = " + ".join(f"({b}.{axis} - {a}.{axis})**2" for axis in self.axes)
        self.table("constraint", expression=f"({squares} - {L}**2)/(2*{L})")

    # -- springs -------------------------------------------------------------------------------------------------

    def spring(self, part: Part) -> None:
        """An elastic truss without mass."""
        p, _, q, _ = part.nodes
        for node in (p, q):
            if node not in self.points:
                self.float_point(node)
        if self.values("EM", part.number, 1)[0]:
            raise self.cannot(part, "an elastic truss with mass is none of the beams with assumed shapes")
        self.elastic(part, float(np.linalg.norm(self.span(part))))

    def elastic(self, part: Part, length: float) -> None:
        """Force (EA e + EdA ė)/l0 along the line pq."""
        n = part.number
        self.no_preload(part)
        stiffness, damping = self.values("ESTIFF", n, 1)[0], self.values("EDAMP", n, 1)[0]
        if not stiffness and not damping:
            return
        k, c, L = (self.parameter(f"{a}{n}", v) for a, v in (("EA", stiffness), ("EdA", damping), ("L", length)))
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

    # -- supports, masses, forces --------------------------------------------------------------------------------

    def _supports(self) -> None:
        """Coordinates that are fixed or prescribed on parts of the tree."""
        for node in self.numbering.nodes:
            n = node.number
            if node.kind == "orientation":
                self.drive_orientation(n)
                continue
            kinds = [self.class_of(n, k) for k in range(self.dimension)]
            if n not in self.points:
                self.float_point(n)
            if all(kind in ("fixed", "input") for kind in kinds):
                continue
            for k, (axis, kind) in enumerate(zip(self.axes, kinds, strict=True)):
                if kind in ("fixed", "input"):
                    value = self.driven(n, k) if kind == "input" else self.parameter(
                        f"{axis}{n}_0", float(self.place(n)[k])
                    )  # fmt: skip
                    tail = "" if value == "0" else f" - ({value})"
                    self.table("constraint", name=f"guide{n}_{axis}", expression=f"{self.points[n]}.{axis}{tail}")

    def _masses_and_forces(self) -> None:
        force = self.mechanism.loads.force
        for node in self.numbering.nodes:
            n = node.number
            if node.kind == "orientation":
                self.turning_loads(n)
                continue
            mass = self.values("XM", n, 1)[0]
            if mass:
                self.table("body", name=f"mass{n}", at=self.points[n], mass=self.parameter(f"m{n}", mass))
            rows = [int(i) - 1 for i in self.numbering.lnp[n - 1, : self.dimension]]
            if force[rows].any():
                names = self.named(f"F*{n}", force[rows])
                self.table("force", name=f"f{n}", at=self.points[n], vector=self.vector(names))
