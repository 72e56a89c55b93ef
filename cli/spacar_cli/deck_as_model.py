"""An input file of the numeric core as a model file of the symbolic part, in the plane and in space.

Parts become links of a tree. Orientation nodes that rigid beams join are one frame, a flexible beam has assumed shapes
and is clamped in the frame at p (or q). What meets a part that is there already closes a loop. Frames lie along N in
the reference configuration (theory-planar.md, section 1; theory-spatial.md, section 2). How an orientation turns in
the plane and in space: `deck_by_dimension`.
"""

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar_cli.deck_as_text import MARK, DeckText, Part


class Orientation(NamedTuple):
    """A frame; in the plane also its angle to N and the rate of that, as expressions."""

    frame: str
    angle: str = ""
    rate: str = ""


GROUND = Orientation("N", "0", "0")
# Rank of a part by whether a point and an orientation of it are known, in the plane and in space.
RANKS = {2: ((2, 3), (4, 5)), 3: ((1, 3), (2, 5))}
HELD = ("fixed", "input")
Ends = tuple[int, int, int, int]  # position and orientation node of the root of a beam, and those of its tip


@dataclass
class DeckModel(DeckText, ABC):
    """The tree of the parts of an input file; abstract is what plane and space do apart. `frames`: by node."""

    frames: dict[int, Orientation] = field(default_factory=dict)

    @abstractmethod
    def turn(self, node: int) -> Orientation:
        """The orientation of a node, free to turn when it is new."""

    @abstractmethod
    def same(self, part: Part, node: int, found: Orientation) -> None:
        """An orientation node that has this orientation: named, or a loop when it has one already."""

    @abstractmethod
    def hinge(self, part: Part) -> None:
        """Write a joint between two orientations."""

    @abstractmethod
    def bar(self, part: Part) -> None:
        """Write a rigid truss."""

    @abstractmethod
    def sections(self, part: Part, rotary: Sequence[float]) -> list[Any]:
        """The rotary inertia of the sections of a beam, per length."""

    @abstractmethod
    def rod_inertia(self, part: Part, mass: str, length: str, rotary: Sequence[float]) -> list[Any]:
        """The inertia of a rigid part about its middle."""

    @abstractmethod
    def axes_of(self, part: Part, backwards: bool) -> Array:
        """The axes x', y' (and z') of a beam from its root to its tip as columns."""

    @abstractmethod
    def mounting(self, part: Part, axes: Array) -> list[tuple[int, str]]:
        """Turns (axis, angle) that bring the frame of the root along these axes."""

    @abstractmethod
    def bending(self, part: Part, stiffness: Sequence[float]) -> tuple[list[int], dict[str, Any]]:
        """The directions in which a beam bends, and keys of [[beam]] about bending and twist."""

    def tip(self, number: int, root: Orientation, frame: str) -> Orientation:
        """The orientation of the frame at the tip of a beam."""
        return Orientation(frame)

    @abstractmethod
    def deflection(self, ends: Ends, axes: Array, x: Array) -> tuple[Array, Array]:
        """Place of the tip and rotation (3,) to it from the root, along the axes of the root; complex x is allowed."""

    @abstractmethod
    def drive_orientation(self, node: int) -> None:
        """The prescribed motion of an orientation node, if there is one."""

    @abstractmethod
    def turning_loads(self, node: int) -> None:
        """Lumped inertia and moment of an orientation node."""

    @abstractmethod
    def turned(self, direction: Array, rows: Array) -> Array:
        """The unit vector of a direction of the reference configuration, (steps, d), turned by the coordinates `rows`
        (steps, 4) of an orientation node."""

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
        outputs += [f'"angle{n}" = "{self.frames[n].angle}"' for n in self.turned_about_z()]
        settings = self.mechanism.settings
        if settings.duration is not None:
            self.tables.append(f"[simulate]\ntime = {settings.duration!r}\nsteps = {max(settings.n_steps, 1)}\n")
        lines = [
            f"{MARK} from {json.dumps(self.deck.source)[1:-1]}", "[system]",
            f"title = {json.dumps(self.deck.source)}", f"gravity = {json.dumps(self.vector(g))}", "", "[parameters]",
            *(f"{name} = {value!r}" for name, value in self.parameters.items()), "", "[coordinates]",
            *self.coordinates, "", *self.tables, "[outputs]", *outputs, "",
        ]  # fmt: skip
        return "\n".join(lines)

    def _ground(self) -> None:
        for node in self.numbering.nodes:
            n = node.number
            if node.kind == "orientation":
                if all(self.class_of(n, k) == "fixed" for k in ((0,) if self.dimension == 2 else (1, 2, 3))):
                    self.frames[n] = GROUND
            elif len(held := self._held(n)) == self.dimension:
                self.point(n, "O", [self._given(n, k, "") for k in held])

    def _held(self, node: int) -> list[int]:
        """Coordinates of a position node that are fixed or prescribed."""
        return [k for k in range(self.dimension) if self.class_of(node, k) in HELD]

    def _given(self, node: int, k: int, suffix: str) -> str:
        """The value of such a coordinate."""
        if self.class_of(node, k) == "input":
            return self.driven(node, k)
        return self.parameter(f"{self.axes[k]}{node}{suffix}", float(self.place(node)[k]))

    def _supports(self) -> None:
        """Coordinates that are fixed or prescribed on parts of the tree."""
        for node in self.numbering.nodes:
            n = node.number
            if node.kind == "orientation":
                self.drive_orientation(n)
                continue
            self.float_point(n)
            held = self._held(n)
            for k in held if len(held) < self.dimension else ():
                value, axis = self._given(n, k, "_0"), self.axes[k]
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
            rows = [self.row(n, k) for k in range(self.dimension)]
            if force[rows].any():
                names = self.named(f"F*{n}", force[rows])
                self.table("force", name=f"f{n}", at=self.points[n], vector=self.vector(names))

    def turned_about_z(self) -> list[int]:
        """Orientation nodes of which an output ANGLEn is the only coordinate."""
        return [n for n, found in self.frames.items() if found.frame != "N" and found.angle]

    def inertia(self, name: str, node: int, tensor: Sequence[Any]) -> None:
        """A body without mass at an orientation node that can turn."""
        frame = self.frames[node].frame
        if frame != "N":
            self.table("body", name=name, frame=frame, at="O", mass=0, inertia=tensor)

    def frame(self, name: str, parent: str, turns: Sequence[tuple[int, str]]) -> None:
        """A frame by turns about moving axes."""
        axis, angle = turns[0]
        keys = {"axis": axis, "angle": angle}
        if len(turns) > 1:
            keys = {"axis": "".join(str(axis) for axis, _ in turns), "angle": [angle for _, angle in turns]}
        self.table("frame", name=name, parent=parent, **keys)

    def readiness(self, part: Part) -> tuple[int, int]:
        """What needs no new coordinate first, then what hangs on something that is known."""
        kind = self.kind(part)
        p, turn_p, q, turn_q = part.nodes
        turned, planar = turn_p in self.frames or turn_q in self.frames, self.dimension == 2
        if kind == "spring" or (part.is_truss and not planar):
            rank = 0
        elif kind == "hinge":
            welds = part.classes[0] in HELD and (turn_p in self.frames) != (turn_q in self.frames)
            rank = 6 * welds if planar else 4 if turned else 1
        else:
            rank = RANKS[self.dimension][p in self.points or q in self.points][turned]
        return (rank, -part.number)

    def add(self, part: Part) -> None:
        kind = self.kind(part)
        if kind == "spring":
            self.spring(part)
        elif kind == "hinge":
            self.hinge(part)
        elif part.is_truss:
            self.bar(part)
        else:
            p, _, q, _ = part.nodes
            if q not in self.points:
                self.float_point(p)
            (self._beam if kind == "beam" else self._link)(part)

    def _link(self, part: Part) -> None:
        """A rigid body between p and q."""
        _, turn_p, _, turn_q = part.nodes
        found = self.turn(turn_p if turn_p in self.frames or turn_q not in self.frames else turn_q)
        for node in filter(None, (turn_p, turn_q)):
            self.same(part, node, found)
        self.carry(part, found)

    def carry(self, part: Part, found: Orientation) -> None:
        """The ends of a part in a frame, and its mass."""
        p, _, q, _ = part.nodes
        offset = self.named(f"d*{part.number}", self.span(part))
        self.reach(part, found.frame, p, q, offset)
        n, (rho, *rotary) = part.number, self.values("EM", part.number, 5)
        if not rho and not any(rotary):
            return
        m, L = self.parameter(f"rho{n}", rho), self.parameter(f"L{n}", self.length(part))
        inertia = self.rod_inertia(part, m, L, rotary)
        half = self.vector([f"{v}/2" if v != "0" else v for v in offset])
        self.table("point", name=f"G{n}", base=self.points[p], offset=half, **{"in": found.frame})
        self.table("body", name=f"rod{n}", frame=found.frame, at=f"G{n}", mass=f"{m}*{L}", inertia=inertia)

    def _beam(self, part: Part) -> None:
        """A flexible beam from p, clamped in the frame there; its tip carries the frame at q."""
        n, (p, turn_p, q, turn_q) = part.number, part.nodes
        self.no_preload(part)
        rho, *rotary = self.values("EM", n, 5)
        stiffness = self.values("ESTIFF", n, 6)
        if any(self.values("EDAMP", n, 6)):
            raise self.cannot(part, "its damping EDAMP has no counterpart in the damping of assumed fields")
        if any(stiffness[2 if self.dimension == 2 else 4 :]):
            raise self.cannot(part, "it has shear flexibility")
        unturned = turn_p not in self.frames and turn_q in self.frames
        if backwards := p not in self.points or (q in self.points and unturned):
            p, turn_p, q, turn_q = q, turn_q, p, turn_p
        root, axes = self.turn(turn_p), self.axes_of(part, backwards)
        turns, frame = self.mounting(part, axes), root.frame
        if turns:
            frame = f"F{n}"
            self.frame(frame, root.frame, turns)
        bends, keys = self.bending(part, stiffness)
        if part.classes[0] == "dynamic":
            keys |= {"stretch": 1, "EA": self.parameter(f"EA{n}", stiffness[0])}
        length = self.length(part)
        start, rates = self._amplitudes((p, turn_p, q, turn_q), axes, length, bends, keys)
        self.table(
            "beam", name=f"beam{n}", frame=frame, root=self.points[p], length=self.parameter(f"L{n}", length),
            mass=self.parameter(f"rho{n}", rho), field=self.shapes, start=start, speed_start=rates, **keys,
        )  # fmt: skip
        end = f"beam{n}.tip"
        if turns and turn_q not in self.frames:
            self.frame(f"B{turn_q}", end, [(axis, f"-{angle}") for axis, angle in reversed(turns)])
        self.same(part, turn_q, self.tip(n, root, f"B{turn_q}" if turns else end))
        if q in self.points:
            self.close(end, q)
        else:
            self.points[q] = end
        if any(rotary):  # lumped to the orientation nodes
            each = [f"{v}*L{n}/2" if v not in (0, "0") else v for v in self.sections(part, rotary)]
            for k, node in enumerate((turn_p, turn_q)):
                self.inertia(f"disc{n}_{k}", node, each)

    def _amplitudes(
        self, ends: Ends, axes: Array, length: float, bends: Sequence[int], keys: dict[str, Any]
    ) -> tuple[list[float], list[float]]:
        """Amplitudes and rates that give the tip its start deflection and slope (small against one radian)."""
        import sympy as sp

        from spacar.symbolic.beam_shapes import X, orthogonal

        shapes = orthogonal(2)(X, sp.Float(length))  # the two lowest default ones
        A = np.array([[float(psi.diff(X, k).subs(X, length)) for psi in shapes] for k in (0, 1)])

        def found(x: Array) -> Array:
            place, turn = self.deflection(ends, axes, x)
            values: list[Any] = []
            for axis in bends:
                slope = turn[2] if axis == 2 else -turn[1]
                values += [*np.linalg.solve(A, np.array([place[axis - 1], slope])), *[0.0] * (self.shapes - 2)]
            values += [turn[0]] if "twist" in keys else []
            chord = np.sqrt(place @ place) if self.dimension == 2 else place[0]
            return np.array([*values, chord - length] if "stretch" in keys else values)

        now, rate = with_rate(found, self.x, self.xd)
        return now.tolist(), rate.tolist()


def with_rate(function: Callable[[Array], Any], x: Array, xd: Array) -> tuple[Any, Any]:
    """A function of x and its rate along xd, by a complex step."""
    step = 1e-30
    return function(np.asarray(x)), np.imag(function(x + 1j * step * xd)) / step
